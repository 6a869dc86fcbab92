"""Films with a known truth, as the studies of detection listen to them: scenes and annotated recordings."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..detect.rows import runs_of
from ..errors import RuleError
from ..synth import Truth, film_scene, synthesise, write_scene
from .corpus import Recording
from .matching import Times
from .workers import each_of

LONGEST_GAP_MS, FEWEST_SHOTS = 160.0, 3
"""Annotated onsets no farther apart are a burst, where there are so many: 133 ms are 450 rounds a minute."""

FILM_S, SHOTS, OTHERS = 60.0, (1, 46), (4, 41)
"""How long a random film is, and how many shots and other sounds it holds, drawn evenly from half-open ranges."""
GUN_FREE_EVERY = 4
"""One film in so many has no shot, so that false alarms can be counted where there is no gun."""
UNSEEN = 1_000_000_000

Bursts = tuple[tuple[int, ...], ...]


@dataclass(frozen=True, eq=False)
class Case:
    """A sound file with a known truth: its shots, their levels, and where else each may be said to begin.

    `true_ms`, ascending, `snr_db` and `timed` have shape (shots,). `snr_db` is NaN where it is not known. At
    `forgiven_ms` a detection is neither right nor wrong. Of shots that are not `timed` the truth is unsure by some
    milliseconds. `bursts` are indices into `true_ms`.
    """

    name: str
    path: Path
    true_ms: Times
    snr_db: Times
    timed: NDArray[np.bool_]
    bursts: Bursts = ()
    alternatives_ms: tuple[tuple[float, ...], ...] = ()
    forgiven_ms: tuple[float, ...] = ()


def scenes(folder: Path, into: Path, *, jobs: int = 1) -> Iterator[Case]:
    """Synthesise each scene of a folder into another one, so many at once, and yield it; RuleError for none."""
    files = sorted(folder.glob("*.toml"))
    if not files:
        raise RuleError(f"{folder}: no scene (*.toml) in it")
    for _, case in each_of(partial(_synthesised, into), files, jobs=jobs):
        yield case


def random_films(into: Path, *, films: int, seed: int, jobs: int = 1) -> Iterator[Case]:
    """Synthesise minutes of random film-like sound, so many at once, and yield them; one in four has no shot.

    No training comes to the seeds that they are made from.
    """
    for _, case in each_of(partial(_random_film, into, seed), range(films), jobs=jobs):
        yield case


def recordings(found: Iterable[Recording]) -> Iterator[Case]:
    """Yield each recording as a film of its own; levels are unknown."""
    for recording in found:
        onsets_ms = np.array(recording.onsets_s) * 1000.0
        yield Case(
            name=recording.name,
            path=recording.path,
            true_ms=onsets_ms,
            snr_db=np.full(onsets_ms.size, np.nan),
            timed=np.full(onsets_ms.size, recording.timed),
            bursts=near_each_other(onsets_ms),
        )


def near_each_other(true_ms: Times) -> Bursts:
    """Return the bursts among ascending onsets: runs of at least three with no gap over 160 ms.

    >>> near_each_other(np.array([0.0, 100.0, 200.0, 900.0, 1000.0]))
    ((0, 1, 2),)
    """
    return tuple(tuple(run.tolist()) for run in runs_of(true_ms, LONGEST_GAP_MS) if run.size >= FEWEST_SHOTS)


def _synthesised(into: Path, file: Path) -> Case:
    made = into / file.stem
    truth = synthesise(file, made)
    return _scene(file.stem, made / f"{truth.scene}.wav", truth)


def _random_film(into: Path, seed: int, number: int) -> Case:
    rng = np.random.default_rng([seed, number, 2])
    gun_free = number % GUN_FREE_EVERY == GUN_FREE_EVERY - 1
    shots, others = int(rng.integers(*SHOTS)), int(rng.integers(*OTHERS))
    scene = film_scene(UNSEEN + seed * 10_000 + number, FILM_S, shots, others, gun_free=gun_free)
    made = into / scene.name
    made.mkdir(parents=True)
    return _scene(scene.name, made / f"{scene.name}.wav", write_scene(scene, made))


def _scene(name: str, path: Path, truth: Truth) -> Case:
    members: dict[int, list[int]] = {}
    for index, shot in enumerate(truth.shots):
        if shot.burst is not None:
            members.setdefault(shot.burst, []).append(index)
    return Case(
        name=name,
        path=path,
        true_ms=np.array([shot.onset_s * 1000.0 for shot in truth.shots]),
        snr_db=np.array([shot.snr_db for shot in truth.shots]),
        timed=np.ones(len(truth.shots), bool),
        bursts=tuple(tuple(burst) for burst in members.values()),
        alternatives_ms=tuple(tuple(at * 1000.0 / truth.rate_hz for at in shot.accept_samples) for shot in truth.shots),
        forgiven_ms=tuple(each.at_s * 1000.0 for each in truth.negatives if each.kind == "explosion"),
    )

"""How exactly a timeline follows its film into a new cut, of which there are as many as films are cut for."""

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
import numpy as np

from ..conform import Film, Lost, Placed, find_courses, hear, place
from ..ruleset import load_conform
from ..soundtrack import open_soundtrack
from ..synth import film_scene, write_scene
from ..synth.scene import BurstItem, Scene, ShotItem
from .cuts import CASES, OldFilm, written
from .recut import Recut, Samples

_NEAR_MS = 1.0


class ConformScore(msgspec.Struct, frozen=True):
    """What became of the shots of one recut film.

    `within` of the `surviving` ones were placed within 1 ms, `astray` further off, `lost` not at all; `false` of the
    `removed` ones were placed. `worst_ms` is the largest error of those within or astray.
    """

    name: str
    surviving: int
    within: int
    astray: int
    lost: int
    removed: int
    false: int
    median_ms: float
    worst_ms: float
    stretches: int
    lost_at_s: tuple[float, ...]


def score_all(seed: int, minutes: float) -> Iterator[ConformScore]:
    """Yield the score of each case on a film of so many minutes."""
    with tempfile.TemporaryDirectory(prefix="blastline-") as folder:
        old = made_film(Path(folder), seed, minutes)
        for name in CASES:
            yield score_one(name, old, Path(folder))


def made_film(folder: Path, seed: int, minutes: float) -> OldFilm:
    """Make the old film, with a burst at 600 rpm a minute, and another one half as long to insert from."""
    film = film_scene(seed, minutes * 60.0, round(10 * minutes), round(8 * minutes))
    film = msgspec.structs.replace(film, name="old", shots=film.shots + tuple(_bursts(film)))
    other = film_scene(seed + 1, minutes * 30.0, round(4 * minutes), round(4 * minutes))
    truth = write_scene(film, folder)
    write_scene(msgspec.structs.replace(other, name="other"), folder)
    old, inserted = (_samples(folder / f"{name}.wav") for name in ("old", "other"))
    return OldFilm(folder / "old.wav", old, tuple(shot.onset_s for shot in truth.shots), inserted)


def _bursts(film: Scene) -> Iterator[ShotItem]:
    for start_s in np.arange(30.0, film.duration_s - 10.0, 60.0):
        burst = BurstItem(shots=8, rpm=600.0)
        yield ShotItem(at_s=float(start_s), weapon="smg", environment="street", snr_db=24.0, burst=burst)


def _samples(path: Path) -> Samples:
    with open_soundtrack(path) as track:
        return np.concatenate([clip.heard for clip in track.blocks()])


def score_one(name: str, old: OldFilm, folder: Path) -> ConformScore:
    """Return the score of one case; the new film is written into `folder`."""
    make, copy = CASES[name]
    made = make(old)
    new = written(made, copy, folder)
    with open_soundtrack(old.path) as old_track, open_soundtrack(new) as new_track:
        before, after = hear(old_track, old_track.blocks()), hear(new_track, new_track.blocks())
        return scored(name, made, old.onsets_s, before, after)


def scored(name: str, made: Recut, onsets_s: Sequence[float], old: Film, new: Film) -> ConformScore:
    """Return what conforming makes of the shots of a recut film."""
    courses = find_courses(old, new)
    found = place(onsets_s, courses, old, new, load_conform())
    errors_ms: list[float] = []
    lost_s: list[float] = []
    removed = false = 0
    for old_s, each in zip(onsets_s, found, strict=True):
        true_s = made.true_s(old_s)
        if made.is_unsure(old_s):
            continue
        if true_s is None:
            removed += 1
            false += isinstance(each, Placed)
        elif isinstance(each, Lost):
            lost_s.append(round(old_s, 3))
        else:
            errors_ms.append(float(abs(each.new_s - true_s)) * 1000.0)
    within = sum(error <= _NEAR_MS for error in errors_ms)
    return ConformScore(
        name=name,
        surviving=len(errors_ms) + len(lost_s),
        within=within,
        astray=len(errors_ms) - within,
        lost=len(lost_s),
        removed=removed,
        false=false,
        median_ms=float(np.median(errors_ms)) if errors_ms else 0.0,
        worst_ms=max(errors_ms, default=0.0),
        stretches=len(courses),
        lost_at_s=tuple(lost_s),
    )

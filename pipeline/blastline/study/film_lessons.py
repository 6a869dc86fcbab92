"""Lessons that are whole films: scenes as `blastline synth` makes them, crowded or sparse, with guns and without."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from ..synth import ShotTruth, film_scene, render_scene, truth_of
from .finishing import perhaps_coded, perhaps_cut, without_drowned
from .mixes import MIX_S, RATE_HZ, LessonMaker, Mix, as_16_bit


@dataclass(frozen=True)
class Density:
    """How many shots and other sounds a film of a minute holds, each drawn evenly from a half-open range.

    A film without a gun holds as many of the others as `gun_free` says.
    """

    shots: tuple[int, int]
    negatives: tuple[int, int]
    gun_free: tuple[int, int]


CROWDED = Density(shots=(0, 64), negatives=(8, 70), gun_free=(20, 110))
SPARSE = Density(shots=(0, 7), negatives=(2, 16), gun_free=(3, 18))
"""Sounds that stand alone, as in most of a film: who knows crowded films only takes what stands alone for a shot."""


def synthetic_film(seed: int, density: Density = CROWDED) -> LessonMaker:
    """Return lessons that are scenes as `blastline synth` makes them: bursts, rooms, changing beds, one master.

    Some are cut to begin with a shot or just before it, some to end inside one, as a reel or a trailer may.
    """
    return partial(_synthetic_film, seed, density)


def gun_free_film(seed: int, density: Density = CROWDED) -> LessonMaker:
    """Return lessons that are scenes without a gun, full of what could be taken for one."""
    return partial(_gun_free_film, seed, density)


def _gun_free_film(seed: int, density: Density, number: int) -> Mix:
    rng = np.random.default_rng([seed, number])
    negatives = int(rng.integers(*density.gun_free))
    scene = film_scene(seed * 10_000 + number, MIX_S, 0, negatives, gun_free=True, rate_hz=RATE_HZ)
    audio = render_scene(scene)
    unsure = [each.at_sample for each in truth_of(audio).negatives if each.kind == "explosion"]
    samples = perhaps_coded(as_16_bit(audio.read(0, audio.frames)[:, 0]), rng)
    none = np.zeros(0, np.intp)
    return Mix(samples, none, np.zeros(0), np.array(unsure, np.intp))


def _synthetic_film(seed: int, density: Density, number: int) -> Mix:
    rng = np.random.default_rng([seed, number])
    shots, negatives = int(rng.integers(*density.shots)), int(rng.integers(*density.negatives))
    scene_seed = seed * 10_000 + number
    audio = render_scene(film_scene(scene_seed, MIX_S, shots, negatives, gun_free=shots == 0, rate_hz=RATE_HZ))
    truth = truth_of(audio)
    start = 0
    if truth.shots and rng.random() < 0.3:
        first = truth.shots[int(rng.integers(1 + len(truth.shots) // 4))].onset_sample
        start = max(0, first - int(rng.uniform(0.0, 0.3) ** 2 * RATE_HZ))
    kept = [shot for shot in truth.shots if shot.onset_sample >= start]
    unsure = [at - start for shot in kept for at in shot.accept_samples if at >= start]
    unsure += [n.at_sample - start for n in truth.negatives if n.kind == "explosion" and n.at_sample >= start]
    film = Mix(
        samples=perhaps_coded(as_16_bit(audio.read(start, audio.frames)[:, 0]), rng),
        onsets=np.array([shot.onset_sample - start for shot in kept], np.intp),
        level_db=np.array([shot.snr_db for shot in kept], np.float64),
        unsure=np.array(unsure, np.intp),
    )
    film = without_drowned(film, [[at - start for at in _first_heard(shot)] for shot in kept])
    return perhaps_cut(film, np.random.default_rng([seed, number, 1]))


def _first_heard(shot: ShotTruth) -> tuple[int, ...]:
    return (shot.start_sample, *shot.accept_samples, shot.onset_sample)

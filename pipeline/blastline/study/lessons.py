"""Lessons of single sounds over a bed: minutes without end, synthetic and recorded, each from its own seed.

The verifier learns from these and from whole films (`film_lessons`).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ..synth import (
    NegativeKind,
    designed_negative,
    designed_shot,
    handling,
    jet_shot,
    outdoor_shot,
    plain_bed,
    plain_negative,
    plain_shot,
    random_bed,
    random_negative,
    random_shot,
    soft_step,
)
from .corpus import Recording
from .finishing import perhaps_coded, without_drowned
from .mixes import MIX_S, RATE_HZ, LessonMaker, Levels, Mix, Samples, Sound, mix
from .recorded import SHORTEST_BED_S, by_source, drawn, recorded_bed, recorded_variant

SOUNDS_PER_MIX = 20
LEVELS = Levels(3.0, 40.0)
OUTDOOR_LEVELS = Levels(3.0, 55.0)  # what was recorded near stands out further
BLOWS: tuple[NegativeKind, ...] = (
    "footsteps", "footsteps", "hooves", "hammering", "jackhammer", "machine", "mill", "motor", "ratchet", "rotor",
    "rotor", "typewriter",
)  # fmt: skip
"""What goes on at an even pace, and is no gun."""

SYNTHETIC_SHARE = 0.3  # of the sounds, and of the beds, of a mix of recordings
ARMED_SHARES = (0.0, 0.2, 0.5, 0.8)

Shot = Callable[[np.random.Generator, int], tuple[Samples, tuple[int, ...]]]
"""Makes a shot or a burst, and says where its rounds begin."""


def synthetic_mix(seed: int) -> LessonMaker:
    """Return lessons of synthetic sounds over a synthetic bed."""
    return partial(_synthetic_mix, seed)


def plain_mix(seed: int) -> LessonMaker:
    """Return lessons of shots and swells, clicks, knocks as textbooks draw them, and of others; one in four no shot."""
    return partial(_plain_mix, seed)


def designed_mix(seed: int) -> LessonMaker:
    """Return lessons of shots as designers build them among other sudden sounds; one in four has no shot."""
    return partial(_designed_mix, seed)


def outdoor_mix(seed: int) -> LessonMaker:
    """Return lessons of guns recorded near and outdoors among what hands do near a microphone; one in four no shot."""
    return partial(_outdoor_mix, seed)


def blow_mix(seed: int) -> LessonMaker:
    """Return lessons of any shots among what walks and what strikes again and again; one in four has no shot."""
    return partial(_blow_mix, seed)


def jet_mix(seed: int) -> LessonMaker:
    """Return lessons of guns of much gas, fired again and again, among any other sounds; one in four has no shot."""
    return partial(_jet_mix, seed)


def recorded_mix(recordings: Sequence[Recording], seed: int) -> LessonMaker:
    """Return lessons of recordings, sources drawn evenly, with a share of synthetic sounds and beds among them."""
    shots = by_source(r for r in recordings if r.gunshot)
    negatives = by_source(r for r in recordings if not r.gunshot)
    beds = [r for r in recordings if not r.gunshot and r.duration_s >= SHORTEST_BED_S]
    return partial(_recorded_mix, shots, negatives, beds, seed)


def _synthetic_mix(seed: int, number: int) -> Mix:
    rng = np.random.default_rng([seed, number])
    sounds = [_synthetic_sound(rng, shot=bool(rng.random() < 0.5)) for _ in range(SOUNDS_PER_MIX)]
    return _mixed(random_bed(rng, RATE_HZ, MIX_S), sounds, rng)


def _plain_mix(seed: int, number: int) -> Mix:
    shot = partial(_sound_of, plain_shot)
    return _armed_mix(np.random.default_rng([seed, number]), shot, _plain_negative, _plain_bed)


def _designed_mix(seed: int, number: int) -> Mix:
    shot = partial(_sound_of, designed_shot)
    return _armed_mix(np.random.default_rng([seed, number]), shot, _any_negative, random_bed)


def _outdoor_mix(seed: int, number: int) -> Mix:
    rng = np.random.default_rng([seed, number])
    return _armed_mix(rng, _outdoor_sound, _near_negative, random_bed, levels=OUTDOOR_LEVELS)


def _blow_mix(seed: int, number: int) -> Mix:
    return _armed_mix(np.random.default_rng([seed, number]), _any_shot, _blow, _plain_bed)


def _jet_mix(seed: int, number: int) -> Mix:
    rng = np.random.default_rng([seed, number])
    return _armed_mix(rng, partial(_sound_of, jet_shot), _near_negative, _plain_bed, levels=OUTDOOR_LEVELS)


def _any_shot(rng: np.random.Generator, rate_hz: int) -> Sound:
    shot = (plain_shot, designed_shot, outdoor_shot)[int(rng.integers(3))]
    return Sound(*shot(rng, rate_hz))


def _blow(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a step as it is, or as often a walk or a machine as a microphone hears it."""
    if rng.random() < 0.5:
        return soft_step(rng, rate_hz)
    return random_negative(rng, rate_hz, BLOWS[int(rng.integers(len(BLOWS)))])[0]


def _sound_of(shot: Shot, rng: np.random.Generator, rate_hz: int) -> Sound:
    return Sound(*shot(rng, rate_hz))


def _outdoor_sound(rng: np.random.Generator, rate_hz: int) -> Sound:
    return Sound(*outdoor_shot(rng, rate_hz))


def _armed_mix(
    rng: np.random.Generator,
    shot: Callable[[np.random.Generator, int], Sound],
    negative: Callable[[np.random.Generator, int], Samples],
    bed: Callable[[np.random.Generator, int, float], Samples],
    *,
    levels: Levels = LEVELS,
) -> Mix:
    """Return a mix whose sounds are shots to one of `ARMED_SHARES`, each family drawn by its own function."""
    armed = ARMED_SHARES[int(rng.integers(len(ARMED_SHARES)))]
    sounds = [
        shot(rng, RATE_HZ) if rng.random() < armed else Sound(negative(rng, RATE_HZ)) for _ in range(SOUNDS_PER_MIX)
    ]
    return _mixed(bed(rng, RATE_HZ, MIX_S), sounds, rng, levels=levels)


def _near_negative(rng: np.random.Generator, rate_hz: int) -> Samples:
    return handling(rng, rate_hz) if rng.random() < 0.5 else _any_negative(rng, rate_hz)


def _plain_negative(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return what a textbook draws, or as often anything: a burst of noise is a shot there, and a drum is none."""
    return plain_negative(rng, rate_hz) if rng.random() < 0.5 else _any_negative(rng, rate_hz)


def _plain_bed(rng: np.random.Generator, rate_hz: int, seconds: float) -> Samples:
    """Return a textbook's bed, or as often any: a plain shot may well lie under a film's music."""
    return (plain_bed if rng.random() < 0.5 else random_bed)(rng, rate_hz, seconds)


def _any_negative(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a sudden sound as physics, a designer or a textbook makes it."""
    kind = rng.random()
    if kind < 0.4:
        return random_negative(rng, rate_hz)[0]
    return designed_negative(rng, rate_hz) if kind < 0.75 else plain_negative(rng, rate_hz)


def _recorded_mix(
    shots: list[list[Recording]],
    negatives: list[list[Recording]],
    beds: list[Recording],
    seed: int,
    number: int,
) -> Mix:
    rng = np.random.default_rng([seed, number])
    sounds = []
    for _ in range(SOUNDS_PER_MIX):
        shot = bool(rng.random() < 0.5)
        if rng.random() < SYNTHETIC_SHARE:
            sounds.append(_synthetic_sound(rng, shot=shot))
        else:
            sounds.append(recorded_variant(drawn(shots if shot else negatives, rng), rng))
    bed = random_bed(rng, RATE_HZ, MIX_S) if rng.random() < SYNTHETIC_SHARE or not beds else recorded_bed(beds, rng)
    return _mixed(bed, sounds, rng)


def _mixed(bed: Samples, sounds: list[Sound], rng: np.random.Generator, *, levels: Levels = LEVELS) -> Mix:
    film = mix(bed, sounds, rng=rng, rate_hz=RATE_HZ, levels=levels)
    film = replace(film, samples=perhaps_coded(film.samples, rng))
    return without_drowned(film, [[onset] for onset in film.onsets.tolist()])


def _synthetic_sound(rng: np.random.Generator, *, shot: bool) -> Sound:
    if shot:
        samples, onset, truth = random_shot(rng, RATE_HZ)
        return Sound(samples, (onset,), truth.accept_samples)
    samples, _ = random_negative(rng, RATE_HZ)
    return Sound(samples)

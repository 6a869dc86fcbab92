"""What the verifier learns from: endless minutes of film-like sound, synthetic and recorded, each from its own seed."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..synth import (
    ShotTruth,
    designed_negative,
    designed_shot,
    film_scene,
    handling,
    outdoor_shot,
    plain_bed,
    plain_negative,
    plain_shot,
    random_bed,
    random_negative,
    random_shot,
    render_scene,
    stands_out_db,
    truth_of,
)
from .codecs import BITS_PER_S, coded
from .corpus import Recording
from .mixes import MIX_S, RATE_HZ, Levels, Mix, Samples, Sound, as_16_bit, mix
from .recorded import SHORTEST_BED_S, by_source, drawn, recorded_bed, recorded_variant

SOUNDS_PER_MIX = 20
LEVELS = Levels(3.0, 40.0)
OUTDOOR_LEVELS = Levels(3.0, 55.0)  # what was recorded near stands out further
CODED_SHARE, CUT_SHARE = 0.3, 0.2
ARMED_SHARES = (0.0, 0.2, 0.5, 0.8)
DROWNED_DB = 3.0
"""A shot that stands out by less teaches nothing: it counts neither way."""


LessonMaker = Callable[[int], Mix]
"""Makes the lesson with a number, always the same."""

Shot = Callable[[np.random.Generator, int], tuple[Samples, tuple[int, ...]]]
"""Makes a shot or a burst, and says where its rounds begin."""


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


def synthetic_film(seed: int, density: Density = CROWDED) -> LessonMaker:
    """Return lessons that are scenes as `blastline synth` makes them: bursts, rooms, changing beds, one master.

    Some are cut to begin with a shot or just before it, some to end inside one, as a reel or a trailer may.
    """
    return partial(_synthetic_film, seed, density)


def gun_free_film(seed: int, density: Density = CROWDED) -> LessonMaker:
    """Return lessons that are scenes without a gun, full of what could be taken for one."""
    return partial(_gun_free_film, seed, density)


def recorded_mix(recordings: Sequence[Recording], seed: int, synthetic: float = 0.3) -> LessonMaker:
    """Return lessons of recordings, sources drawn evenly, with a share of synthetic sounds and beds among them."""
    shots = by_source(r for r in recordings if r.gunshot)
    negatives = by_source(r for r in recordings if not r.gunshot)
    beds = [r for r in recordings if not r.gunshot and r.duration_s >= SHORTEST_BED_S]
    return partial(_recorded_mix, shots, negatives, beds, seed, synthetic)


def _synthetic_mix(seed: int, number: int) -> Mix:
    rng = np.random.default_rng([seed, number])
    sounds = [_synthetic_sound(rng, shot=bool(rng.random() < 0.5)) for _ in range(SOUNDS_PER_MIX)]
    return _mixed(random_bed(rng, RATE_HZ, MIX_S), sounds, rng)


def _plain_mix(seed: int, number: int) -> Mix:
    shot = partial(_sound_of, plain_shot)
    return _armed_mix(np.random.default_rng([seed, number]), shot, _plain_negative, plain_bed)


def _designed_mix(seed: int, number: int) -> Mix:
    shot = partial(_sound_of, designed_shot)
    return _armed_mix(np.random.default_rng([seed, number]), shot, _any_negative, random_bed)


def _outdoor_mix(seed: int, number: int) -> Mix:
    rng = np.random.default_rng([seed, number])
    return _armed_mix(rng, _outdoor_sound, _near_negative, random_bed, levels=OUTDOOR_LEVELS)


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


def _any_negative(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a sudden sound as physics, a designer or a textbook makes it."""
    kind = rng.random()
    if kind < 0.4:
        return random_negative(rng, rate_hz)[0]
    return designed_negative(rng, rate_hz) if kind < 0.75 else plain_negative(rng, rate_hz)


def _gun_free_film(seed: int, density: Density, number: int) -> Mix:
    rng = np.random.default_rng([seed, number])
    negatives = int(rng.integers(*density.gun_free))
    scene = film_scene(seed * 10_000 + number, MIX_S, 0, negatives, gun_free=True, rate_hz=RATE_HZ)
    audio = render_scene(scene)
    unsure = [each.at_sample for each in truth_of(audio).negatives if each.kind == "explosion"]
    samples = _perhaps_coded(as_16_bit(audio.read(0, audio.frames)[:, 0]), rng)
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
        samples=_perhaps_coded(as_16_bit(audio.read(start, audio.frames)[:, 0]), rng),
        onsets=np.array([shot.onset_sample - start for shot in kept], np.intp),
        level_db=np.array([shot.snr_db for shot in kept], np.float64),
        unsure=np.array(unsure, np.intp),
    )
    film = without_drowned(film, [[at - start for at in _first_heard(shot)] for shot in kept])
    return perhaps_cut(film, np.random.default_rng([seed, number, 1]))


def perhaps_cut(film: Mix, rng: np.random.Generator) -> Mix:
    """Return the film, or in one lesson of five the film until up to 0.4 s after one of its last shots' onsets."""
    if not film.onsets.size or rng.random() >= CUT_SHARE:
        return film
    last = film.onsets[int(rng.integers(3 * film.onsets.size // 4, film.onsets.size))]
    stop = int(last) + int(rng.uniform(0.002, 0.4) * RATE_HZ)
    heard = film.onsets < stop
    return Mix(film.samples[:stop], film.onsets[heard], film.level_db[heard], film.unsure[film.unsure < stop])


def _first_heard(shot: ShotTruth) -> tuple[int, ...]:
    return (shot.start_sample, *shot.accept_samples, shot.onset_sample)


def without_drowned(film: Mix, places: Sequence[Iterable[int]]) -> Mix:
    """Return a mix in which a shot that hardly stands out of what is before it counts neither way.

    `places` are, for each shot, where it may be heard first: its onset, a bullet's shock, a bolt.
    """
    margins_db = [max(stands_out_db(film.samples, at, rate_hz=RATE_HZ) for at in each if at >= 0) for each in places]
    heard = np.array(margins_db, np.float64) >= DROWNED_DB
    unsure = np.concatenate([film.unsure, film.onsets[~heard]])
    return replace(film, onsets=film.onsets[heard], level_db=film.level_db[heard], unsure=unsure)


def _recorded_mix(
    shots: list[list[Recording]],
    negatives: list[list[Recording]],
    beds: list[Recording],
    seed: int,
    synthetic: float,
    number: int,
) -> Mix:
    rng = np.random.default_rng([seed, number])
    sounds = []
    for _ in range(SOUNDS_PER_MIX):
        shot = bool(rng.random() < 0.5)
        if rng.random() < synthetic:
            sounds.append(_synthetic_sound(rng, shot=shot))
        else:
            sounds.append(recorded_variant(drawn(shots if shot else negatives, rng), rng))
    bed = random_bed(rng, RATE_HZ, MIX_S) if rng.random() < synthetic or not beds else recorded_bed(beds, rng)
    return _mixed(bed, sounds, rng)


def _mixed(bed: Samples, sounds: list[Sound], rng: np.random.Generator, *, levels: Levels = LEVELS) -> Mix:
    film = mix(bed, sounds, rng=rng, rate_hz=RATE_HZ, levels=levels)
    film = replace(film, samples=_perhaps_coded(film.samples, rng))
    return without_drowned(film, [[onset] for onset in film.onsets.tolist()])


def _perhaps_coded(samples: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the samples, or in three of ten lessons what a lossy codec leaves of them."""
    if rng.random() >= CODED_SHARE:
        return samples
    codec = list(BITS_PER_S)[int(rng.integers(len(BITS_PER_S)))]
    return coded(samples, codec, bits_per_s=int(rng.choice(BITS_PER_S[codec])), rate_hz=RATE_HZ)


def _synthetic_sound(rng: np.random.Generator, *, shot: bool) -> Sound:
    if shot:
        samples, onset, truth = random_shot(rng, RATE_HZ)
        return Sound(samples, (onset,), truth.accept_samples)
    samples, _ = random_negative(rng, RATE_HZ)
    return Sound(samples)

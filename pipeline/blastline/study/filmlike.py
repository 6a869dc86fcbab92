"""Film-like sounds made of recordings, to measure on: mixes at given levels, and clips as DCASE 2017 asked for.

Each film has a seed of its own, so that the same recordings always give the same films. Shots and other sounds are the
recordings themselves: no variants of speed, place or repetition, and nothing synthetic, but for a bed or other sounds
where the recordings have none. Mixes are coloured and mastered as `mixes` does it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import RuleError
from ..synth import random_bed, random_negative
from ..units import gain_from_db, samples_from_ms
from .cases import GUN_FREE_EVERY, Case, near_each_other
from .corpus import Recording, load_sound
from .lessons import SOUNDS_PER_MIX
from .mixes import MIX_S, RATE_HZ, Levels, Sound, as_16_bit, mix
from .recorded import SHORTEST_BED_S, by_source, drawn, recorded_bed, recorded_sound
from .sound_files import write_sound

Samples = NDArray[np.float64]

CLIP_S = 30.0
CLIP_LEVELS_DB = (-6.0, 0.0, 6.0)
_LEAD_MS, _TAIL_MS, _FADE_MS = 5.0, 2000.0, 20.0


@dataclass(frozen=True)
class Stock:
    """Recordings sorted for mixing: shots and other sounds by source, and what can be a bed."""

    shots: list[list[Recording]]
    others: list[list[Recording]]
    beds: list[Recording]


def stock(found: Sequence[Recording]) -> Stock:
    """Return recordings sorted for mixing; RuleError where there is no shot among them."""
    shots = by_source(each for each in found if each.gunshot and each.onsets_s)
    if not shots:
        raise RuleError("study: no recording of a gunshot with onsets; mixes and clips are made of shots over beds")
    others = [each for each in found if not each.gunshot]
    return Stock(shots, by_source(others), [each for each in others if each.duration_s >= SHORTEST_BED_S])


def film_mixes(sounds: Stock, into: Path, *, films: int, levels: Levels, seed: int) -> Iterator[Case]:
    """Yield minutes of film-like sound, as many shots as other sounds, each at a level over the bed."""
    for number in range(films):
        rng = np.random.default_rng([seed, number])
        gun_free = number % GUN_FREE_EVERY == GUN_FREE_EVERY - 1
        placed = [_sound(sounds, rng, shot=not gun_free and bool(rng.random() < 0.5)) for _ in range(SOUNDS_PER_MIX)]
        made = mix(_bed(sounds, rng, MIX_S), placed, rng=rng, rate_hz=RATE_HZ, levels=levels)
        true_ms = made.onsets.astype(np.float64) * (1000.0 / RATE_HZ)
        yield Case(
            name=f"mix-{number:03d}",
            path=_written(into / f"mix-{number:03d}.wav", made.samples),
            true_ms=true_ms,
            snr_db=made.level_db,
            timed=~np.isin(made.onsets, made.unsure),
            bursts=near_each_other(true_ms),
        )


def one_shot_clips(sounds: Stock, into: Path, *, clips: int, seed: int) -> Iterator[Case]:
    """Yield clips of 30 s over a bed, every other one with a single shot at -6, 0 or 6 dB: its rms over the bed's.

    The rms is that of all of the shot, decay included. As in task 2 of DCASE 2017, but of other recordings:
    scores are not to be compared with its own.
    """
    for number in range(clips):
        rng = np.random.default_rng([seed, number, 1])
        samples = _bed(sounds, rng, CLIP_S)
        onsets, levels_db, timed = [], [], []
        if number % 2 == 0:
            recording = drawn(sounds.shots, rng)
            shot, lead = _single(recording)
            level_db = CLIP_LEVELS_DB[(number // 2) % len(CLIP_LEVELS_DB)]
            at = int(rng.integers(RATE_HZ, samples.size - shot.size - RATE_HZ))
            background = _rms(samples[at : at + shot.size])
            samples[at : at + shot.size] += shot * (background * gain_from_db(level_db) / _rms(shot[lead:]))
            onsets, levels_db, timed = [(at + lead) * 1000.0 / RATE_HZ], [level_db], [recording.timed]
        loudest = float(np.abs(samples).max()) or 1.0
        yield Case(
            name=f"clip-{number:03d}",
            path=_written(into / f"clip-{number:03d}.wav", as_16_bit(samples * (0.9 / loudest))),
            true_ms=np.array(onsets, np.float64),
            snr_db=np.array(levels_db, np.float64),
            timed=np.array(timed, bool),
        )


def _sound(sounds: Stock, rng: np.random.Generator, *, shot: bool) -> Sound:
    """Return a sound to place; onsets that may be off by some milliseconds are among its unsure places as well."""
    if not shot and not sounds.others:
        return Sound(random_negative(rng, RATE_HZ)[0])
    recording = drawn(sounds.shots if shot else sounds.others, rng)
    sound = recorded_sound(recording, rng)
    return sound if recording.timed else replace(sound, unsure=sound.onsets)


def _bed(sounds: Stock, rng: np.random.Generator, seconds: float) -> Samples:
    if sounds.beds:
        return recorded_bed(sounds.beds, rng, seconds)
    return np.asarray(random_bed(rng, RATE_HZ, seconds), np.float64)


def _single(recording: Recording) -> tuple[Samples, int]:
    """Return a recording's first shot alone, until the next one or for 2 s, and the index of its onset."""
    samples = load_sound(recording, RATE_HZ).astype(np.float64)
    onsets = [round(onset * RATE_HZ) for onset in recording.onsets_s]
    start = max(0, onsets[0] - samples_from_ms(_LEAD_MS, RATE_HZ))
    stop = min([samples.size, onsets[0] + samples_from_ms(_TAIL_MS, RATE_HZ), *onsets[1:2]])
    shot = samples[start:stop].copy()
    fade = min(shot.size // 4, samples_from_ms(_FADE_MS, RATE_HZ))
    shot[shot.size - fade :] *= np.linspace(1.0, 0.0, fade)
    return shot, onsets[0] - start


def _rms(samples: Samples) -> float:
    return float(np.sqrt(np.mean(samples**2))) or 1.0


def _written(path: Path, samples: NDArray[np.float32]) -> Path:
    write_sound(path, samples, RATE_HZ)
    return path

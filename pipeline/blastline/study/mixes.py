"""Film-like mixes for training and measuring: sounds with known onsets over beds, mastered as a film would be.

    bed (speech, music, ambience, or none) + sounds at random times, levels and colours
        -> perhaps a limiter -> perhaps less than the full band -> gain -> 16 bit

Level, bandwidth, colour and mastering are drawn alike for shots and for everything else, so that a model cannot learn
the archive instead of the gun.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..synth.tone import peak, rms
from ..units import db_from_gain, gain_from_db, samples_from_ms

Samples = NDArray[np.float64]

RATE_HZ = 48_000
MIX_S = 60.0
_FAINTEST_BED = 3e-4  # rms; a sound over silence has a level all the same
_PEAK_MS = 50.0  # after an onset; a shot has peaked by then


class Levels(NamedTuple):
    """How far a sound stands over the bed, from one level to another: its highest peak, or its rms, over the bed's rms.

    The rms of a sound is that from its first onset to its end, nearly the event-to-background ratio of DCASE 2017; the
    bed's is that under the whole sound, what comes before the onset included. A shot's peak is some 20 dB over its rms.
    """

    low_db: float
    high_db: float
    of: Literal["peak", "rms"] = "peak"


@dataclass(frozen=True, eq=False)
class Sound:
    """A sound to place: mono samples, and the indices of its shots' onsets (none for a negative).

    At an index of `unsure` a detection is neither right nor wrong: the shock of a bullet before its blast.
    """

    samples: Samples
    onsets: tuple[int, ...] = ()
    unsure: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Mix:
    """A mixed stretch: samples, shape (frames,), the shots' onsets, ascending, and their levels, shape (shots,).

    `level_db` is a shot's own peak over the rms of the bed around it, or how far its sound's rms is over the bed's
    less what the shot is softer than the loudest one of its sound. `unsure` are places as in `Sound`.
    """

    samples: NDArray[np.float32]
    onsets: NDArray[np.intp]
    level_db: NDArray[np.float64]
    unsure: NDArray[np.intp]


LessonMaker = Callable[[int], Mix]
"""Makes the lesson with a number, always the same."""


def mix(bed: Samples, sounds: list[Sound], *, rng: np.random.Generator, rate_hz: int, levels: Levels) -> Mix:
    """Place the sounds over the bed, none starting within 0.6 s of another's start, and master the sum.

    Each sound is at one of the levels over the bed.
    """
    mixed = bed.copy()
    onsets: list[int] = []
    levels_db: list[float] = []
    unsure: list[int] = []
    for sound, at in zip(sounds, _places(len(sounds), bed.shape[0], rng, rate_hz), strict=False):
        wave = _coloured(sound.samples, rng, rate_hz)[: bed.shape[0] - at]
        size = _size(wave, sound.onsets, levels)
        near = bed[at : at + wave.shape[0]] if levels.of == "rms" else bed[max(0, at - rate_hz // 2) : at + rate_hz]
        background = max(rms(near), _FAINTEST_BED)
        level_db = rng.uniform(levels.low_db, levels.high_db)
        if size <= 0.0:
            continue
        mixed[at : at + wave.shape[0]] += wave * (background * gain_from_db(level_db) / size)
        kept = [onset for onset in sound.onsets if onset < wave.shape[0]]
        onsets += [at + onset for onset in kept]
        levels_db += [level_db + softer_db for softer_db in _against_loudest_db(wave, kept, rate_hz)]
        unsure += [at + place for place in sound.unsure]
    order = np.argsort(onsets)
    return Mix(
        samples=_mastered(mixed, rng, rate_hz),
        onsets=np.array(onsets, np.intp)[order],
        level_db=np.array(levels_db, np.float64)[order],
        unsure=np.array(unsure, np.intp),
    )


def _size(wave: Samples, onsets: tuple[int, ...], levels: Levels) -> float:
    """Return what of a sound is held against the bed: its peak, or its rms from its first onset on."""
    return rms(wave[min(onsets, default=0) :]) if levels.of == "rms" else peak(wave)


def _against_loudest_db(wave: Samples, onsets: list[int], rate_hz: int) -> list[float]:
    """Return how much each shot peaks over the loudest moment of its sound: 0 dB or less."""
    loudest = float(np.abs(wave).max())
    ends = [*onsets[1:], wave.size] if onsets else []
    peaks = [
        float(np.abs(wave[onset : min(end, onset + samples_from_ms(_PEAK_MS, rate_hz))]).max())
        for onset, end in zip(onsets, ends, strict=True)
    ]
    return [db_from_gain(peak / loudest) for peak in peaks]


def as_16_bit(samples: Samples) -> NDArray[np.float32]:
    """Return samples at the resolution of a 16-bit file."""
    return np.asarray(np.round(samples * 32767.0) / 32768.0, np.float32)


def _places(count: int, length: int, rng: np.random.Generator, rate_hz: int) -> list[int]:
    """Return random starts, ascending, at least 0.6 s apart; fewer than asked for where they do not fit."""
    apart = int(0.6 * rate_hz)
    room = length - count * apart
    if room <= 0:
        return _places(length // (2 * apart), length, rng, rate_hz)
    return [int(free) + n * apart for n, free in enumerate(np.sort(rng.uniform(0, room, count)))]


def _coloured(samples: Samples, rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a sound through a random tilt, low-pass and high-pass: another microphone, distance or taste.

    Causal and of minimum phase, so that the onset stays where it is.
    """
    from scipy.signal import butter, sosfilt

    if rng.random() < 0.3:
        return samples
    sections = [butter(1, rng.uniform(20.0, 150.0), "high", fs=rate_hz, output="sos")]
    if rng.random() < 0.5:
        corner_hz = min(float(np.exp(rng.uniform(np.log(1500.0), np.log(16000.0)))), 0.45 * rate_hz)
        sections.append(butter(int(rng.integers(1, 3)), corner_hz, "low", fs=rate_hz, output="sos"))
    coloured = sosfilt(np.concatenate(sections), samples)
    tilt = rng.uniform(-0.5, 0.5)
    return np.asarray(coloured + tilt * np.diff(coloured, prepend=0.0), np.float64)


def _mastered(samples: Samples, rng: np.random.Generator, rate_hz: int) -> NDArray[np.float32]:
    from scipy.signal import butter, sosfilt

    loud = samples / (peak(samples) or 1.0)
    if rng.random() < 0.5:  # the whole mix driven into a limiter
        loud = np.tanh(loud * rng.uniform(1.0, 6.0))
    if rng.random() < 0.3:  # a lossy codec or an optical track keeps less than the full band
        corner_hz = min(rng.uniform(4000.0, 16000.0), 0.45 * rate_hz)
        loud = sosfilt(butter(6, corner_hz, fs=rate_hz, output="sos"), loud)
    loud = loud / (np.abs(loud).max() or 1.0) * gain_from_db(rng.uniform(-24.0, -0.3))
    return as_16_bit(loud)

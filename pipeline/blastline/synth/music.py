"""Music: notes of simple instruments, chords, bass and melody over a drum kit, and the single notes that startle."""

import math
from dataclasses import dataclass

import numpy as np

from .chance import between, chance, fork, log_between, pick
from .drums import loop
from .echoes import overlaid
from .noises import levelled
from .tone import Samples, highpass, lowpass
from .waves import normalised

_TABLE = 4_096
"""Samples in one period of a wave; a power of two, so that the phase wraps by a mask."""

PROGRESSIONS = ((0, 5, 7, 0), (0, -3, 5, 7), (0, 8, 3, 10), (0, -4, -7, -5), (0, 0, 1, 0))
"""Roots of chords in semitones against the key."""

CHORDS = ((0, 4, 7), (0, 3, 7), (0, 3, 7, 10), (0, 5, 7), (0, 1, 7, 11))


@dataclass(frozen=True, eq=False)
class Instrument:
    """One period of its wave, and how a note starts and dies."""

    period: Samples
    attack_ms: float
    decay_s: float
    vibrato: float
    detune: float


def draw_instrument(rng: np.random.Generator, *, sustained: bool) -> Instrument:
    """Return strings, brass or organ where `sustained`, else something plucked or struck."""
    harmonics = np.arange(1, int(rng.integers(3, 30)))
    levels = harmonics ** -between(rng, (0.6, 2.4)) * np.exp(0.3 * rng.standard_normal(len(harmonics)))
    angles = 2.0 * math.pi * np.arange(_TABLE) / _TABLE
    phases = 2.0 * math.pi * rng.random(len(harmonics))
    period = np.sum(levels[:, None] * np.sin(harmonics[:, None] * angles + phases[:, None]), axis=0)
    return Instrument(
        period=normalised(period),
        attack_ms=log_between(rng, (15.0, 600.0)) if sustained else log_between(rng, (0.3, 8.0)),
        decay_s=between(rng, (2.0, 8.0)) if sustained else log_between(rng, (0.08, 1.5)),
        vibrato=between(rng, (0.0, 0.006)) if sustained else 0.0,
        detune=between(rng, (0.0, 0.004)),
    )


def note(rate_hz: int, instrument: Instrument, *, pitch_hz: float, length_s: float) -> Samples:
    """Return one note: two slightly detuned waves that rise and decay, released over the last 30 ms."""
    count = max(4, round(length_s * rate_hz))
    times = np.arange(count) / rate_hz
    sway = instrument.vibrato / (2.0 * math.pi * 5.5) * np.sin(2.0 * math.pi * 5.5 * times)
    sound = np.zeros(count)
    for detune in (1.0, 1.0 + instrument.detune):
        phase = pitch_hz * detune * (times + sway)
        sound += instrument.period[(phase * _TABLE).astype(np.int64) & (_TABLE - 1)]
    attack = 1.0 - np.exp(-times * 2e3 / instrument.attack_ms)
    release = np.minimum(np.arange(count)[::-1] / (0.03 * rate_hz), 1.0)
    return np.asarray(0.5 * sound * attack * np.exp(-times / instrument.decay_s) * release, dtype=np.float64)


def music(rng: np.random.Generator, rate_hz: int, seconds: float) -> Samples:
    """Return a piece in one key and one tempo: chords, bass, a melody and, half of the time, drums; rms 1."""
    count = round(seconds * rate_hz)
    beat_s = 60.0 / between(rng, (56.0, 160.0))
    key_hz = log_between(rng, (98.0, 196.0))
    roots, chord = pick(rng, PROGRESSIONS), pick(rng, CHORDS)
    total = np.zeros(count)
    pad, bass, lead = (draw_instrument(rng, sustained=sustained) for sustained in (True, chance(rng, 0.5), False))
    bar_s = 4.0 * beat_s
    for bar in range(math.ceil(seconds / bar_s)):
        root = roots[bar % len(roots)]
        start = round(bar * bar_s * rate_hz)
        for step in chord:
            _play(total, start, note(rate_hz, pad, pitch_hz=_pitch(key_hz, root + step), length_s=bar_s) * 0.3)
        for beat in range(4):
            at = start + round(beat * beat_s * rate_hz)
            low = note(rate_hz, bass, pitch_hz=_pitch(key_hz / 2.0, root), length_s=beat_s * 0.9)
            _play(total, at, low * (0.5 if beat % 2 == 0 or chance(rng, 0.5) else 0.0))
            if chance(rng, 0.7):
                pitch = _pitch(2.0 * key_hz, root + pick(rng, chord) + pick(rng, (0, 0, 12, 2)))
                played = note(rate_hz, lead, pitch_hz=pitch, length_s=beat_s * between(rng, (0.3, 2.0)))
                _play(total, at + pick(rng, (0, round(0.5 * beat_s * rate_hz))), played * between(rng, (0.2, 0.7)))
    if chance(rng, 0.5):
        total = levelled(total) + between(rng, (1.0, 6.0)) * loop(fork(rng), rate_hz, seconds)
    if chance(rng, 0.4):
        total = np.tanh(levelled(total) * between(rng, (0.3, 1.5)))
    return levelled(
        highpass(lowpass(total, log_between(rng, (3_000.0, 16_000.0)), rate_hz=rate_hz), 30.0, rate_hz=rate_hz)
    )


def drum_music(rng: np.random.Generator, rate_hz: int, seconds: float) -> Samples:
    """Return drums alone; rms 1."""
    return levelled(loop(rng, rate_hz, seconds))


def stinger(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return an orchestral hit: a chord struck at once, with or without a drum, that dies within a second or two."""
    instrument = draw_instrument(rng, sustained=False)
    base = log_between(rng, (55.0, 440.0))
    length_s = between(rng, (0.4, 2.0))
    notes = [
        (0, note(rate_hz, instrument, pitch_hz=_pitch(base, step), length_s=length_s)) for step in pick(rng, CHORDS)
    ]
    if chance(rng, 0.5):
        notes.append((0, 0.8 * loop(fork(rng), rate_hz, 0.3)))
    return normalised(overlaid(notes))


def bell(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return one note of a piano, a guitar, a bell or a beep."""
    instrument = draw_instrument(rng, sustained=False)
    length_s = between(rng, (0.1, 1.5))
    return normalised(note(rate_hz, instrument, pitch_hz=log_between(rng, (60.0, 3_000.0)), length_s=length_s))


def _pitch(base_hz: float, semitones: float) -> float:
    return float(base_hz * 2.0 ** (semitones / 12.0))


def _play(total: Samples, at: int, sound: Samples) -> None:
    if at < len(total):
        total[at : at + len(sound)] += sound[: len(total) - at]

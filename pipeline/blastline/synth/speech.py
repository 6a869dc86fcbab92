"""Dialogue that nobody speaks: syllables of a glottal source through formants, with consonants and pauses.

phrase = syllable syllable ... pause          2-7 syllables a second, pitch falling over the phrase
syllable = consonant (hiss, burst, hum, none) + vowel (Rosenberg pulses through four formants)
"""

import math
from dataclasses import dataclass

import numpy as np

from ..units import gain_from_db
from .chance import between, chance, fork, log_between, pick
from .noises import levelled, slow
from .tone import Samples, bandpass, lowpass, resonance
from .waves import noise_burst

VOWELS_HZ = (
    (730.0, 1_090.0, 2_440.0),
    (270.0, 2_290.0, 3_010.0),
    (300.0, 870.0, 2_240.0),
    (530.0, 1_840.0, 2_480.0),
    (570.0, 840.0, 2_410.0),
    (660.0, 1_720.0, 2_410.0),
    (440.0, 1_020.0, 2_240.0),
    (490.0, 1_350.0, 1_690.0),
)
"""The first three formants of men's American vowels (Peterson and Barney 1952)."""


@dataclass(frozen=True)
class Speaker:
    """A voice: its pitch, how much that moves, the length of its tract against a man's, its pace and its breath."""

    pitch_hz: float
    liveliness: float
    tract: float
    pace_s: float
    breath: float
    effort: float


def draw_speaker(rng: np.random.Generator) -> Speaker:
    """Return a man, a woman or a child, whispering to shouting."""
    pitch = log_between(rng, (80.0, 320.0))
    return Speaker(
        pitch_hz=pitch,
        liveliness=between(rng, (0.05, 0.35)),
        tract=min(1.35, (pitch / 120.0) ** 0.22 * between(rng, (0.95, 1.08))),
        pace_s=log_between(rng, (0.11, 0.28)),
        breath=log_between(rng, (0.01, 0.3)),
        effort=between(rng, (0.0, 1.0)),
    )


def dialogue(rng: np.random.Generator, rate_hz: int, seconds: float) -> Samples:
    """Return phrases of one to three speakers, with an rms of 1 over the whole, pauses included."""
    count = round(seconds * rate_hz)
    speakers = [draw_speaker(rng) for _ in range(int(rng.integers(1, 4)))]
    pause_s = (0.1, log_between(rng, (0.4, 2.5)))
    total = np.zeros(count)
    at = round(between(rng, (0.0, 0.5)) * rate_hz)
    while at < count:
        words = phrase(fork(rng), rate_hz, pick(rng, speakers))
        level = gain_from_db(between(rng, (-8.0, 0.0)))
        total[at : at + len(words)] += level * words[: count - at]
        at += len(words) + round(between(rng, pause_s) * rate_hz)
    return levelled(total)


def crowd(rng: np.random.Generator, rate_hz: int, seconds: float) -> Samples:
    """Return babble: a handful of speakers at once, a few times over at different delays, dulled by the distance."""
    count = round(seconds * rate_hz)
    total = np.zeros(count)
    for _ in range(3):
        voice = dialogue(fork(rng), rate_hz, seconds)
        for _ in range(4):
            total += np.roll(voice, int(rng.integers(count))) * between(rng, (0.3, 1.0))
    dull = lowpass(total, log_between(rng, (1_200.0, 6_000.0)), rate_hz=rate_hz)
    return levelled(dull * slow(fork(rng), count, step_s=1.0, depth_db=1.5, rate_hz=rate_hz))


def phrase(rng: np.random.Generator, rate_hz: int, speaker: Speaker) -> Samples:
    """Return a phrase of one speaker, with an rms of 1."""
    count = int(rng.integers(2, 14))
    parts = []
    for index in range(count):
        fall = 1.1 - 0.25 * index / count
        pitch = speaker.pitch_hz * fall * math.exp(speaker.liveliness * rng.standard_normal())
        parts.append(_consonant(rng, rate_hz))
        length_s = speaker.pace_s * between(rng, (0.5, 1.4)) * (1.6 if index == count - 1 else 1.0)
        parts.append(vowel(fork(rng), rate_hz, speaker, pitch_hz=pitch, length_s=length_s))
    return levelled(np.concatenate(parts))


def vowel(rng: np.random.Generator, rate_hz: int, speaker: Speaker, *, pitch_hz: float, length_s: float) -> Samples:
    """Return one vowel, drawn at random, with faded ends."""
    count = max(8, round(length_s * rate_hz))
    glide = np.linspace(1.0, between(rng, (0.85, 1.12)), count)
    phase = np.cumsum(pitch_hz * glide) / rate_hz % 1.0
    noise = fork(rng).standard_normal(count)
    source = _glottal(phase, closing=0.35 - 0.25 * speaker.effort) + speaker.breath * noise
    sound = np.zeros(count)
    formants = (*pick(rng, VOWELS_HZ), 3_500.0)
    for number, formant in enumerate(formants):
        width = 60.0 + 35.0 * number
        level = (0.5 + 0.4 * speaker.effort) ** number
        sound += level * resonance(source, formant * speaker.tract, bandwidth_hz=width, rate_hz=rate_hz)
    edges = np.minimum(np.arange(count), np.arange(count)[::-1]) / (0.02 * rate_hz)
    loud = gain_from_db(between(rng, (-6.0, 3.0)))
    envelope = loud * np.sin(np.minimum(edges, 1.0) * (math.pi / 2.0)) ** 2
    return np.asarray(levelled(sound) * envelope, dtype=np.float64)


def _glottal(phase: Samples, *, closing: float) -> Samples:
    """Return the derivative of Rosenberg's glottal flow: opens over 0.4 of a period, closes over `closing` of it."""
    opening = 0.4
    rising = np.sin(math.pi * phase / opening) * (math.pi / (2.0 * opening))
    falling = -np.sin(math.pi / 2.0 * (phase - opening) / closing) * (math.pi / (2.0 * closing))
    return np.asarray(
        np.where(phase < opening, rising, np.where(phase < opening + closing, falling, 0.0)), dtype=np.float64
    )


def _consonant(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a fricative, a plosive with the silence before it, a short gap, or nothing."""
    noise = fork(rng)
    if chance(rng, 0.35):
        low = log_between(rng, (1_000.0, 5_000.0))
        count = max(8, round(between(rng, (0.03, 0.14)) * rate_hz))
        hiss = bandpass(noise.standard_normal(count), low, 2.2 * low, rate_hz=rate_hz, order=2)
        return levelled(hiss) * np.hanning(count) * between(rng, (0.1, 0.8))
    if chance(rng, 0.5):
        gap = np.zeros(round(between(rng, (0.02, 0.08)) * rate_hz))
        burst = noise_burst(noise, rate_hz, attack_ms=0.3, decay_ms=log_between(rng, (2.0, 12.0)))
        centre = log_between(rng, (500.0, 4_500.0))
        burst = bandpass(burst, 0.6 * centre, 1.8 * centre, rate_hz=rate_hz)
        return np.concatenate([gap, burst / max(float(np.max(np.abs(burst))), 1e-9) * between(rng, (0.3, 2.5))])
    return np.zeros(round(between(rng, (0.0, 0.03)) * rate_hz))

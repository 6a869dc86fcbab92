"""Beds as textbooks and sound toolkits make them: noise, chords of steady tones, syllables of noise or buzz, hum."""

import math

import numpy as np

from ..units import gain_from_db, gains_from_db
from .chance import between, chance, fork, log_between, pick
from .plain import gliding, sloped_noise
from .tone import Samples, bandpass, rms


def plain_bed(rng: np.random.Generator, rate_hz: int, seconds: float) -> Samples:
    """Return one of these, or two at once, over noise that is at least faint."""
    frames = round(seconds * rate_hz)
    bed = _noise(fork(rng), rate_hz, frames)
    if chance(rng, 0.4):
        bed *= gain_from_db(between(rng, (-50.0, -15.0)))
        for _ in range(pick(rng, (1, 1, 2))):
            part = pick(rng, (chords, chords, babble, babble, hum))(fork(rng), rate_hz, frames)
            bed += part * gain_from_db(between(rng, (-10.0, 0.0))) / max(rms(part), 1e-9)
    return np.asarray(bed * (gain_from_db(between(rng, (-60.0, -25.0))) / rms(bed)))


def _noise(rng: np.random.Generator, rate_hz: int, frames: int) -> Samples:
    """Return noise with a slope over frequency and a level that wanders, and up to three gliding tones a second."""
    seconds = frames / rate_hz
    steps = max(2, round(seconds / between(rng, (1.0, 6.0))))
    wander_db = np.interp(np.linspace(0.0, 1.0, frames), np.linspace(0.0, 1.0, steps), rng.uniform(-8.0, 8.0, steps))
    bed = np.asarray(sloped_noise(fork(rng), frames, between(rng, (-2.2, 0.0))) * gains_from_db(wander_db))
    level = rms(bed)
    for _ in range(round(seconds * between(rng, (0.0, 3.0)))):
        tone = gliding(rng, rate_hz, log_between(rng, (80.0, 5_000.0)), between(rng, (0.1, 1.5)))
        at = int(rng.integers(max(1, frames - len(tone))))
        bed[at : at + len(tone)] += tone[: frames - at] * level * gain_from_db(between(rng, (-12.0, 14.0)))
    return np.asarray(bed / level)


def chords(rng: np.random.Generator, rate_hz: int, frames: int) -> Samples:
    """Return chords that fade into each other: two to eight tones with overtones, each of which may swell and fade."""
    bed = np.zeros(frames)
    length = round(log_between(rng, (0.5, 20.0)) * rate_hz)
    fade_s = log_between(rng, (0.03, 0.5))
    for start in range(0, frames, length):
        times = np.arange(min(length + round(fade_s * rate_hz), frames - start)) / rate_hz
        bow = np.minimum(np.minimum(times, times[::-1]) / fade_s, 1.0)
        for hz in np.exp(rng.uniform(math.log(60.0), math.log(1_500.0), int(rng.integers(2, 9)))).tolist():
            bed[start : start + len(times)] += _note(rng, hz, times, rate_hz) * bow
    return bed


def _note(rng: np.random.Generator, hz: float, times: Samples, rate_hz: int) -> Samples:
    """Return a tone with up to seven overtones, which may swell and fade up to six times a second."""
    roll_off = between(rng, (0.5, 2.5))
    overtones = [n for n in range(1, int(rng.integers(2, 10))) if n * hz < 0.45 * rate_hz]
    tone = sum((np.sin(2.0 * math.pi * n * hz * times) / n**roll_off for n in overtones), np.zeros(len(times)))
    swelling = np.sin(2.0 * math.pi * (log_between(rng, (0.1, 6.0)) * times + rng.random()))
    return np.asarray(tone * (1.0 + between(rng, (0.0, 1.0)) * swelling))


def babble(rng: np.random.Generator, rate_hz: int, frames: int) -> Samples:
    """Return a band of noise or a buzz that comes and goes two to eight times a second, at times with pauses."""
    times = np.arange(frames) / rate_hz
    low_hz = log_between(rng, (60.0, 1_500.0))
    if chance(rng, 0.5):
        source = sloped_noise(fork(rng), frames, between(rng, (-2.2, 0.0)))
    else:
        glide = np.sin(2.0 * math.pi * between(rng, (0.1, 2.0)) * times)
        pitch_hz = log_between(rng, (80.0, 300.0)) * (1.0 + 0.2 * glide)
        source = np.cumsum(pitch_hz) / rate_hz % 1.0 - 0.5
    voice = bandpass(source, low_hz, min(0.45 * rate_hz, low_hz * log_between(rng, (3.0, 40.0))), rate_hz=rate_hz)
    wobble = between(rng, (0.0, 2.0)) * np.sin(2.0 * math.pi * between(rng, (0.05, 0.5)) * times)
    syllables = np.abs(np.sin(math.pi * between(rng, (2.0, 8.0)) * times + wobble)) ** between(rng, (0.7, 3.0))
    if chance(rng, 0.5):
        syllables *= np.clip(0.5 + 2.0 * np.sin(2.0 * math.pi * between(rng, (0.1, 0.4)) * times), 0.0, 1.0)
    return np.asarray(voice * (syllables + gain_from_db(between(rng, (-40.0, -10.0)))))


def hum(rng: np.random.Generator, rate_hz: int, frames: int) -> Samples:
    """Return mains hum or an engine that idles: overtones of one low tone at random levels and phases."""
    low_hz, times = log_between(rng, (25.0, 130.0)), np.arange(frames) / rate_hz
    bed = np.zeros(frames)
    for overtone in range(1, int(rng.integers(2, 16))):
        level = gain_from_db(between(rng, (-30.0, 0.0)))
        bed += level * np.sin(2.0 * math.pi * (overtone * low_hz * times + rng.random()))
    return bed

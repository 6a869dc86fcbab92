"""Ambiences: coloured noise that swells, wind, rain, engines. All have an rms of 1."""

import math

import numpy as np

from ..units import gains_from_db
from .chance import between, chance, fork, log_between
from .tone import Samples, bandpass, lowpass, resonance, rms
from .waves import band_burst

_TABLE = 4_096


def coloured(rng: np.random.Generator, count: int, *, slope: float, rate_hz: int) -> Samples:
    """Return noise whose power falls with frequency as 1 / f^slope (1 pink, 2 brown) up to an eighth of the rate.

    It is flat below 20 Hz.
    """
    from scipy.signal import bilinear_zpk, sosfilt, zpk2sos

    fall = slope / 2.0
    # a pole in every octave, with a zero above it that leaves the wanted part of its 6 dB
    poles = -2.0 * math.pi * 20.0 * 2.0 ** np.arange(math.floor(math.log2(rate_hz / 80.0)))
    part = fall if fall <= 1.0 else fall - 1.0
    analogue = (poles * 2.0**part, poles if fall <= 1.0 else np.append(poles, poles[0]), 1.0)
    sections = zpk2sos(*bilinear_zpk(*analogue, fs=rate_hz))
    return levelled(np.asarray(sosfilt(sections, rng.standard_normal(count)), dtype=np.float64))


def levelled(samples: Samples) -> Samples:
    """Return the samples with an rms of 1; silence stays silence."""
    level = rms(samples)
    return samples / level if level > 0.0 else samples


def slow(rng: np.random.Generator, count: int, *, step_s: float, depth_db: float, rate_hz: int) -> Samples:
    """Return a gain that wanders: random levels of the given depth, a new one every `step_s`, joined smoothly."""
    steps = math.ceil(count / rate_hz / step_s) + 2
    levels = rng.standard_normal(steps) * depth_db
    return gains_from_db(smooth_through(levels, count / rate_hz / step_s, count))


def smooth_through(values: Samples, span: float, count: int) -> Samples:
    """Return `count` values of a curve through `values` at 0, 1, 2 ..., sampled evenly from 0 to `span`.

    Between two of them it follows half a cosine, in 64 straight pieces.
    """
    weights = 0.5 - 0.5 * np.cos(math.pi * np.arange(64) / 64.0)
    curve = (values[:-1, None] + weights * np.diff(values)[:, None]).ravel()
    places = np.linspace(0.0, 64.0 * span, count, endpoint=False)
    return np.asarray(np.interp(places, np.arange(len(curve)), curve), dtype=np.float64)


def ambience(rng: np.random.Generator, rate_hz: int, seconds: float) -> Samples:
    """Return room tone or distant traffic: noise between white and brown, swelling slowly."""
    count = round(seconds * rate_hz)
    noise = coloured(fork(rng), count, slope=between(rng, (0.7, 2.2)), rate_hz=rate_hz)
    noise = bandpass(noise, log_between(rng, (20.0, 150.0)), log_between(rng, (2_000.0, 18_000.0)), rate_hz=rate_hz)
    step_s, depth_db = log_between(rng, (0.4, 6.0)), between(rng, (0.5, 4.0))
    return levelled(noise * slow(fork(rng), count, step_s=step_s, depth_db=depth_db, rate_hz=rate_hz))


def wind(rng: np.random.Generator, rate_hz: int, seconds: float) -> Samples:
    """Return gusts: a rumble, and a whistling band whose level and pitch follow the same gusts."""
    count = round(seconds * rate_hz)
    gust = slow(fork(rng), count, step_s=log_between(rng, (0.5, 3.0)), depth_db=5.0, rate_hz=rate_hz)
    whistle = np.zeros(count)
    for _ in range(int(rng.integers(1, 4))):
        centre = log_between(rng, (250.0, 1_800.0))
        band = resonance(
            fork(rng).standard_normal(count), centre, bandwidth_hz=centre * between(rng, (0.05, 0.4)), rate_hz=rate_hz
        )
        whistle += levelled(band) * slow(fork(rng), count, step_s=1.5, depth_db=6.0, rate_hz=rate_hz)
    whistle = between(rng, (0.05, 0.6)) * gust**1.5 * levelled(whistle)
    rumble = lowpass(coloured(fork(rng), count, slope=1.5, rate_hz=rate_hz), 250.0, rate_hz=rate_hz)
    return levelled(gust * levelled(rumble) + whistle)


def rain(rng: np.random.Generator, rate_hz: int, seconds: float) -> Samples:
    """Return rain: a hiss and single drops, a few to hundreds in a second."""
    count = round(seconds * rate_hz)
    hiss = bandpass(fork(rng).standard_normal(count), 400.0, log_between(rng, (3_000.0, 12_000.0)), rate_hz=rate_hz)
    drops = np.zeros(count)
    kinds = [_drop(rng, rate_hz) for _ in range(12)]
    for _ in range(round(seconds * log_between(rng, (4.0, 120.0)))):
        drop = kinds[int(rng.integers(len(kinds)))]
        at = int(rng.random() * max(count - len(drop), 1))
        drops[at : at + len(drop)] += drop[: count - at] * log_between(rng, (0.05, 1.0))
    swell = slow(fork(rng), count, step_s=2.0, depth_db=2.0, rate_hz=rate_hz)
    return levelled((levelled(hiss) + between(rng, (0.1, 1.5)) * levelled(drops)) * swell)


def _drop(rng: np.random.Generator, rate_hz: int) -> Samples:
    centre = log_between(rng, (800.0, 9_000.0))
    decay_ms = log_between(rng, (0.5, 6.0))
    return band_burst(rng, rate_hz, band_hz=(0.8 * centre, 1.3 * centre), attack_ms=0.1, decay_ms=decay_ms)


def engine(rng: np.random.Generator, rate_hz: int, seconds: float) -> Samples:
    """Return a motor: firing pulses with harmonics that accelerates and brakes, with road and exhaust noise."""
    count = round(seconds * rate_hz)
    low, high = log_between(rng, (18.0, 60.0)), log_between(rng, (60.0, 220.0))
    step_s = log_between(rng, (1.0, 6.0))
    speeds = fork(rng).uniform(math.log(low), math.log(high), math.ceil(seconds / step_s) + 2)
    pitch_hz = np.exp(smooth_through(speeds, seconds / step_s, count))
    phase = np.cumsum(pitch_hz) / rate_hz
    harmonics = np.arange(1, 25)
    levels = harmonics ** -rng.uniform(0.3, 1.8, len(harmonics))
    turns = harmonics[:, None] * np.arange(_TABLE) / _TABLE + rng.random(len(harmonics))[:, None]
    cycle = np.sum(levels[:, None] * np.sin(2.0 * math.pi * turns), axis=0)
    # two turns of the crank make one working cycle
    sound = cycle[(0.5 * phase * _TABLE).astype(np.int64) & (_TABLE - 1)]
    sound *= 1.0 + 0.3 * np.tanh(lowpass(fork(rng).standard_normal(count), 12.0, rate_hz=rate_hz) * 20.0)
    hiss = bandpass(fork(rng).standard_normal(count), 150.0, log_between(rng, (1_500.0, 7_000.0)), rate_hz=rate_hz)
    mixed = levelled(sound) + between(rng, (0.1, 1.0)) * levelled(hiss) * (pitch_hz / high)
    if chance(rng, 0.3):
        mixed = np.tanh(levelled(mixed) * 2.0)
    return levelled(lowpass(mixed, log_between(rng, (800.0, 9_000.0)), rate_hz=rate_hz))

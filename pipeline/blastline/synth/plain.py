"""What is no shot, as textbooks and sound toolkits draw it: swells, clicks, ticks, thuds, hits, knocks and tones.

`negatives` imitates recordings. These do not: beside `plain_shots` they say what makes a blast a blast. A shot rises
at once and fills the band, a swell never does the one, a tone never the other.
"""

import math
from collections.abc import Callable

import numpy as np

from ..units import gains_from_db
from .chance import between, chance, fork, log_between, pick
from .echoes import overlaid
from .impacts import modes, series
from .steps import soft_step
from .tone import Samples, bandpass, lowpass, rms
from .waves import band_burst, boom, noise_burst, normalised

_LONGEST_S = 3.0
_DULL_HZ = 700.0
"""What has nothing higher is no shot however it rises."""


def plain_negative(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a swell, a click, a knock or a tone, alone or in a row."""
    kind = pick(rng, _NEGATIVES)
    if chance(rng, 0.75):
        return kind(rng, rate_hz)
    gap_s = log_between(rng, (0.08, 1.0))
    sounds = [kind(fork(rng), rate_hz)] * 2 if chance(rng, 0.5) else [kind(fork(rng), rate_hz) for _ in range(3)]
    count = int(rng.integers(1, max(2, min(20, round(4.0 / gap_s)))))
    gaps = gap_s * (1.0 + between(rng, (0.0, 0.1)) * rng.uniform(-1.0, 1.0, count))
    return series(rng, sounds, gaps_s=gaps, levels_db=1.5, rate_hz=rate_hz)


def swell(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return noise or a low tone that takes 12 to 250 ms to rise."""
    attack_s, decay_s = log_between(rng, (0.012, 0.25)), log_between(rng, (0.03, 1.0))
    frames = round(min(_LONGEST_S, 3.0 * attack_s + 7.0 * decay_s) * rate_hz)
    times = np.arange(frames) / rate_hz
    if chance(rng, 0.7):
        low_hz = log_between(rng, (15.0, 1_500.0))
        sound = bandpass(
            fork(rng).standard_normal(frames), low_hz, low_hz * log_between(rng, (1.5, 60.0)), rate_hz=rate_hz
        )
    else:
        start_hz = log_between(rng, (25.0, 250.0))
        sound = boom(
            rate_hz,
            start_hz=start_hz,
            stop_hz=start_hz * between(rng, (0.3, 1.2)),
            attack_ms=0.3 * attack_s * 1e3,
            decay_ms=1e3 * max(decay_s, 0.05),
        )[:frames]
        times = times[: len(sound)]
    if chance(rng, 0.5):
        rise = 1.0 - np.exp(-times / attack_s)
    else:
        rise = np.minimum(times / attack_s, 1.0) ** between(rng, (0.7, 2.0))
    return normalised(sound * rise * np.exp(-times / decay_s))


def _click(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a burst of noise of a quarter of a millisecond to three, in all of the band or a part of it."""
    low_hz = log_between(rng, (20.0, 4_000.0))
    band_hz = (low_hz, min(0.4 * rate_hz, low_hz * log_between(rng, (4.0, 500.0))))
    decay_ms = log_between(rng, (0.04, 0.5))
    return band_burst(fork(rng), rate_hz, band_hz=band_hz, attack_ms=0.0, decay_ms=decay_ms)


def tick(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return what a splice, a scratch or a lost sample leaves: up to three pulses of a sixth of a millisecond."""
    ticks = np.zeros(round(0.02 * rate_hz))
    for at in (0, *rng.integers(1, len(ticks) // 4, int(rng.integers(0, 3))).tolist()):
        width = max(1, round(log_between(rng, (0.01, 0.16)) * 1e-3 * rate_hz))
        pulse = np.full(width, pick(rng, (-1.0, 1.0)) * between(rng, (0.3, 1.0)))
        if chance(rng, 0.5):
            pulse[width // 2 :] *= -1.0
        ticks[at : at + width] += pulse
    if chance(rng, 0.6):
        ticks = lowpass(ticks, log_between(rng, (3_000.0, 20_000.0)), rate_hz=rate_hz, order=pick(rng, (1, 2)))
    return normalised(ticks)


def thud(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a dull blow as a toolkit makes it: low noise that rises softly where it is not the very lowest, or a step.

    Perhaps it lies over a tone that falls.
    """
    if chance(rng, 0.4):
        return soft_step(rng, rate_hz)
    top_hz = log_between(rng, (150.0, 2_000.0))
    least_ms, longest_ms = (0.3, 150.0) if top_hz < _DULL_HZ else (2.5, 50.0)
    attack_ms, decay_ms = log_between(rng, (least_ms, 12.0)), log_between(rng, (10.0, longest_ms))
    noise = noise_burst(fork(rng), rate_hz, attack_ms=attack_ms, decay_ms=decay_ms)
    noise = normalised(lowpass(noise, top_hz, rate_hz=rate_hz, order=1 if top_hz < _DULL_HZ else 2))
    low_hz, decay_ms = log_between(rng, (40.0, 160.0)), log_between(rng, (30.0, 200.0))
    start_hz = low_hz * log_between(rng, (1.0, 5.0))
    tone = boom(rate_hz, start_hz=start_hz, stop_hz=low_hz, attack_ms=log_between(rng, (0.1, 5.0)), decay_ms=decay_ms)
    return normalised(overlaid([(0, noise * between(rng, (0.0, 1.0))), (0, tone * between(rng, (0.2, 1.0)))]))


def hit(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a hand or a drum as a toolkit makes it: noise above a kilohertz, perhaps in flams or over a tone."""
    low_hz = log_between(rng, (700.0, 6_000.0))
    band_hz = (low_hz, min(0.45 * rate_hz, low_hz * log_between(rng, (2.0, 20.0))))
    decay_ms, attack_ms = log_between(rng, (4.0, 150.0)), log_between(rng, (0.1, 2.0))
    noise = band_burst(fork(rng), rate_hz, band_hz=band_hz, attack_ms=attack_ms, decay_ms=decay_ms)
    parts = [(0, noise)]
    for _ in range(int(rng.integers(0, 3)) if decay_ms < 20.0 else 0):
        parts.append((round(between(rng, (0.006, 0.025)) * rate_hz), noise))
    if chance(rng, 0.4):
        tone = modes(rate_hz, np.array([log_between(rng, (130.0, 350.0))]), np.array([0.06]), np.array([1.0]))
        parts.append((0, normalised(tone) * between(rng, (0.1, 1.0))))
    return normalised(overlaid(parts))


def _knock(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return 1 to 10 damped tones that begin together, at once or within some milliseconds."""
    count = int(rng.integers(1, 11))
    frequencies_hz = np.exp(rng.uniform(math.log(80.0), math.log(6_000.0), count))
    decays_s = np.exp(rng.uniform(math.log(0.005), math.log(0.25), count))
    sound = modes(rate_hz, frequencies_hz, decays_s, gains_from_db(rng.uniform(-20.0, 0.0, count)))
    attack_s = log_between(rng, (0.0002, 0.008))
    return normalised(sound * (1.0 - np.exp(-np.arange(1, len(sound) + 1) / (attack_s * rate_hz))))


def _tone(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a tone that glides, with a rise of 1 ms and more."""
    return gliding(rng, rate_hz, log_between(rng, (60.0, 6_000.0)), log_between(rng, (0.03, 1.5)))


_NEGATIVES: tuple[Callable[[np.random.Generator, int], Samples], ...] = (
    swell,
    swell,
    _click,
    tick,
    thud,
    thud,
    hit,
    _knock,
    _knock,
    _tone,
)


def gliding(rng: np.random.Generator, rate_hz: int, hz: float, seconds: float) -> Samples:
    """Return a tone with up to four overtones that glides by a sixth at most, under a bow of a sine's power."""
    frames = max(2, round(seconds * rate_hz))
    phase = 2.0 * math.pi * np.cumsum(np.linspace(hz, hz * between(rng, (0.8, 1.25)), frames)) / rate_hz
    harmonics = range(1, int(rng.integers(2, 7)))
    tone = sum((np.sin(n * phase) / n for n in harmonics if n * hz < 0.4 * rate_hz), np.zeros(frames))
    bow = np.sin(math.pi * np.arange(frames) / frames) ** between(rng, (0.3, 2.0))
    return normalised(tone * bow)


def sloped_noise(rng: np.random.Generator, frames: int, power: float) -> Samples:
    """Return noise with an rms of 1 whose power spectrum goes with the frequency to a power, flat below 20 Hz."""
    from scipy.fft import irfft, next_fast_len, rfft

    size = next_fast_len(frames, real=True)
    spectrum = rfft(rng.standard_normal(size))
    bins = np.maximum(np.arange(len(spectrum)), size / 2_400.0)
    noise = irfft(spectrum * (bins / bins[-1]) ** (power / 2.0), size)[:frames]
    return np.asarray(noise / rms(noise), np.float64)

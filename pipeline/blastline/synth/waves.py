"""The pressure waves of a gun, as formulas, and noise that dies away.

    Friedlander   p(t) = (1 - t/T) exp(-b t/T)          the muzzle blast, T the positive phase
    N-wave        p(t) = 1 - 2 t/L                       the ballistic shock of a supersonic bullet, L its length
    boom          a falling low tone that sound designers lay under a shot

Every wave starts in its first sample and is zero before it.
"""

import math
from dataclasses import dataclass

import numpy as np

from .chance import fork
from .tone import Samples, bandpass


def friedlander(rate_hz: int, *, positive_ms: float, rise_ms: float = 0.0, decay: float = 1.0) -> Samples:
    """Return a blast wave with a peak of 1, after a rise of half a raised cosine, until it has died to 1e-4.

    With `decay` 1 and no rise, the impulses of its positive and its negative phase are T/e and -T/e
    (Friedlander 1946).
    """
    positive = positive_ms * 1e-3
    times = np.arange(math.ceil(positive * 12.0 / decay * rate_hz)) / rate_hz
    blast = (1.0 - times / positive) * np.exp(-decay * times / positive)
    return np.concatenate([_rise(rate_hz, rise_ms), blast])


def n_wave(rate_hz: int, *, length_ms: float, rise_ms: float) -> Samples:
    """Return the N-wave with a peak of 1: a rise, a straight fall to -1 in `length_ms`, and a return."""
    rise = _rise(rate_hz, rise_ms)
    fall = np.linspace(1.0, -1.0, max(2, round(length_ms * 1e-3 * rate_hz)))
    return np.concatenate([rise, fall, -rise[::-1]])


def noise_burst(rng: np.random.Generator, rate_hz: int, *, attack_ms: float, decay_ms: float) -> Samples:
    """Return white noise that rises linearly and falls by a factor e every `decay_ms`, with a peak of about 1."""
    times = np.arange(math.ceil((attack_ms + 7.0 * decay_ms) * 1e-3 * rate_hz) + 1) / rate_hz * 1e3
    attack = np.minimum((times + 1e3 / rate_hz) / max(attack_ms, 1e3 / rate_hz), 1.0)
    decay = np.exp(-np.maximum(times - attack_ms, 0.0) / decay_ms)
    return np.asarray(rng.standard_normal(len(times)) / 3.0 * attack * decay, dtype=np.float64)


def band_burst(
    rng: np.random.Generator, rate_hz: int, *, band_hz: tuple[float, float], attack_ms: float, decay_ms: float
) -> Samples:
    """Return a burst of noise within a band, with a peak of exactly 1."""
    burst = noise_burst(rng, rate_hz, attack_ms=attack_ms, decay_ms=decay_ms)
    return normalised(bandpass(burst, *band_hz, rate_hz=rate_hz))


@dataclass(frozen=True)
class NoiseBurst:
    """A burst of noise within a band, so many samples after what it belongs to begins; `gain` is its peak."""

    after: int
    gain: float
    attack_ms: float
    decay_ms: float
    band_hz: tuple[float, float]

    def made(self, rng: np.random.Generator, rate_hz: int) -> Samples:
        """Return the burst, whose noise is another one each time."""
        burst = band_burst(fork(rng), rate_hz, band_hz=self.band_hz, attack_ms=self.attack_ms, decay_ms=self.decay_ms)
        return burst * self.gain


def boom(rate_hz: int, *, start_hz: float, stop_hz: float, attack_ms: float, decay_ms: float) -> Samples:
    """Return a tone that falls from `start_hz` towards `stop_hz` as it decays, with a peak of 1."""
    times = np.arange(math.ceil((attack_ms + 7.0 * decay_ms) * 1e-3 * rate_hz)) / rate_hz
    glide = decay_ms * 1e-3
    phase = stop_hz * times + (start_hz - stop_hz) * glide * (1.0 - np.exp(-times / glide))
    attack = 1.0 - np.exp(-times * 1e3 / attack_ms)
    return normalised(np.sin(2.0 * math.pi * phase) * attack * np.exp(-times / glide))


def normalised(samples: Samples) -> Samples:
    """Return the samples with a peak of 1; silence stays silence."""
    top = float(np.max(np.abs(samples), initial=0.0))
    return samples / top if top > 0.0 else samples


def _rise(rate_hz: int, rise_ms: float) -> Samples:
    """Return the samples before the peak, sin^2 from above zero to below one; none for a rise under one sample."""
    count = max(0, round(rise_ms * 1e-3 * rate_hz) - 1)
    return np.asarray(np.sin(np.arange(1, count + 1) / (count + 1) * (math.pi / 2.0)) ** 2, dtype=np.float64)

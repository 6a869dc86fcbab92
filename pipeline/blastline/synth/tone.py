"""Filters and dynamics that colour a sound. Every one is causal: silence before an onset stays exactly zero."""

import math

import numpy as np
from numpy.typing import NDArray

from ..units import gain_from_db

Samples = NDArray[np.float64]


def lowpass(samples: Samples, corner_hz: float, *, rate_hz: int, order: int = 1) -> Samples:
    """Return the samples through a Butterworth low-pass; unchanged where the corner is at or above 0.45 of the rate."""
    if corner_hz >= 0.45 * rate_hz:
        return samples
    return _butterworth(samples, corner_hz, "lowpass", rate_hz, order)


def highpass(samples: Samples, corner_hz: float, *, rate_hz: int, order: int = 1) -> Samples:
    """Return the samples through a Butterworth high-pass; silence where the corner is at or above 0.45 of the rate."""
    if corner_hz >= 0.45 * rate_hz:
        return np.zeros_like(samples)
    return _butterworth(samples, corner_hz, "highpass", rate_hz, order)


def bandpass(samples: Samples, low_hz: float, high_hz: float, *, rate_hz: int, order: int = 1) -> Samples:
    """Return the samples through a high-pass at `low_hz` and a low-pass at `high_hz`."""
    high = highpass(samples, low_hz, rate_hz=rate_hz, order=order)
    return lowpass(high, high_hz, rate_hz=rate_hz, order=order)


def resonance(samples: Samples, centre_hz: float, *, bandwidth_hz: float, rate_hz: int) -> Samples:
    """Return the samples through a two-pole resonator with unit gain at its centre; silence above 0.45 of the rate."""
    from scipy.signal import lfilter

    if centre_hz >= 0.45 * rate_hz:
        return np.zeros_like(samples)
    radius = math.exp(-math.pi * bandwidth_hz / rate_hz)
    angle = 2.0 * math.pi * centre_hz / rate_hz
    poles = [1.0, -2.0 * radius * math.cos(angle), radius * radius]
    gain = abs(np.polyval(poles[::-1], np.exp(-1j * angle)))
    return np.asarray(lfilter([gain], poles, samples), dtype=np.float64)


def tilt(samples: Samples, level_db: float, *, pivot_hz: float, rate_hz: int) -> Samples:
    """Return the samples with everything above the pivot raised, and everything below lowered, by half of `level_db`.

    A first-order shelf: T(s) = (g s + w) / (s + g w), g = 10^(level_db / 40), w = 2 pi pivot.
    """
    from scipy.signal import bilinear, lfilter

    gain = 10.0 ** (level_db / 40.0)
    corner = 2.0 * math.pi * min(pivot_hz, 0.2 * rate_hz)
    numerator, denominator = bilinear([gain, corner], [1.0, gain * corner], fs=rate_hz)
    return np.asarray(lfilter(numerator, denominator, samples), dtype=np.float64)


def saturate(samples: Samples, drive_db: float) -> Samples:
    """Return the samples as an overdriven stage gives them: tanh(g x) / tanh(g) for a peak of 1, gain g >= 1."""
    gain = gain_from_db(drive_db)
    return np.asarray(np.tanh(gain * samples) / math.tanh(gain), dtype=np.float64)


def compress(samples: Samples, *, threshold: float, ratio: float, release_ms: float, rate_hz: int) -> Samples:
    """Return the samples through a limiter: instant attack, exponential release, `ratio` above the threshold.

    The envelope is e[n] = max(|x[n]|, a e[n-1]), a = exp(-1 / release). In logarithms that is a running maximum.
    """
    ramp = np.arange(len(samples)) / (release_ms * 1e-3 * rate_hz)
    with np.errstate(divide="ignore"):
        level = np.log(np.abs(samples))
    envelope = np.maximum.accumulate(level + ramp) - ramp
    over = np.maximum(envelope - math.log(threshold), 0.0)
    return np.asarray(samples * np.exp(over * (1.0 / ratio - 1.0)), dtype=np.float64)


def peak(samples: NDArray[np.floating]) -> float:
    """Return the largest magnitude; 0 for nothing."""
    return float(np.max(np.abs(samples), initial=0.0))


def rms(samples: Samples) -> float:
    """Return the root of the mean square; 0 for nothing."""
    return math.sqrt(float(np.mean(np.square(samples)))) if samples.size else 0.0


def trimmed(samples: Samples, *, floor: float = 3e-4) -> Samples:
    """Return the samples up to the last one above a part of their peak, the last tenth of them faded out."""
    loud = np.flatnonzero(np.abs(samples) > floor * peak(samples))
    ending = samples[: int(loud[-1]) + 1 if loud.size else 0].copy()
    fade = len(ending) // 10
    ending[len(ending) - fade :] *= np.linspace(1.0, 0.0, fade)
    return ending


def _butterworth(samples: Samples, corner_hz: float, kind: str, rate_hz: int, order: int) -> Samples:
    from scipy.signal import butter, lfilter, sosfilt

    if order == 1:
        # the bilinear transform by hand: designing costs more than filtering a short sound
        k = math.tan(math.pi * corner_hz / rate_hz)
        numerator = [k / (k + 1.0), k / (k + 1.0)] if kind == "lowpass" else [1.0 / (k + 1.0), -1.0 / (k + 1.0)]
        return np.asarray(lfilter(numerator, [1.0, (k - 1.0) / (k + 1.0)], samples), dtype=np.float64)
    sections = butter(order, corner_hz, kind, fs=rate_hz, output="sos")
    return np.asarray(sosfilt(sections, samples), dtype=np.float64)

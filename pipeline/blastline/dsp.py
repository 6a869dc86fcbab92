"""Filters as zeros, poles and a gain, and how they become digital.

    H(s)  = k prod(s - z_i) / prod(s - p_i)             what is felt, per volt of drive
    C(s)  = 1 / H(s)                                    the compensator
    L(s)  Butterworth low-pass,  D(s)  Butterworth high-pass

Everything runs in float64 second-order sections: transfer-function form diverges for low corners, and float32
sections lose 45 dB and crawl in digital silence.
"""

import math
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from .ruleset import ActuatorProfile

_EARLY = math.sqrt(2.0) - 1.0

# How `digital` fits, in cycles per sample: chosen by its error over 8 to 384 kHz against its gain at half the rate.
_TAPS = 8
_EXTRA_POLES = np.full(3, -0.75)
_LOW, _HIGH = 0.05, 0.41


@dataclass(frozen=True, eq=False)
class Analogue:
    """An analogue filter: zeros and poles in rad/s, and its gain."""

    zeros: NDArray[np.complex128]
    poles: NDArray[np.complex128]
    gain: float

    def __mul__(self, other: "Analogue") -> "Analogue":
        """Return the two filters in series."""
        return Analogue(
            np.concatenate([self.zeros, other.zeros]),
            np.concatenate([self.poles, other.poles]),
            self.gain * other.gain,
        )

    def at(self, frequencies_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Return the complex response at the given frequencies."""
        s = 2j * math.pi * frequencies_hz[:, None]
        return cast(
            "NDArray[np.complex128]",
            self.gain * np.prod(s - self.zeros, axis=1) / np.prod(s - self.poles, axis=1),
        )


def felt_response(profile: ActuatorProfile) -> Analogue:
    """Return H(s), from drive to perceived vibration."""
    response = profile.response
    return Analogue(_roots(response.zeros_rad_s), _roots(response.poles_rad_s), response.gain)


def band(profile: ActuatorProfile) -> Analogue:
    """Return L(s) D(s), the band in which the vibration is meant to follow the sound."""
    low = _butterworth(profile.lowpass.order, profile.lowpass.corner_hz, "lowpass")
    high = _butterworth(profile.highpass.order, profile.highpass.corner_hz, "highpass")
    return low * high


def half_band(profile: ActuatorProfile) -> Analogue:
    """Return B(s), the band of which B(s) B(-s) has no phase: run forwards, then backwards.

    Twice together it is 3 dB down at the corners of `band` and falls at least as fast above. Its order is at
    least the compensator's rise, so that C(s) B(s) can be realised.
    """
    low, high, response = profile.lowpass, profile.highpass, profile.response
    rise = len(response.poles_rad_s) - len(response.zeros_rad_s)
    low_order, high_order = max((low.order + 1) // 2, rise), (high.order + 1) // 2
    # |B|^2 = 1 / (1 + (f / g)^2n) is 1 / sqrt(2) at the corner f when (f / g)^2n = sqrt(2) - 1
    low_hz = low.corner_hz / _EARLY ** (0.5 / low_order)
    high_hz = high.corner_hz * _EARLY ** (0.5 / high_order)
    return _butterworth(low_order, low_hz, "lowpass") * _butterworth(high_order, high_hz, "highpass")


def inverse(profile: ActuatorProfile) -> Analogue:
    """Return C(s) = 1 / H(s), which is improper: only in series with a band can it be realised."""
    felt = felt_response(profile)
    return Analogue(felt.poles, felt.zeros, 1.0 / felt.gain)


def compensator(profile: ActuatorProfile) -> Analogue:
    """Return C(s) L(s) D(s), whose output drives the actuator so that H makes it the sound in the band."""
    return inverse(profile) * band(profile)


def digital(analogue: Analogue, rate_hz: int) -> NDArray[np.float64]:
    """Return a filter as second-order sections, shape (sections, 6), whose response is near the analogue one.

    Poles and zeros go to exp(s T), T = 1 / rate; what that leaves of the response, its fall towards half the sample
    rate, is fitted by least squares with a few free zeros over poles at -0.75:

        F(z) = prod(1 - e^(z_i T) / z) / prod(1 - e^(p_i T) / z)  *  sum(c_k z^-k) / (1 + 0.75 / z)^3

    Up to 2 kHz at 44.1 kHz the compensator of the built-in actuator is off by -69 dB of its peak; by the bilinear
    transform it would be -50 dB. An improper filter raises ValueError; a low-pass in series keeps zeros from
    outnumbering poles.
    """
    from scipy.signal import zpk2sos

    if len(analogue.zeros) > len(analogue.poles):
        raise ValueError(f"improper filter: {len(analogue.zeros)} zeros over {len(analogue.poles)} poles")
    zeros = np.exp(analogue.zeros / rate_hz)
    poles = np.concatenate([np.exp(analogue.poles / rate_hz), _EXTRA_POLES])
    taps = _fitted_taps(analogue, zeros, poles, rate_hz)
    zeros = np.concatenate([zeros, np.roots(taps)])
    size = max(len(zeros), len(poles))
    sections = zpk2sos(np.pad(zeros, (0, size - len(zeros))), np.pad(poles, (0, size - len(poles))), taps[0])
    return np.asarray(sections, dtype=np.float64)


def _fitted_taps(
    analogue: Analogue, zeros: NDArray[np.complex128], poles: NDArray[np.complex128], rate_hz: int
) -> NDArray[np.float64]:
    """Return the taps c_k that bring digital zeros and poles nearest to the analogue response.

    The band of vibration, which lies low, counts most. Close to half the rate, where a digital response has to become
    real, the wanted one falls to nothing and counts least: left out, the fit would gain there without bound.
    """
    cycles = np.concatenate([np.geomspace(1e-5, _LOW, 200), np.linspace(_LOW, 0.5, 800)])
    beyond = np.maximum(cycles - _HIGH, 0.0) / (0.5 - _HIGH)
    weights = np.select([cycles <= _LOW, beyond > 0.0], [20.0, 0.1], 1.0)
    delay = np.exp(-2j * math.pi * cycles)[:, None]
    matched = np.prod(1.0 - delay * zeros, axis=1) / np.prod(1.0 - delay * poles, axis=1)
    wanted = weights * analogue.at(cycles * rate_hz) * np.cos(math.pi / 2.0 * beyond)
    scale = float(np.max(np.abs(wanted)))
    columns = (weights * matched)[:, None] * delay ** np.arange(_TAPS)
    taps = np.linalg.lstsq(
        np.concatenate([columns.real, columns.imag]), np.concatenate([wanted.real, wanted.imag]) / scale
    )[0]
    return np.asarray(scale * taps, dtype=np.float64)


def run_filter(sections: NDArray[np.float64], samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return one column of samples through the sections, starting from rest."""
    from scipy.signal import sosfilt

    return np.asarray(sosfilt(sections, samples), dtype=np.float64)


def fade(samples: int) -> NDArray[np.float64]:
    """Return the rising half of an equal-gain cross-fade, sin^2 at the middle of each of its samples.

    Dry and compensated sound are one signal, so the weights of a fade, not their squares, sum to one:
    `fade(n) + fade(n)[::-1] == 1`.
    """
    phase = (np.arange(samples) + 0.5) / max(samples, 1) * (math.pi / 2.0)
    return np.asarray(np.sin(phase) ** 2, dtype=np.float64)


def cross_fade(dry: NDArray[np.float64], wet: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return `dry` where the weight is 0 and `wet` where it is 1, exactly, and a straight mix between.

    Written as dry + w (wet - dry), so that fading a signal into itself changes nothing.
    """
    mixed = dry + weights * (wet - dry)
    return np.where(weights == 1.0, wet, mixed)


def _butterworth(order: int, corner_hz: float, kind: str) -> Analogue:
    from scipy.signal import butter

    zeros, poles, gain = butter(order, 2.0 * math.pi * corner_hz, kind, analog=True, output="zpk")
    return Analogue(np.asarray(zeros, np.complex128), np.asarray(poles, np.complex128), float(gain))


def _roots(pairs: tuple[tuple[float, float], ...]) -> NDArray[np.complex128]:
    return np.array([complex(real, imaginary) for real, imaginary in pairs], dtype=np.complex128)

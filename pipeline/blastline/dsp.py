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


def compensator(profile: ActuatorProfile) -> Analogue:
    """Return C(s) L(s) D(s), whose output drives the actuator so that H makes it the sound in the band."""
    felt = felt_response(profile)
    return Analogue(felt.poles, felt.zeros, 1.0 / felt.gain) * band(profile)


def digital(analogue: Analogue, rate_hz: int) -> NDArray[np.float64]:
    """Return the bilinear transform of a filter as second-order sections, shape (sections, 6).

    A low-pass in series keeps zeros from outnumbering poles; an improper filter raises ValueError.
    """
    from scipy.signal import bilinear_zpk, zpk2sos

    if len(analogue.zeros) > len(analogue.poles):
        raise ValueError(f"improper filter: {len(analogue.zeros)} zeros over {len(analogue.poles)} poles")
    sections = zpk2sos(*bilinear_zpk(analogue.zeros, analogue.poles, analogue.gain, rate_hz))
    return np.asarray(sections, dtype=np.float64)


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

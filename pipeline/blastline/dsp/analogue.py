"""Analogue filters as zeros, poles and a gain.

H(s)  = k prod(s - z_i) / prod(s - p_i)             what is felt, per unit of drive (1 is the limit)
C(s)  = 1 / H(s)                                    the compensator
L(s)  Butterworth low-pass,  D(s)  Butterworth high-pass
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..ruleset import ActuatorProfile

_EARLY = math.sqrt(2.0) - 1.0

_SETTLE_S = (0.6, 18.0)
_SETTLE_TIMES = 18.0
"""Filters run at least and at most this long before what is compared; between, 18 of their slowest time constants.

A film that stands off zero is a step where they begin: the band's high-pass needs 0.6 s for 1e-8 of it."""

_PREROLL_FOR_S = 0.05
"""The time constant of filters for which rules state their pre-roll; slower ones get more."""


@dataclass(frozen=True, eq=False)
class Analogue:
    """An analogue filter: its zeros and its poles in rad/s, one-dimensional, and k, its gain in the formula above."""

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
        """Return the complex response at n frequencies, shape (n,)."""
        s = 2j * math.pi * frequencies_hz[:, None]
        return np.asarray(
            self.gain * np.prod(s - self.zeros, axis=1) / np.prod(s - self.poles, axis=1), dtype=np.complex128
        )


def felt_response(profile: ActuatorProfile) -> Analogue:
    """Return H(s), from drive to perceived vibration."""
    response = profile.response
    return Analogue(_roots(response.zeros_rad_s), _roots(response.poles_rad_s), response.gain)


def band(profile: ActuatorProfile) -> Analogue:
    """Return L(s) D(s), the band in which the vibration is meant to follow the sound."""
    low = butterworth(profile.lowpass.order, profile.lowpass.corner_hz, "lowpass")
    high = butterworth(profile.highpass.order, profile.highpass.corner_hz, "highpass")
    return low * high


def half_band(profile: ActuatorProfile) -> Analogue:
    """Return B(s), the band of which B(s) B(-s) has no phase: run forwards, then backwards.

    Twice together it is 3 dB down at the corners of `band` and falls at least as fast above. Its order is at least two
    more than the compensator's rise, so that C(s) B(s) falls towards half the sample rate, as a digital filter must.
    """
    low, high, response = profile.lowpass, profile.highpass, profile.response
    rise = len(response.poles_rad_s) - len(response.zeros_rad_s)
    low_order, high_order = max((low.order + 1) // 2, rise + 2), (high.order + 1) // 2
    # |B|^2 = 1 / (1 + (f / g)^2n) is 1 / sqrt(2) at the corner f when (f / g)^2n = sqrt(2) - 1
    low_hz = low.corner_hz / _EARLY ** (0.5 / low_order)
    high_hz = high.corner_hz * _EARLY ** (0.5 / high_order)
    return butterworth(low_order, low_hz, "lowpass") * butterworth(high_order, high_hz, "highpass")


def inverse(profile: ActuatorProfile) -> Analogue:
    """Return C(s) = 1 / H(s), which is improper: only in series with a band can it be realised."""
    felt = felt_response(profile)
    return Analogue(felt.poles, felt.zeros, 1.0 / felt.gain)


def compensator(profile: ActuatorProfile) -> Analogue:
    """Return C(s) L(s) D(s), whose output drives the actuator so that H makes it the sound in the band."""
    return inverse(profile) * band(profile)


def telling_hz(response: Analogue, low_hz: float, high_hz: float, points: int) -> NDArray[np.float64]:
    """Return ascending frequencies that tell how strongly a filter responds from one to another.

    They are so many at even steps of their logarithm, and those at which it resonates: sharp ones lie between these.
    """
    resonances_hz = np.abs(response.poles.imag) / (2.0 * math.pi)
    inside = (resonances_hz > low_hz) & (resonances_hz < high_hz)
    return np.sort(np.concatenate([np.geomspace(low_hz, high_hz, points), resonances_hz[inside]]))


def slowest_s(*filters: Analogue) -> float:
    """Return the longest time constant of filters."""
    return max(float(np.max(-1.0 / each.poles.real, initial=0.0)) for each in filters)


def preroll_ms(asked_ms: float, time_constant_s: float) -> float:
    """Return for how long filters run before a window, by what rules ask and their longest time constant."""
    return asked_ms * max(1.0, time_constant_s / _PREROLL_FOR_S)


def settle_s(*filters: Analogue) -> float:
    """Return for how long filters have to run, from rest, before what leaves them is as if they had always run."""
    shortest_s, longest_s = _SETTLE_S
    return max(shortest_s, min(_SETTLE_TIMES * slowest_s(*filters), longest_s))


def butterworth(order: int, corner_hz: float, kind: str) -> Analogue:
    """Return a Butterworth filter of a kind that scipy knows, "lowpass" or "highpass"."""
    from scipy.signal import butter

    zeros, poles, gain = butter(order, 2.0 * math.pi * corner_hz, kind, analog=True, output="zpk")
    return Analogue(np.asarray(zeros, np.complex128), np.asarray(poles, np.complex128), float(gain))


def _roots(pairs: tuple[tuple[float, float], ...]) -> NDArray[np.complex128]:
    return np.array([complex(real, imaginary) for real, imaginary in pairs], dtype=np.complex128)

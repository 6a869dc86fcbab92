"""The phase that belongs to a magnitude, and what a measured phase has beyond it: a delay and a polarity.

Bode's relation (Network Analysis and Feedback Amplifier Design, 1945): a stable system without zeros on the right has

    phase(f0) = 1 / pi  *  integral of  dA/du  ln coth(|u - u0| / 2)  du,      A = ln |H|,  u = ln f

Between measured frequencies the Bode plot is taken as straight, beyond them as going on with the slope of its ends.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .measured import MeasuredResponse

Values = NDArray[np.float64]

_EDGE_OCTAVES = 0.5
"""Over so much at either end the slope is taken with which the Bode plot goes on beyond."""

_STEPS_PER_OCTAVE = 24

_SEARCH_S = 0.05
"""So far to either side of the delay that was taken out already the exact one is sought."""


@dataclass(frozen=True)
class ExcessPhase:
    """What a measured phase has beyond that of its magnitude: a delay, a change of sign, and the rest."""

    delay_s: float
    inverted: bool
    residual_rms_deg: float


def minimum_phase(frequencies_hz: Values, gain: Values) -> Values:
    """Return the phase in radians of the minimum-phase system with these gains, which must be positive."""
    log_f, log_gain = np.log(frequencies_hz), np.log(gain)
    slopes = np.diff(log_gain) / np.diff(log_f)
    low, high = _edge_slope(log_f, log_gain), _edge_slope(log_f[::-1], log_gain[::-1])
    kernel = _coth_integral(log_f[None, :] - log_f[:, None])
    between = np.diff(kernel, axis=1) @ slopes
    whole = math.pi**2 / 4.0
    return np.asarray((between + low * (kernel[:, 0] + whole) + high * (whole - kernel[:, -1])) / math.pi)


def excess_phase(measured: MeasuredResponse) -> ExcessPhase | None:
    """Return delay, polarity and the rms rest of a measured phase against minimum phase; None without a phase.

    The phase is averaged over 1/24 octave, which a delay would blur: so it is sought twice, the second time in what the
    first left.
    """
    if measured.phase_rad is None:
        return None
    first = _sought(measured, measured.phase_rad, 0.0)
    return _sought(measured, measured.phase_rad, first.delay_s)


def _sought(measured: MeasuredResponse, phase_rad: Values, known_s: float) -> ExcessPhase:
    without = np.exp(1j * (phase_rad + 2.0 * math.pi * known_s * measured.frequencies_hz))
    frequencies_hz, gain, phasors, weights = _thinned(measured, without)
    phasors = phasors * np.exp(-1j * minimum_phase(frequencies_hz, gain))
    step_s = 0.1 / float(frequencies_hz[-1])
    delays_s = np.arange(-_SEARCH_S, _SEARCH_S, step_s)
    delay_s = float(delays_s[np.argmax(np.abs(_aligned(phasors, frequencies_hz, delays_s, weights)))])
    while step_s > 1e-9:
        near = delay_s + step_s * np.linspace(-1.0, 1.0, 11)
        delay_s = float(near[np.argmax(np.abs(_aligned(phasors, frequencies_hz, near, weights)))])
        step_s /= 5.0
    inverted = float(_aligned(phasors, frequencies_hz, np.array([delay_s]), weights)[0].real) < 0.0
    rest = np.angle(phasors * np.exp(2j * math.pi * frequencies_hz * delay_s) * (-1.0 if inverted else 1.0))
    return ExcessPhase(known_s + delay_s, inverted, float(np.degrees(np.sqrt(np.sum(weights * rest**2)))))


def _aligned(
    phasors: NDArray[np.complex128], frequencies_hz: Values, delays_s: Values, weights: Values
) -> NDArray[np.complex128]:
    """Return the mean phasor that is left when each of the delays is taken out, of magnitude 1 where nothing is."""
    phases = np.exp(2j * math.pi * delays_s[:, None] * frequencies_hz[None, :])
    return np.asarray(phases @ (weights * phasors), dtype=np.complex128)


def _thinned(
    measured: MeasuredResponse, phasors: NDArray[np.complex128]
) -> tuple[Values, Values, NDArray[np.complex128], Values]:
    """Return frequencies, gains, unit phasors and weights (of sum 1) at no more than 24 points in an octave."""
    low_hz, high_hz = measured.band_hz
    inside = (measured.frequencies_hz >= low_hz) & (measured.frequencies_hz <= high_hz)
    frequencies_hz, gain, phasors = measured.frequencies_hz[inside], measured.gain[inside], phasors[inside]
    _, group = np.unique(np.floor(np.log2(frequencies_hz) * _STEPS_PER_OCTAVE), return_inverse=True)
    inverse_variance = 1.0 / (measured.error_db[inside] ** 2 + 0.25)
    total = np.bincount(group, inverse_variance)
    middle_hz = np.exp(np.bincount(group, inverse_variance * np.log(frequencies_hz)) / total)
    middle_gain = np.exp(np.bincount(group, inverse_variance * np.log(np.maximum(gain, 1e-20))) / total)
    real, imaginary = (np.bincount(group, inverse_variance * part) for part in (phasors.real, phasors.imag))
    means = real + 1j * imaginary
    means /= np.maximum(np.abs(means), 1e-300)
    return middle_hz, middle_gain, np.asarray(means, dtype=np.complex128), total / np.sum(total)


def _edge_slope(log_f: Values, log_gain: Values) -> float:
    """Return the slope of the first half octave, at least of the first three points."""
    near = np.abs(log_f - log_f[0]) <= _EDGE_OCTAVES * math.log(2.0)
    near[:3] = True
    return float(np.polyfit(log_f[near], log_gain[near], 1)[0])


def _coth_integral(distance: Values) -> Values:
    """Return the integral of ln coth(|t| / 2) from 0 to each distance: odd, and pi^2 / 4 at infinity.

    It is pi^2 / 4 - 2 chi(exp(-v)), with Legendre's chi(z) = (Li2(z) - Li2(-z)) / 2.
    """
    from scipy.special import spence

    decay = np.exp(-np.abs(distance))
    chi = 0.5 * (spence(1.0 - decay) - spence(1.0 + decay))
    return np.asarray(np.sign(distance) * (math.pi**2 / 4.0 - 2.0 * chi), dtype=np.float64)

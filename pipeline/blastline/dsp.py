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

# How `digital` fits, in cycles per sample: chosen by its error over 8 to 384 kHz and 60 random actuators against its
# gain at half the rate. The extra poles stand where the response has to bend towards its real end.
_EXTRA_POLES = np.array(
    [r * np.exp(1j * math.pi * x) for r, x in ((0.87, 0.84), (0.975, 0.83)) for x in (x, -x)] + [-0.5]
)
_LOW, _HIGH = 0.05, 0.402
_LOW_WEIGHT, _LOW_WEIGHT_IN_FILMS, _FILM_RATE_HZ = 2.0, 15.0, 44_100
_TAPS_AND_BEYOND = ((12, 0.01), (16, 0.002), (20, 0.0005))  # the next where one is not near enough
_ENOUGH, _ROUNDS = 10.0 ** (-40.3 / 20.0), 4

_NEAR_ONE = 1e-6  # of two real poles p, q in one section, (1 - p)(1 - q) is known to 1e-16: at least this, to 1e-10
_RUN, _SILENT = 65_536, 1e-290


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


def digital(analogue: Analogue, rate_hz: int) -> NDArray[np.float64]:
    """Return a filter as second-order sections, shape (sections, 6), whose response is near the analogue one.

    Poles and zeros go to exp(s T), T = 1 / rate; what that leaves of the response, its fall towards half the sample
    rate, is fitted with free zeros over poles q_i that are the same for every filter:

        F(z) = prod(1 - e^(z_i T) / z) / prod(1 - e^(p_i T) / z)  *  sum(c_k z^-k) / prod(1 - q_i / z)

    Up to 2 kHz at 44.1 kHz the compensator of the built-in actuator is off by -73 dB of its peak; by the bilinear
    transform it would be -50 dB. Raises ValueError for an improper filter (a low-pass in series keeps zeros from
    outnumbering poles), and for one that float64 sections cannot hold: a pole so slow that rounding moves it onto
    the unit circle, or a gain beyond floating point.
    """
    if len(analogue.zeros) > len(analogue.poles):
        raise ValueError(f"improper filter: {len(analogue.zeros)} zeros over {len(analogue.poles)} poles")
    zeros = np.exp(analogue.zeros / rate_hz)
    poles = np.concatenate([np.exp(analogue.poles / rate_hz), _EXTRA_POLES])
    taps = _fitted_taps(analogue, zeros, poles, rate_hz)
    return _sections(np.concatenate([zeros, np.roots(taps)]), poles, taps[0])


def _fitted_taps(
    analogue: Analogue, zeros: NDArray[np.complex128], poles: NDArray[np.complex128], rate_hz: int
) -> NDArray[np.float64]:
    """Return the taps c_k that bring digital zeros and poles nearest to the analogue response.

    In films, where it lies low, the band of vibration counts most. Close to half the rate, where a digital response
    has to become real, the wanted one falls to nothing and counts least: left out, the fit would gain there without
    bound. Where the fit is not near enough, it takes more taps and more gain there.
    """
    cycles = np.concatenate([np.geomspace(1e-5, _LOW, 250), np.linspace(_LOW, 0.5, 400)[1:]])
    beyond = np.maximum(cycles - _HIGH, 0.0) / (0.5 - _HIGH)
    wanted = analogue.at(cycles * rate_hz)
    peak = float(np.max(np.abs(wanted[cycles <= max(2000.0 / rate_hz, _LOW)])))
    if not (np.all(np.isfinite(wanted)) and 0.0 < peak < math.inf):
        raise ValueError(f"a filter with a gain of {peak:g} cannot be computed")
    wanted = wanted * np.cos(math.pi / 2.0 * beyond) / peak
    delay = np.exp(-2j * math.pi * cycles)
    matched = _response(zeros, poles, delay)
    taps = np.zeros(0)
    for count, beyond_weight in _TAPS_AND_BEYOND:
        low_weight = _LOW_WEIGHT_IN_FILMS if rate_hz >= _FILM_RATE_HZ else _LOW_WEIGHT
        weights = np.select([cycles <= _LOW, beyond > 0.0], [low_weight, beyond_weight], 1.0)
        taps, error = _minimax(matched[:, None] * delay[:, None] ** np.arange(count), wanted, weights)
        if error <= _ENOUGH:
            break
    return np.asarray(peak * taps, dtype=np.float64)


def _minimax(
    columns: NDArray[np.complex128], wanted: NDArray[np.complex128], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float]:
    """Return real coefficients whose largest error weights |columns c - wanted| is small, and that error.

    Least squares, weighted anew where the error is large (Lawson 1961), so that its largest falls.
    """
    best, least, pull = np.zeros(columns.shape[1]), math.inf, weights
    for _ in range(1 + _ROUNDS):
        left, right = pull[:, None] * columns, pull * wanted
        found = np.linalg.lstsq(np.concatenate([left.real, left.imag]), np.concatenate([right.real, right.imag]))[0]
        errors = np.abs(columns @ found - wanted) * weights
        if (worst := float(np.max(errors))) < least:
            best, least = found, worst
        if worst == 0.0:
            break
        pull = pull * np.sqrt(errors / np.sqrt(np.mean(errors**2)) + 0.02)
    return best, least


def _response(
    zeros: NDArray[np.complex128], poles: NDArray[np.complex128], delay: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Return prod(1 - delay zero) / prod(1 - delay pole), zeros and poles by turns so that nothing overflows."""
    response = np.ones(len(delay), np.complex128)
    for index in range(max(len(zeros), len(poles))):
        if index < len(zeros):
            response *= 1.0 - delay * zeros[index]
        if index < len(poles):
            response /= 1.0 - delay * poles[index]
    return response


def _sections(zeros: NDArray[np.complex128], poles: NDArray[np.complex128], gain: float) -> NDArray[np.float64]:
    """Return the second-order sections of a filter, those with the sharpest poles last.

    Each takes the pair of zeros that lies nearest to its poles, so that none gains more than it must.
    """
    above, below = _pairs(zeros), _pairs(poles)
    count = max(len(above), len(below))
    above += [(0j, 0j)] * (count - len(above))
    below += [(0j, 0j)] * (count - len(below))
    rows = []
    for pair in sorted(below, key=lambda pair: -max(abs(root) for root in pair)):
        near = min(above, key=lambda roots: abs(roots[0] - pair[0]) + abs(roots[1] - pair[1]))
        above.remove(near)
        rows.append([*_quadratic(near), *_quadratic(pair)])
    sections = np.array(rows[::-1])
    sections[0, :3] *= gain
    first, second = sections[:, 4], sections[:, 5]
    # both sums are exact: the rounded filter is stable, not merely the wanted one
    if not np.all((np.abs(second) < 1.0) & ((1.0 + first) + second > 0.0) & ((1.0 - first) + second > 0.0)):
        raise ValueError("a pole decays too slowly for its filter to be stable once its numbers are rounded")
    return sections


def _pairs(roots: NDArray[np.complex128]) -> list[tuple[complex, complex]]:
    """Return roots by twos: complex ones with their conjugate, real ones so that no section loses them in rounding.

    Near z = 1 a section is 1 - (p + q) + p q: of two slow roots p and q, only the rounding of these numbers would be
    left. The slowest goes with the fastest; where that one is slow as well, each has a section to itself.
    """
    real = [complex(root) for root in roots if root.imag == 0.0]
    real = sorted([*real, 0j] if len(real) % 2 else real, key=lambda root: abs(1.0 - root))
    pairs = [(complex(root), complex(root).conjugate()) for root in roots if root.imag > 0.0]
    if len(real) // 2 * 2 + 2 * len(pairs) < len(roots):
        raise ValueError("complex zeros and poles must come with their conjugates")
    for slow, fast in zip(real[: len(real) // 2], real[::-1], strict=False):
        apart = 0.0 < abs((1.0 - slow) * (1.0 - fast)) < _NEAR_ONE
        pairs += [(slow, 0j), (fast, 0j)] if apart else [(slow, fast)]
    return pairs


def _quadratic(pair: tuple[complex, complex]) -> tuple[float, float, float]:
    return 1.0, -(pair[0] + pair[1]).real, (pair[0] * pair[1]).real


def run_filter(sections: NDArray[np.float64], samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return one column of samples through the sections, starting from rest.

    What has decayed below 1e-290 is silence: left to decay, it would end in denormal numbers, which never reach 0 and
    take ten times as long to add.
    """
    from scipy.signal import sosfilt

    state, filtered = np.zeros((len(sections), 2)), np.zeros(len(samples))
    for start in range(0, len(samples), _RUN):
        piece = samples[start : start + _RUN]
        state[np.abs(state) < _SILENT] = 0.0
        if np.any(state) or not np.max(np.abs(piece)) < _SILENT:
            filtered[start : start + _RUN], state = sosfilt(sections, piece, zi=state)
    return filtered


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


def butterworth(order: int, corner_hz: float, kind: str) -> Analogue:
    """Return a Butterworth filter of a kind that scipy knows, "lowpass" or "highpass"."""
    from scipy.signal import butter

    zeros, poles, gain = butter(order, 2.0 * math.pi * corner_hz, kind, analog=True, output="zpk")
    return Analogue(np.asarray(zeros, np.complex128), np.asarray(poles, np.complex128), float(gain))


def _roots(pairs: tuple[tuple[float, float], ...]) -> NDArray[np.complex128]:
    return np.array([complex(real, imaginary) for real, imaginary in pairs], dtype=np.complex128)

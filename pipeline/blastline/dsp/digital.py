"""How an analogue filter becomes digital, and runs.

Everything runs in float64 second-order sections: transfer-function form diverges for low corners, and float32
sections lose 45 dB.
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..units import gain_from_db
from .analogue import Analogue

Fits = tuple[tuple[NDArray[np.complex128], int, float], ...]

# How `discretise` fits, in cycles per sample: chosen by its error over 8 to 384 kHz and 60 random actuators against its
# gain at half the rate. The extra poles stand where the response has to bend towards its real end.
_UPPER_POLES = np.array([0.87, 0.975]) * np.exp(1j * math.pi * np.array([0.84, 0.83]))
_MORE_POLES = np.concatenate([_UPPER_POLES, _UPPER_POLES.conj(), [-0.5]])
_FEW_POLES = np.array([0.87 * np.exp(0.9j * math.pi), 0.87 * np.exp(-0.9j * math.pi), -0.5])
_LOW, _HIGH = 0.05, 0.402
_LOW_WEIGHT, _LOW_WEIGHT_IN_FILMS, _FILM_RATE_HZ = 2.0, 15.0, 44_000  # below 44.1 kHz pulled down
# extra poles, taps and the weight close to half the rate; the next where one is not near enough
FITS: Fits = ((_MORE_POLES, 12, 0.01), (_MORE_POLES, 16, 0.002), (_MORE_POLES, 20, 0.0005))
LEAN_FITS: Fits = ((_FEW_POLES, 5, 0.01), *FITS)
_ENOUGH, _ROUNDS = gain_from_db(-40.3), 4
_MOST_BEYOND_IN_FILMS = 9.5  # times what is wanted close to half the rate: nobody feels what is there

_NEAR_ONE = 1e-6  # of two real poles p, q in one section, (1 - p)(1 - q) is known to 1e-16: at least this, to 1e-10
_RUN, _SILENT = 8_192, 1e-290  # in a longer run, most of what decays would be denormal before it is seen


def discretise(analogue: Analogue, rate_hz: int, *, lean: bool = False) -> NDArray[np.float64]:
    """Return a filter as second-order sections, shape (sections, 6), whose response is near the analogue one.

    Poles and zeros go to exp(s T), T = 1 / rate; what that leaves of the response, its fall towards half the sample
    rate, is fitted with free zeros over a few poles q_i that do not depend on the filter:

        F(z) = prod(1 - e^(z_i T) / z) / prod(1 - e^(p_i T) / z)  *  sum(c_k z^-k) / prod(1 - q_i / z)

    Up to 2 kHz at 44.1 kHz the compensator of the built-in actuator is off by -77 dB of its peak; by the bilinear
    transform it would be -50 dB. `lean` is for what runs over much sound: in films it takes half the sections, and that
    compensator is off by -69 dB. Raises ValueError for an improper filter (a low-pass in series keeps zeros from
    outnumbering poles), and for one that float64 sections cannot hold: a pole so slow that rounding moves it onto
    the unit circle, or a gain beyond floating point.
    """
    if len(analogue.zeros) > len(analogue.poles):
        raise ValueError(f"improper filter: {len(analogue.zeros)} zeros over {len(analogue.poles)} poles")
    zeros = np.exp(analogue.zeros / rate_hz)
    fits = LEAN_FITS if lean and rate_hz >= _FILM_RATE_HZ else FITS
    taps, poles = _fitted(analogue, zeros, np.exp(analogue.poles / rate_hz), rate_hz, fits)
    return _sections(np.concatenate([zeros, np.roots(taps)]), poles, taps[0])


def _fitted(
    analogue: Analogue,
    zeros: NDArray[np.complex128],
    poles: NDArray[np.complex128],
    rate_hz: int,
    fits: Fits,
) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Return the taps c_k that bring digital zeros and poles nearest to the analogue response, and all poles.

    In films, where it lies low, the band of vibration counts most. Close to half the rate, where a digital response
    has to become real, the wanted one falls to nothing and counts least: left out, the fit would gain there without
    bound. Where the fit is not near enough, it takes more poles, more taps and then more gain there, in films within
    limits.
    """
    cycles = np.concatenate([np.geomspace(1e-5, _LOW, 250), np.linspace(_LOW, 0.5, 400)[1:]])
    beyond = np.maximum(cycles - _HIGH, 0.0) / (0.5 - _HIGH)
    wanted = analogue.at(cycles * rate_hz)
    peak = float(np.max(np.abs(wanted[cycles <= max(2000.0 / rate_hz, _LOW)])))
    if not (np.all(np.isfinite(wanted)) and 0.0 < peak < math.inf):
        raise ValueError(f"a filter with a gain of {peak:g} cannot be computed")
    most_beyond = float(np.max(np.abs(wanted[beyond > 0.0]))) / peak * _MOST_BEYOND_IN_FILMS
    wanted = wanted * np.cos(math.pi / 2.0 * beyond) / peak
    delay = np.exp(-2j * math.pi * cycles)
    matched = _response(zeros, poles, delay)
    fitted = np.zeros(0), np.zeros(0, np.complex128)
    in_films = rate_hz >= _FILM_RATE_HZ
    low_weight = _LOW_WEIGHT_IN_FILMS if in_films else _LOW_WEIGHT
    for extra, count, beyond_weight in fits:
        weights = np.select([cycles <= _LOW, beyond > 0.0], [low_weight, beyond_weight], 1.0)
        shaped = matched * _response(np.zeros(0, np.complex128), extra, delay)
        columns = shaped[:, None] * delay[:, None] ** np.arange(count)
        taps, error = _minimax(columns, wanted, weights)
        if in_films and fitted[1] is extra and np.max(np.abs(columns @ taps)[beyond > 0.0]) > most_beyond:
            break
        fitted = taps, extra
        if error <= _ENOUGH:
            break
    taps, extra = fitted
    return peak * taps, np.concatenate([poles, extra])


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
    """Return the second-order sections of a filter, those with the sharpest poles last however it lists them.

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
    # both sums are exact: the rounded filter is stable, not merely the wanted one; and above 0 both, -1 < second
    if not np.all((second < 1.0) & ((1.0 + first) + second > 0.0) & ((1.0 - first) + second > 0.0)):
        raise ValueError("a pole decays too slowly for its filter to be stable once its numbers are rounded")
    return sections


def _pairs(roots: NDArray[np.complex128]) -> list[tuple[complex, complex]]:
    """Return roots by twos: complex ones with their conjugate, real ones so that no section loses them in rounding.

    Near z = 1 a section is 1 - (p + q) + p q: of two slow roots p and q, only the rounding of these numbers would be
    left. The slowest goes with the fastest; where that one is slow as well, each has a section to itself.
    """
    real = [complex(root) for root in roots if root.imag == 0.0]
    pairs = [(complex(root), complex(root).conjugate()) for root in roots if root.imag > 0.0]
    if len(real) + 2 * len(pairs) != len(roots):
        raise ValueError("complex zeros and poles must come with their conjugates")
    real = sorted([*real, 0j] if len(real) % 2 else real, key=lambda root: abs(1.0 - root))
    for slow, fast in zip(real[: len(real) // 2], real[::-1], strict=False):
        apart = 0.0 < abs((1.0 - slow) * (1.0 - fast)) < _NEAR_ONE
        pairs += [(slow, 0j), (fast, 0j)] if apart else [(slow, fast)]
    return pairs


def _quadratic(pair: tuple[complex, complex]) -> tuple[float, float, float]:
    return 1.0, -(pair[0] + pair[1]).real, (pair[0] * pair[1]).real


def run_filter(
    sections: NDArray[np.float64], samples: NDArray[np.float64], *, state: NDArray[np.float64] | None = None
) -> NDArray[np.float64]:
    """Return one column of samples through the sections, starting from rest or from a state, shape (sections, 2).

    What has decayed below 1e-290 is silence: left to decay, it would end in denormal numbers, which never reach 0 and
    take ten times as long to add.
    """
    from scipy.signal import sosfilt

    state = np.zeros((len(sections), 2)) if state is None else state.copy()
    stretches = list(_stretches(samples))
    if len(stretches) == 1 and stretches[0][1]:
        state[np.abs(state) < _SILENT] = 0.0
        return np.asarray(sosfilt(sections, samples, zi=state)[0], np.float64)
    # each run goes to its place at once: kept to be joined, they cost as much memory again
    filtered, begun = np.zeros(len(samples)), 0
    for stretch, sounds in stretches:
        state[np.abs(state) < _SILENT] = 0.0
        if sounds or np.any(state):
            filtered[begun : begun + len(stretch)], state = sosfilt(sections, stretch, zi=state)
        begun += len(stretch)
    return filtered


def _stretches(samples: NDArray[np.float64]) -> Iterator[tuple[NDArray[np.float64], bool]]:
    """Yield samples run by run with whether they sound, those that do one after another as one: each has its price."""
    if not len(samples):
        return
    starts = np.arange(0, len(samples), _RUN)
    highest, lowest = np.maximum.reduceat(samples, starts), np.minimum.reduceat(samples, starts)
    silent = (highest < _SILENT) & (lowest > -_SILENT)  # what is no number sounds
    begun = 0
    for start in starts[silent].tolist():
        if begun < start:
            yield samples[begun:start], True
        yield samples[start : start + _RUN], False
        begun = start + _RUN
    if begun < len(samples):
        yield samples[begun:], True

"""Rational models that cannot be unstable: products of factors of first and second order whose corners are positive.

    H(s) = g * prod F_i(s)^(p_i)      F = 1 + s/w                        first order, corner w
                                      F = 1 + 2 d s/w + (s/w)^2          second order, corner w and damping d

p_i > 0 makes zeros, p_i < 0 poles; all have negative real parts, whatever the parameters are. Eq. (2) of the paper is
the first-order factors (+1) and (-3). The level in dB is a sum over the factors with a short derivative, so the fit is
a least-squares problem in ln w and ln d, solved with scipy's bounded trust-region method.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..dsp import Analogue
from ..units import gain_from_db

Values = NDArray[np.float64]

_DB = 10.0 / math.log(10.0)
_DAMPING = {1: (0.05, 3.0), -1: (0.005, 3.0)}
"""Of zeros and of poles: a zero becomes a pole of the compensator, which shall not ring beyond a Q of 10."""
_EVALUATIONS = 100


@dataclass(frozen=True)
class Factor:
    """A factor of order 1 or 2, taken to a power: positive for zeros, negative for poles."""

    order: int
    power: int


Form = tuple[Factor, ...]

PAPER_FORM: Form = (Factor(1, 1), Factor(1, -3))
"""Eq. (2): k (s + w1) / (s + w2)^3."""


@dataclass(frozen=True, eq=False)
class Model:
    """A form with its parameters: the level at 0 Hz in dB, then ln w, and ln d for second order, of each factor."""

    form: Form
    parameters: Values

    @property
    def poles(self) -> int:
        """Return how many poles there are."""
        return -sum(factor.order * factor.power for factor in self.form if factor.power < 0)

    @property
    def zeros(self) -> int:
        """Return how many zeros there are."""
        return sum(factor.order * factor.power for factor in self.form if factor.power > 0)


def general_form(zeros: int, poles: int) -> Form:
    """Return factors of second order, and one of first where a number is odd."""
    numerator = (Factor(2, 1),) * (zeros // 2) + (Factor(1, 1),) * (zeros % 2)
    return numerator + (Factor(2, -1),) * (poles // 2) + (Factor(1, -1),) * (poles % 2)


def level_db(model: Model, frequencies_hz: Values) -> Values:
    """Return the model's level at the given frequencies."""
    return levels_and_derivatives(model.form, model.parameters, np.log(2.0 * math.pi * frequencies_hz))[0]


def analogue(model: Model) -> Analogue:
    """Return the model as zeros, poles and gain in rad/s."""
    zeros: list[complex] = []
    poles: list[complex] = []
    gain = gain_from_db(float(model.parameters[0]))
    for factor, corner, damping in _factors(model):
        roots = [complex(-corner)] if factor.order == 1 else _pair(corner, damping)
        (zeros if factor.power > 0 else poles).extend(roots * abs(factor.power))
        gain *= corner ** (-factor.order * factor.power)
    return Analogue(np.array(zeros, np.complex128), np.array(poles, np.complex128), gain)


def fit_form(
    form: Form,
    start: Values,
    frequencies_hz: Values,
    target_db: Values,
    *,
    weights: Values,
    band_rad_s: tuple[float, float],
) -> Model:
    """Return the model of a form that comes nearest to a level in weighted squared dB, sought from a start.

    Corners stay inside `band_rad_s`.
    """
    from scipy.optimize import least_squares

    log_w = np.log(2.0 * math.pi * frequencies_hz)
    scale = np.sqrt(weights)
    low, high = _bounds(form, band_rad_s)

    @lru_cache(maxsize=1)  # the solver asks for both at the same place, one after the other
    def evaluated(parameters: bytes) -> tuple[Values, Values]:
        return levels_and_derivatives(form, np.frombuffer(parameters), log_w)

    def residuals(parameters: Values) -> Values:
        return np.asarray(scale * (evaluated(parameters.tobytes())[0] - target_db))

    def jacobian(parameters: Values) -> Values:
        return np.asarray(scale[:, None] * evaluated(parameters.tobytes())[1])

    start = np.clip(start, low + 1e-6, high - 1e-6)
    start[0] += float(np.average(target_db - levels_and_derivatives(form, start, log_w)[0], weights=weights))
    solved = least_squares(
        residuals, start, jac=jacobian, bounds=(low, high), x_scale="jac", max_nfev=_EVALUATIONS, ftol=1e-7
    )
    return Model(form, np.asarray(solved.x, dtype=np.float64))


def start_from_roots(form: Form, zeros: Sequence[complex], poles: Sequence[complex]) -> Values:
    """Return parameters of a general form from its roots, wherever in the plane they lie: their magnitude and the
    angle to the real axis are kept, mirrored to the left half.
    """
    parameters = [0.0]
    for power, roots in ((1, zeros), (-1, poles)):
        complexes = sorted((abs(r), abs(r.real) / abs(r)) for r in roots if r.imag > 1e-9 * abs(r))
        reals = sorted(abs(r.real) for r in roots if abs(r.imag) <= 1e-9 * abs(r))
        pairs = [(corner, max(damping, _DAMPING[power][0])) for corner, damping in complexes]
        while len(reals) > 1:
            one, two = reals.pop(0), reals.pop(0)
            pairs.append((math.sqrt(one * two), (one + two) / (2.0 * math.sqrt(one * two))))
        for factor in (each for each in form if each.power == power):
            corner, damping = pairs.pop(0) if factor.order == 2 else (reals.pop(0), 1.0)
            parameters += [math.log(corner)] + ([math.log(damping)] if factor.order == 2 else [])
    return np.array(parameters)


def levels_and_derivatives(form: Form, parameters: Values, log_w: Values) -> tuple[Values, Values]:
    """Return the level in dB and its derivatives by the parameters, shape (frequencies, parameters)."""
    level = np.full_like(log_w, parameters[0])
    derivatives = [np.ones_like(log_w)]
    place = 1
    for factor in form:
        square = np.exp(2.0 * (log_w - parameters[place]))
        if factor.order == 1:
            power = 1.0 + square
            derivatives.append(-2.0 * factor.power * _DB * square / power)
        else:
            damped = 4.0 * square * math.exp(2.0 * parameters[place + 1])
            power = (1.0 - square) ** 2 + damped
            derivatives.append(-factor.power * _DB * (2.0 * damped - 4.0 * square * (1.0 - square)) / power)
            derivatives.append(2.0 * factor.power * _DB * damped / power)
        level = level + factor.power * _DB * np.log(power)
        place += factor.order
    return level, np.stack(derivatives, axis=1)


def _bounds(form: Form, band_rad_s: tuple[float, float]) -> tuple[Values, Values]:
    low, high = [-1000.0], [1000.0]
    for factor in form:
        low += [math.log(band_rad_s[0])] + ([math.log(_DAMPING[factor.power][0])] if factor.order == 2 else [])
        high += [math.log(band_rad_s[1])] + ([math.log(_DAMPING[factor.power][1])] if factor.order == 2 else [])
    return np.array(low), np.array(high)


def _factors(model: Model) -> list[tuple[Factor, float, float]]:
    found = []
    place = 1
    for factor in model.form:
        corner = math.exp(model.parameters[place])
        damping = math.exp(model.parameters[place + 1]) if factor.order == 2 else 1.0
        found.append((factor, corner, damping))
        place += factor.order
    return found


def _pair(corner: float, damping: float) -> list[complex]:
    """Return the roots of 1 + 2 d s/w + (s/w)^2: complex below a damping of 1, two real ones above."""
    if damping < 1.0:
        root = complex(-damping * corner, corner * math.sqrt(1.0 - damping**2))
        return [root, root.conjugate()]
    far = corner * (damping + math.sqrt(damping**2 - 1.0))
    return [complex(-far), complex(-(corner**2) / far)]

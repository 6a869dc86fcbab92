"""The rational model that comes nearest to what was measured, of as many poles and zeros as that is worth.

Models compete: eq. (2) of the paper, k (s + w1) / (s + w2)^3, and general ones of 1 to `most_poles` poles and one to
four fewer zeros. The one with the least Bayesian information criterion (BIC; Schwarz 1978) wins,

    n ln(1 + mean(e^2 / (e0^2 + m^2))) + p ln n

with n points, p free parameters, a model's error e in dB, the measurement's standard error m in dB, and
e0 = `negligible_db`, an error that cannot be felt: a parameter has to earn its place. The mean is over log frequency.

Levels alone are fitted: the phase of a stable model without zeros on the right follows from them, and a measured phase
beyond that, a delay or an all-pass, has no stable causal inverse.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import RuleError
from ..ruleset import SLOWEST_RAD_S, FitRules
from .inverse import inversion_db
from .rational import PAPER_FORM, Form, Model, analogue, fit_form, general_form, level_db, start_from_roots
from .target import FitTarget

Values = NDArray[np.float64]

_MOST_EXCESS = 4
"""A model has at most so many more poles than zeros."""

_POINTS_PER_PARAMETER = 2.0
"""A model with fewer measured points to a parameter follows their noise."""

_ROOM = (0.1, 2.0)
"""Corners lie from this share of the band's lowest frequency to so many times its highest."""

_SPARE_DB = 1.0
"""The response is raised to the inverse's bound wherever it is weaker, and a model of it errs to both sides."""

_PATIENCE = 2
"""So many poles more than the best model has are tried in vain before the search ends."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A model with its weighted rms error in dB and its Bayesian information criterion (less is better)."""

    model: Model
    error_db: float
    bic: float

    @property
    def is_papers(self) -> bool:
        """Return whether the model has the form of eq. (2)."""
        return self.model.form == PAPER_FORM


@dataclass(frozen=True, eq=False)
class FittedResponse:
    """The best model, the best of the paper's form for comparison (None where it is refused), and the target."""

    best: Fit
    papers: Fit | None
    target: FitTarget


@dataclass(frozen=True)
class BandError:
    """How far the model is off in an octave around `centre_hz`: mean, rms and worst error in dB."""

    centre_hz: float
    level_db: float
    mean_db: float
    rms_db: float
    worst_db: float


def fit(target: FitTarget, *, rules: FitRules, name: str) -> FittedResponse:
    """Return the best model of a felt response.

    Raises RuleError where no model keeps the bound of the inverse, give or take 1 dB, and decays in time.
    """
    inverse_variance = _inverse_variance(target, rules)
    papers = _judged(_fit_papers(target, inverse_variance), target, rules)
    fits = [papers] if papers else []
    best_of: dict[tuple[int, int], Model] = {}
    for zeros, poles in _orders(target, rules):
        if fits and poles > min(fits, key=_bic).model.poles + _PATIENCE:
            break
        form = general_form(zeros, poles)
        models = [
            fit_form(
                form,
                start,
                target.frequencies_hz,
                target.target_db,
                weights=target.weights * inverse_variance,
                band_rad_s=_room(target),
            )
            for start in _starts(form, zeros, poles, target, best_of)
        ]
        best_of[zeros, poles] = min(models, key=lambda model: _misfit(model, target, inverse_variance))
        judged = _judged(best_of[zeros, poles], target, rules)
        fits += [judged] if judged else []
    if not fits:
        raise RuleError(
            f"{name}: no stable model with an inverse of at most {rules.largest_gain_db + _SPARE_DB:g} dB was found, "
            f"{_SPARE_DB:g} dB over the bound of {rules.largest_gain_db:g} that the response was held to, "
            f"whose zeros and poles decay at {-SLOWEST_RAD_S:g} rad/s or faster; expected a smoother response"
        )
    return FittedResponse(min(fits, key=_bic), papers, target)


def octave_errors(fitted_response: FittedResponse) -> list[BandError]:
    """Return the errors of the best model octave by octave, around 31.5, 63, 125 Hz and so on."""
    target = fitted_response.target
    error = level_db(fitted_response.best.model, target.frequencies_hz) - target.target_db
    octave = np.round(np.log2(target.frequencies_hz / 1000.0)).astype(np.int64)
    rows = []
    for number in np.unique(octave):
        inside = octave == number
        weights = np.gradient(np.log(target.frequencies_hz))[inside]
        weights /= np.sum(weights)
        rows.append(
            BandError(
                1000.0 * 2.0**number,
                float(np.sum(weights * target.target_db[inside])),
                float(np.sum(weights * error[inside])),
                float(np.sqrt(np.sum(weights * error[inside] ** 2))),
                float(error[inside][np.argmax(np.abs(error[inside]))]),
            )
        )
    return rows


def _orders(target: FitTarget, rules: FitRules) -> Iterator[tuple[int, int]]:
    """Yield numbers of zeros and poles, smaller models first, that the points can tell apart."""
    most = len(target.frequencies_hz) / _POINTS_PER_PARAMETER - 1.0
    for poles in range(1, rules.most_poles + 1):
        for zeros in range(max(0, poles - _MOST_EXCESS), poles):
            if zeros + poles <= most:
                yield zeros, poles


def _fit_papers(target: FitTarget, inverse_variance: Values) -> Model:
    low, high = target.band_hz
    models = [
        fit_form(
            PAPER_FORM,
            np.array([0.0, math.log(2.0 * math.pi * zero_hz), math.log(2.0 * math.pi * pole_hz)]),
            target.frequencies_hz,
            target.target_db,
            weights=target.weights * inverse_variance,
            band_rad_s=_room(target),
        )
        for zero_hz, pole_hz in ((low, math.sqrt(low * high)), (math.sqrt(low * high), high), (high, low))
    ]
    return min(models, key=lambda model: _misfit(model, target, inverse_variance))


def _starts(
    form: Form, zeros: int, poles: int, target: FitTarget, best_of: dict[tuple[int, int], Model]
) -> Iterator[Values]:
    """Yield starts: roots spread over the band; those of a smaller model, and a pair that cancels where it is worst."""
    low, high = (2.0 * math.pi * edge for edge in target.band_hz)
    yield start_from_roots(form, _spread(zeros, low, high), _spread(poles, low, high))
    smaller = best_of.get((zeros - 2, poles - 2)) or best_of.get((zeros - 1, poles - 1))
    if smaller is not None:
        known = analogue(smaller)
        error = level_db(smaller, target.frequencies_hz) - target.target_db
        worst = 2.0 * math.pi * float(target.frequencies_hz[np.argmax(np.abs(error) * np.sqrt(target.weights))])
        pair = [complex(-0.3 * worst, 0.95 * worst), complex(-0.3 * worst, -0.95 * worst)]
        extra = [complex(-worst)] if poles - smaller.poles == 1 else pair
        yield start_from_roots(form, [*known.zeros.tolist(), *extra], [*known.poles.tolist(), *extra])


def _spread(count: int, low: float, high: float) -> list[complex]:
    """Return roots at even steps of log frequency: lightly damped pairs, and a real one where the count is odd."""
    corners = np.exp(np.linspace(math.log(low), math.log(high), count // 2 + 2)[1:-1])
    pairs = [complex(-0.5 * w, part * 0.87 * w) for w in corners for part in (1.0, -1.0)]
    return pairs + [complex(-math.sqrt(low * high))] * (count % 2)


def _bic(candidate: Fit) -> float:
    return candidate.bic


def _judged(model: Model, target: FitTarget, rules: FitRules) -> Fit | None:
    """Return a model with its criterion.

    None where its inverse exceeds the bound by more than a fit may be off, and where no profile may hold it, because a
    zero or pole rings on for too long: a slow pair costs little below what was measured, so a fit does choose one.
    """
    if _slowest_rad_s(model) > SLOWEST_RAD_S:
        return None
    if inversion_db(model, target, rules=rules) > rules.largest_gain_db + _SPARE_DB:
        return None
    points, free = len(target.frequencies_hz), len(model.parameters)
    bic = points * math.log1p(_misfit(model, target, _inverse_variance(target, rules))) + free * math.log(points)
    return Fit(model, math.sqrt(_misfit(model, target, np.ones(points))), bic)


def _slowest_rad_s(model: Model) -> float:
    """Return the real part of the zero or pole that decays most slowly."""
    felt = analogue(model)
    return float(np.max(np.concatenate([felt.zeros, felt.poles]).real))


def _misfit(model: Model, target: FitTarget, inverse_variance: Values) -> float:
    """Return the weighted mean of the squared errors."""
    error = level_db(model, target.frequencies_hz) - target.target_db
    return float(np.sum(target.weights * inverse_variance * error**2))


def _inverse_variance(target: FitTarget, rules: FitRules) -> Values:
    return 1.0 / (rules.negligible_db**2 + target.error_db**2)


def _room(target: FitTarget) -> tuple[float, float]:
    """Return where corners may lie: a corner far below or above the band could not be told from the data."""
    low, high = target.band_hz
    return 2.0 * math.pi * low * _ROOM[0], 2.0 * math.pi * high * _ROOM[1]

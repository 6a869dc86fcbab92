"""The solver: a primal-dual interior-point method whose every step costs a fixed amount of work per sample.

H is a recursive filter, B(z) / A(z), of a few coefficients. In the unknown v = u / A(z) instead of the drive u,

    minimise  1/2 |B v - t|^2   over  |A v| <= 1

and both matrices have only a few diagonals. So has the system that a Newton step solves, Q + A'DA with Q = B'B and D
diagonal: its Cholesky factor costs as much as running a few filters. Mehrotra's predictor-corrector method (SIAM J.
Optim. 2, 1992; for quadratic programs Nocedal and Wright, Numerical Optimization, 2nd edition, algorithm 16.4) takes
some ten steps, whatever H is, and knows at each how far from the best drive it can be at most.

Drives may run in straight lines between corners `stride` samples apart; v then has an entry for each corner, and Q
sums over all samples between. What is felt after the last corner counts as well.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .banded import (
    BandedHessian,
    Recursion,
    apply_a,
    apply_a_transposed,
    apply_q,
    banded_hessian,
    newton_diagonals,
    q_diagonals,
)

Samples = NDArray[np.float64]

SHORTEST = 64
"""From so many unknowns on the solver pays."""

_ROUNDING = 1e-9  # of max |H|^2, added to the curvature, so that rounding cannot make it negative
_STEP_TO_BOUNDARY = 0.995  # of the way to the first slack or multiplier that would be 0: the next must be inside too
_START_INSIDE = 0.95  # of the limit: at the limit itself a slack would be 0
_LEAST_PRODUCT = 0.15  # of the mean |gradient|, for each slack times its multiplier: close to 0, first steps are short


@dataclass(frozen=True, eq=False)
class BoxQpSolution:
    """What the solver found: `drive`, shape (corners,), within the limit, its steps, whether rounding let it finish."""

    drive: Samples
    steps: int
    finished: bool = True


def fewest_unknowns(recursion: Recursion, stride: int) -> int:
    """Return from how many corners on the solver pays and every diagonal is there: many poles make many diagonals."""
    return max(SHORTEST, len(banded_hessian(recursion, stride).lags))


def solve_box_qp(
    recursion: Recursion, rhs: Samples, start: Samples, *, stride: int, iterations: int, tolerance: float
) -> BoxQpSolution:
    """Return the corners u of the drive that minimise 1/2 |H u|^2 - rhs'u over |u| <= 1; `fewest_unknowns` or more.

    It stops where what can still be gained is less than `tolerance` of what the drive explains, after `iterations`
    steps, or where rounding ends it.
    """
    from scipy.linalg import LinAlgError

    q = banded_hessian(recursion, stride)
    state, of_q = _State.first(q, rhs, start), q_diagonals(q, len(rhs))
    for step in range(iterations):
        gap = state.gap
        if not gap > tolerance * abs(state.objective):
            return BoxQpSolution(state.drive, step)
        try:
            newton = _Newton.of(q, of_q, state)
        except LinAlgError:
            return BoxQpSolution(state.drive, step, finished=False)
        predictor = newton.predictor()
        reached = state.gap_after(predictor, state.max_step(predictor))
        mu = gap / (2 * len(rhs)) * (reached / gap) ** 3
        direction = newton.corrector(mu, predictor)
        state = state.moved(q, direction, _STEP_TO_BOUNDARY * state.max_step(direction))
    return BoxQpSolution(state.drive, iterations)


@dataclass(frozen=True, eq=False)
class _Direction:
    """A change of v, of the drive, and of both multipliers."""

    v: Samples
    drive: Samples
    upper: Samples
    lower: Samples


@dataclass(frozen=True, eq=False)
class _State:
    """A drive strictly within the limit, and the positive multipliers of its upper and its lower bound.

    `gradient` is that of the objective by v, Qv - r, of which `linear` is r.
    """

    v: Samples
    drive: Samples
    upper: Samples
    lower: Samples
    gradient: Samples
    linear: Samples

    @classmethod
    def first(cls, q: BandedHessian, rhs: Samples, start: Samples) -> "_State":
        """Return the start, drawn inside; multipliers balance its gradient where their signs allow it."""
        from scipy.signal import lfilter

        drive = _START_INSIDE * np.clip(start, -1.0, 1.0)
        v = lfilter([1.0], q.feedback, drive)
        linear = apply_a_transposed(q, rhs)
        gradient = apply_q(q, v) - linear
        by_drive = lfilter([1.0], q.feedback, gradient[::-1])[::-1]
        least = _LEAST_PRODUCT * float(np.mean(np.abs(by_drive))) + 1e-12 * float(np.max(np.abs(rhs)))
        upper = np.maximum(-by_drive, 0.0) + least / (1.0 - drive)
        lower = np.maximum(by_drive, 0.0) + least / (1.0 + drive)
        return cls(v, drive, upper, lower, gradient, linear)

    @cached_property
    def slack_upper(self) -> Samples:
        """Return the slack of the upper bound."""
        return 1.0 - self.drive

    @cached_property
    def slack_lower(self) -> Samples:
        """Return the slack of the lower bound."""
        return 1.0 + self.drive

    @cached_property
    def curvature_upper(self) -> Samples:
        """Return how much more the upper bound's multiplier pushes back for each step of the drive towards it."""
        return self.upper / self.slack_upper

    @cached_property
    def curvature_lower(self) -> Samples:
        """Return the same of the lower bound."""
        return self.lower / self.slack_lower

    @cached_property
    def gap(self) -> float:
        """Return the duality gap (complementarity): the objective may be so far off its minimum, once dual feasible."""
        return float((self.upper * self.slack_upper + self.lower * self.slack_lower).sum())

    @property
    def objective(self) -> float:
        """Return 1/2 v'Qv - r'v, from the gradient Qv - r."""
        return 0.5 * float((self.v * (self.gradient - self.linear)).sum())

    def max_step(self, direction: _Direction) -> float:
        """Return how far, up to 1, one may go until a slack or a multiplier is used up."""
        used = max(
            float((direction.drive / self.slack_upper).max()),
            -float((direction.drive / self.slack_lower).min()),
            -float((direction.upper / self.upper).min()),
            -float((direction.lower / self.lower).min()),
        )
        return 1.0 if used <= 1.0 else 1.0 / used

    def gap_after(self, predictor: _Direction, length: float) -> float:
        """Return the duality gap that such a part of the predictor's step leaves.

        To first order that takes every product of a slack and its multiplier to 0: what is left is the second order.
        """
        missed = float((predictor.drive * (predictor.upper - predictor.lower)).sum())
        return (1.0 - length) * self.gap - length * length * missed

    def moved(self, q: BandedHessian, direction: _Direction, length: float) -> "_State":
        """Return the state after a step."""
        return _State(
            self.v + length * direction.v,
            self.drive + length * direction.drive,
            self.upper + length * direction.upper,
            self.lower + length * direction.lower,
            self.gradient + length * apply_q(q, direction.v),
            self.linear,
        )


@dataclass(frozen=True, eq=False)
class _Newton:
    """The linear system of a state, factored: two directions are solved from it."""

    q: BandedHessian
    state: _State
    factor: Samples

    @classmethod
    def of(cls, q: BandedHessian, of_q: Samples, state: _State) -> "_Newton":
        """Return the system of a state, given Q's diagonals; LinAlgError where rounding has spoilt it."""
        from scipy.linalg import cholesky_banded

        curvature = state.curvature_upper + state.curvature_lower + _ROUNDING * q.max_power_gain
        factor = cholesky_banded(
            newton_diagonals(q, of_q, curvature), lower=True, overwrite_ab=True, check_finite=False
        )
        return cls(q, state, factor)

    def predictor(self) -> _Direction:
        """Return the direction to where each slack times its multiplier is 0, as far as their slopes tell."""
        return self._direction(-self.state.gradient, 0.0, 0.0)

    def corrector(self, mu: float, predictor: _Direction) -> _Direction:
        """Return the direction to where each slack times its multiplier is `mu`, knowing what the predictor missed."""
        upper = (mu + predictor.drive * predictor.upper) / self.state.slack_upper
        lower = (mu - predictor.drive * predictor.lower) / self.state.slack_lower
        return self._direction(-self.state.gradient - apply_a_transposed(self.q, upper - lower), upper, lower)

    def _direction(self, right: Samples, upper: Samples | float, lower: Samples | float) -> _Direction:
        """Return the direction whose multipliers were `upper` and `lower` if the drive stayed, `right` being -Qv + r
        less their push.
        """
        from scipy.linalg.lapack import dpbtrs  # cho_solve_banded takes as long around it as it does

        now = self.state
        v, _ = dpbtrs(self.factor, right, lower=True)
        u = apply_a(self.q, v)
        return _Direction(
            v, u, upper - now.upper + now.curvature_upper * u, lower - now.lower - now.curvature_lower * u
        )

"""The solver: an interior-point method whose every step costs a fixed amount of work per sample.

H is a recursive filter, B(z) / A(z), of a few coefficients. In the unknown v = u / A(z) instead of the drive u,

    minimise  1/2 |B v - t|^2   over  |A v| <= 1

and both matrices have only a few diagonals. So has the system that a Newton step solves, Q + A'DA with Q = B'B and D
diagonal: its Cholesky factor costs as much as running a few filters. Mehrotra's predictor and corrector (1992) take
some ten steps, whatever H is, and know at each how far from the best drive they can be at most.

Drives may run in straight lines between corners `stride` samples apart; v then has an entry for each corner, and Q
sums over all samples between. What is felt after the last corner counts as well.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .banded import Pattern, Recursion, applied, diagonals, pattern, quadratic, transposed

Samples = NDArray[np.float64]

SHORTEST = 64
"""From so many unknowns on, every diagonal has its full length and the solver pays."""

_ROUNDING = 1e-9  # of max |H|^2, added to the curvature, so that rounding cannot make it negative
_SHORT_OF_LIMIT = 0.995  # a step goes so far towards the first limit it meets
_START = 0.95


@dataclass(frozen=True, eq=False)
class Interior:
    """What the solver found: the unknowns within the limit, the steps it took, whether rounding let it finish."""

    drive: Samples
    steps: int
    finished: bool = True


def solve_inside(
    recursion: Recursion, rhs: Samples, start: Samples, *, stride: int, iterations: int, tolerance: float
) -> Interior:
    """Return the corners u of the drive that minimise 1/2 |H u|^2 - rhs'u over |u| <= 1; at least `SHORTEST` of them.

    It stops where what can still be gained is less than `tolerance` of what the drive explains, after `iterations`
    steps, or where rounding ends it.
    """
    from scipy.linalg import LinAlgError

    q = pattern(recursion, stride)
    state = _State.first(q, rhs, start)
    for step in range(iterations):
        gap = state.gap
        if not gap > tolerance * abs(state.objective):
            return Interior(state.drive, step)
        try:
            newton = _Newton.of(q, state)
        except LinAlgError:
            return Interior(state.drive, step, finished=False)
        guess = newton.towards(0.0)
        reached = state.gap_after(guess, state.longest(guess))
        centre = gap / (2 * len(rhs)) * (reached / gap) ** 3
        way = newton.towards(centre, above=-guess.drive * guess.upper, below=guess.drive * guess.lower)
        state = state.moved(q, way, _SHORT_OF_LIMIT * state.longest(way))
    return Interior(state.drive, iterations)


@dataclass(frozen=True, eq=False)
class _Direction:
    """A change of v, of the drive, and of both multipliers."""

    v: Samples
    drive: Samples
    upper: Samples
    lower: Samples


@dataclass(frozen=True, eq=False)
class _State:
    """A drive strictly within the limit, with its room `above` and `below`, and positive multipliers of either side."""

    v: Samples
    drive: Samples
    upper: Samples
    lower: Samples
    slope: Samples
    pull: Samples

    @classmethod
    def first(cls, q: Pattern, rhs: Samples, start: Samples) -> "_State":
        """Return the start, drawn inside; multipliers push where its slope does."""
        from scipy.signal import lfilter

        drive = _START * np.clip(start, -1.0, 1.0)
        v = lfilter([1.0], q.feedback, drive)
        pull = transposed(q, rhs)
        slope = quadratic(q, v) - pull
        push = lfilter([1.0], q.feedback, slope[::-1])[::-1]
        least = 0.15 * float(np.mean(np.abs(push))) + 1e-12 * float(np.max(np.abs(rhs)))
        upper = np.maximum(-push, 0.0) + least / (1.0 - drive)
        lower = np.maximum(push, 0.0) + least / (1.0 + drive)
        return cls(v, drive, upper, lower, slope, pull)

    @property
    def above(self) -> Samples:
        """Return the room up to the limit."""
        return 1.0 - self.drive

    @property
    def below(self) -> Samples:
        """Return the room down to the limit."""
        return 1.0 + self.drive

    @property
    def gap(self) -> float:
        """Return how far the objective can be from its minimum, once the slope is balanced."""
        return float(np.sum(self.upper * self.above) + np.sum(self.lower * self.below))

    @property
    def objective(self) -> float:
        """Return 1/2 v'Qv - r'v, from the slope Qv - r."""
        return float(0.5 * np.sum(self.v * (self.slope - self.pull)))

    def longest(self, way: _Direction) -> float:
        """Return how far, up to 1, one may go until a room or a multiplier is used up."""
        used = max(
            float(np.max(way.drive / self.above)),
            float(np.max(-way.drive / self.below)),
            float(np.max(-way.upper / self.upper)),
            float(np.max(-way.lower / self.lower)),
        )
        return 1.0 if used <= 1.0 else 1.0 / used

    def gap_after(self, way: _Direction, length: float) -> float:
        """Return the sum of the products of room and multiplier that such a step leaves."""
        change = length * way.drive
        above = np.sum((self.above - change) * (self.upper + length * way.upper))
        return float(above + np.sum((self.below + change) * (self.lower + length * way.lower)))

    def moved(self, q: Pattern, way: _Direction, length: float) -> "_State":
        """Return the state after a step."""
        return _State(
            self.v + length * way.v,
            self.drive + length * way.drive,
            self.upper + length * way.upper,
            self.lower + length * way.lower,
            self.slope + length * quadratic(q, way.v),
            self.pull,
        )


@dataclass(frozen=True, eq=False)
class _Newton:
    """The linear system of a state, factored: two directions are solved from it."""

    q: Pattern
    state: _State
    residual: Samples
    factor: Samples

    @classmethod
    def of(cls, q: Pattern, state: _State) -> "_Newton":
        """Return the system of a state; LinAlgError where rounding has spoilt it."""
        from scipy.linalg import cholesky_banded

        curvature = state.upper / state.above + state.lower / state.below + _ROUNDING * q.greatest
        factor = cholesky_banded(diagonals(q, curvature), lower=True, overwrite_ab=True, check_finite=False)
        return cls(q, state, state.slope + transposed(q, state.upper - state.lower), factor)

    def towards(self, product: float, *, above: Samples | float = 0.0, below: Samples | float = 0.0) -> _Direction:
        """Return the way to where each product of room and multiplier is `product`, less what is known to be missed."""
        from scipy.linalg import cho_solve_banded

        now = self.state
        upper = (product - above) / now.above - now.upper
        lower = (product - below) / now.below - now.lower
        right = -self.residual - transposed(self.q, upper - lower)
        v = cho_solve_banded((self.factor, True), right, check_finite=False)
        u = applied(self.q, v)
        return _Direction(v, u, upper + now.upper * u / now.above, lower - now.lower * u / now.below)

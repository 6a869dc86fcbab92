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
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.float64]

SHORTEST = 64
"""From so many unknowns on, every diagonal has its full length and the solver pays."""

_KEPT = 1e-9  # of a response's largest coefficient: below is rounding
_ROUNDING = 1e-9  # of max |H|^2, added to the curvature, so that rounding cannot make it negative
_LEAST_FEEDBACK = 5e-7  # of |A| at any frequency: its square, against 1, is still above rounding
_SHORT_OF_LIMIT = 0.995  # a step goes so far towards the first limit it meets
_START = 0.95
_LONGEST_STRIDE = 64


@dataclass(frozen=True, eq=False)
class Recursion:
    """H as a recursive filter: `forward` is B, `feedback` is A with A(0) = 1; `impulse` its response until faded."""

    forward: Samples
    feedback: Samples
    impulse: Samples


@dataclass(frozen=True, eq=False)
class _Pattern:
    """Q: the same diagonals in every row, `lags` from the main one on, and what differs in its last rows.

    `greatest` is the greatest of |H|^2.
    """

    feedback: Samples
    lags: Samples
    ending: Samples
    greatest: float


@dataclass(frozen=True, eq=False)
class Interior:
    """What the solver found: the unknowns within the limit, the steps it took, whether rounding let it finish."""

    drive: Samples
    steps: int
    finished: bool = True


@lru_cache(maxsize=8)
def sound_stride(recursion: Recursion, stride: int) -> int:
    """Return the stride, or the next above it at which H does not remember for too many corners.

    Poles much slower than the corners make |A| so small that Q + A'DA is lost in rounding.
    """
    poles = np.roots(recursion.feedback)
    turns = np.concatenate([np.linspace(0.0, np.pi, 512), np.abs(np.angle(poles))])
    while stride < _LONGEST_STRIDE:
        around = np.exp(1j * stride * turns)
        if np.min(np.prod(np.abs(around[:, None] - poles**stride), axis=1)) >= _LEAST_FEEDBACK:
            break
        stride += 1
    return stride


def solve_inside(
    recursion: Recursion, rhs: Samples, start: Samples, *, stride: int, iterations: int, tolerance: float
) -> Interior:
    """Return the corners u of the drive that minimise 1/2 |H u|^2 - rhs'u over |u| <= 1; at least `SHORTEST` of them.

    It stops where what can still be gained is less than `tolerance` of what the drive explains, after `iterations`
    steps, or where rounding ends it.
    """
    from scipy.linalg import LinAlgError

    q = _pattern(recursion, stride)
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
    def first(cls, q: _Pattern, rhs: Samples, start: Samples) -> "_State":
        """Return the start, drawn inside; multipliers push where its slope does."""
        from scipy.signal import lfilter

        drive = _START * np.clip(start, -1.0, 1.0)
        v = lfilter([1.0], q.feedback, drive)
        pull = _transposed(q, rhs)
        slope = _quadratic(q, v) - pull
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

    def moved(self, q: _Pattern, way: _Direction, length: float) -> "_State":
        """Return the state after a step."""
        return _State(
            self.v + length * way.v,
            self.drive + length * way.drive,
            self.upper + length * way.upper,
            self.lower + length * way.lower,
            self.slope + length * _quadratic(q, way.v),
            self.pull,
        )


@dataclass(frozen=True, eq=False)
class _Newton:
    """The linear system of a state, factored: two directions are solved from it."""

    q: _Pattern
    state: _State
    residual: Samples
    factor: Samples

    @classmethod
    def of(cls, q: _Pattern, state: _State) -> "_Newton":
        """Return the system of a state; LinAlgError where rounding has spoilt it."""
        from scipy.linalg import cholesky_banded

        curvature = state.upper / state.above + state.lower / state.below + _ROUNDING * q.greatest
        factor = cholesky_banded(_diagonals(q, curvature), lower=True, overwrite_ab=True, check_finite=False)
        return cls(q, state, state.slope + _transposed(q, state.upper - state.lower), factor)

    def towards(self, product: float, *, above: Samples | float = 0.0, below: Samples | float = 0.0) -> _Direction:
        """Return the way to where each product of room and multiplier is `product`, less what is known to be missed."""
        from scipy.linalg import cho_solve_banded

        now = self.state
        upper = (product - above) / now.above - now.upper
        lower = (product - below) / now.below - now.lower
        right = -self.residual - _transposed(self.q, upper - lower)
        v = cho_solve_banded((self.factor, True), right, check_finite=False)
        u = _applied(self.q, v)
        return _Direction(v, u, upper + now.upper * u / now.above, lower - now.lower * u / now.below)


@lru_cache(maxsize=8)
def _pattern(recursion: Recursion, stride: int) -> _Pattern:
    """Return Q for drives with corners so many samples apart, and A for the poles to that power."""
    poles = np.roots(recursion.feedback) ** stride
    feedback = np.atleast_1d(np.poly(poles)).real
    bent = np.convolve(recursion.impulse, hat(stride))
    bent = np.pad(bent, (0, -len(bent) % stride))
    reach = min(len(bent) // stride, 4 * len(feedback) + len(recursion.forward) + 8)
    # column f holds what is felt f samples after each corner
    forward = np.stack([np.convolve(feedback, phase[:reach])[:reach] for phase in bent.reshape(-1, stride).T], axis=1)
    largest = np.max(np.abs(forward), axis=1)
    forward = forward[: int(np.flatnonzero(largest > _KEPT * np.max(largest))[-1]) + 1]
    width = max(len(forward), len(feedback))
    forward = np.pad(forward, ((0, width - len(forward)), (0, 0)))
    lags = np.array([np.sum(forward[lag:] * forward[: width - lag]) for lag in range(width)])
    greatest = float(np.max(np.abs(np.fft.rfft(bent)) ** 2)) / stride
    return _Pattern(feedback, lags, _ending(feedback, forward, tail=len(bent) // stride + width), greatest)


def _ending(feedback: Samples, forward: Samples, *, tail: int) -> Samples:
    """Return what Q's last rows have besides its lags: after the last corner u is 0, and v rings on."""
    from scipy.signal import fftconvolve, lfilter

    size = len(forward) - 1
    stopped = np.zeros((size + tail, size))
    stopped[:size] = np.eye(size)
    rings_on = lfilter(
        [1.0], feedback, np.concatenate([_banded_columns(feedback, size), np.zeros((tail, size))]), axis=0
    )
    felt = [
        np.concatenate([fftconvolve(v, phase[:, None], axes=0)[size : size + tail] for phase in forward.T])
        for v in (rings_on[: size + tail], stopped)
    ]
    return np.asarray(felt[0].T @ felt[0] - felt[1].T @ felt[1], dtype=np.float64)


def _banded_columns(feedback: Samples, size: int) -> Samples:
    """Return the input to 1 / A that makes each unit vector of the last v, and rings on freely after them."""
    columns = np.zeros((size, size))
    for index in range(size):
        part = feedback[: size - index]
        columns[index : index + len(part), index] = part
    return columns


def _applied(q: _Pattern, v: Samples) -> Samples:
    return np.convolve(v, q.feedback)[: len(v)]


def _transposed(q: _Pattern, u: Samples) -> Samples:
    return np.convolve(u[::-1], q.feedback)[: len(u)][::-1]


def _quadratic(q: _Pattern, v: Samples) -> Samples:
    """Return Q v."""
    size = len(q.lags) - 1
    product = np.convolve(v, np.concatenate([q.lags[:0:-1], q.lags]))[size : size + len(v)]
    product[-size:] += np.sum(q.ending * v[-size:], axis=1)
    return product


def _diagonals(q: _Pattern, curvature: Samples) -> Samples:
    """Return the lower diagonals of Q + A'DA, shape (width, unknowns)."""
    size, order, unknowns = len(q.lags) - 1, len(q.feedback) - 1, len(curvature)
    diagonals = np.repeat(q.lags[:, None], unknowns, axis=1)
    for lag in range(size):
        diagonals[lag, unknowns - size : unknowns - lag] += np.diagonal(q.ending, -lag)
    padded = np.concatenate([curvature, np.zeros(order)])
    for lag in range(order + 1):
        products = q.feedback[lag:] * q.feedback[: order + 1 - lag]
        diagonals[lag, : unknowns - lag] += np.correlate(padded, products, "valid")[lag:unknowns]
    return diagonals


def hat(stride: int) -> Samples:
    """Return the straight rise to 1 and fall from it over `stride` samples each."""
    rise = np.arange(1.0, stride + 1.0) / stride
    return np.concatenate([rise, rise[-2::-1]])

"""The banded systems of the interior-point method: Q and A for a recursive filter, and the drives between corners.

In v = u / A(z) what is felt of a drive is B v: Q = B'B has the same few diagonals in every row but its last ones,
because what is felt after the last corner counts as well.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.float64]

_KEPT = 1e-9  # of a response's largest coefficient: below is rounding
_LEAST_FEEDBACK = 5e-7  # of |A| at any frequency: its square, against 1, is still above rounding
_LEAST_OF_LARGEST = 2e-8  # and against the largest |A|, which grows with the number of poles
_LONGEST_STRIDE, _LONGEST_S = 64, 1.0 / 750.0
"""Samples, but at high rates as long as they are at 48 kHz: poles are as slow there."""


@dataclass(frozen=True, eq=False)
class Recursion:
    """H as a recursive filter, by its poles: A's coefficients at a film's rate would lose slow poles in rounding.

    `poles`, shape (order,), are in z, inside the unit circle. `impulse`, shape (frames,), is its response until it has
    faded, of which all but the first `free` samples are made of these poles.
    A drive of straight lines steers it with corners at most `longest_stride` samples apart.
    """

    poles: NDArray[np.complex128]
    impulse: Samples
    free: int
    longest_stride: int = _LONGEST_STRIDE


@dataclass(frozen=True, eq=False)
class BandedHessian:
    """Q: the same diagonals in every row, `lags` from the main one on, and what differs in its last rows.

    `feedback`, shape (order + 1,), are A's coefficients, 1 first; `lags` has shape (width,), `ending` is square, of
    width - 1 rows. `max_power_gain` is the greatest of |H|^2.
    """

    feedback: Samples
    lags: Samples
    ending: Samples
    max_power_gain: float


@lru_cache(maxsize=8)
def well_conditioned_stride(recursion: Recursion, stride: int, rate_hz: int) -> int:
    """Return the stride, or the next above it at which H does not remember for too many corners.

    Poles much slower than the corners make |A| so small that Q + A'DA is lost in rounding.
    """
    poles = recursion.poles
    angles = np.concatenate([np.linspace(0.0, np.pi, 512), np.abs(np.angle(poles))])
    while stride < max(_LONGEST_STRIDE, _LONGEST_S * rate_hz):
        unit_circle = np.exp(1j * stride * angles)
        feedbacks = np.prod(np.abs(unit_circle[:, None] - poles**stride), axis=1)
        if np.min(feedbacks) >= max(_LEAST_FEEDBACK, _LEAST_OF_LARGEST * np.max(feedbacks)):
            break
        stride += 1
    return stride


@lru_cache(maxsize=8)
def banded_hessian(recursion: Recursion, stride: int) -> BandedHessian:
    """Return Q for drives with corners so many samples apart, and A for the poles to that power."""
    feedback = np.atleast_1d(np.poly(recursion.poles**stride)).real
    bent = np.convolve(recursion.impulse, hat(stride))
    bent = np.pad(bent, (0, -len(bent) % stride))
    reach = min(len(bent) // stride, 5 * len(feedback) + recursion.free + 8)
    # column f holds what is felt f samples after each corner
    forward = np.stack([np.convolve(feedback, phase[:reach])[:reach] for phase in bent.reshape(-1, stride).T], axis=1)
    largest = np.max(np.abs(forward), axis=1)
    forward = forward[: int(np.flatnonzero(largest > _KEPT * np.max(largest))[-1]) + 1]
    width = max(len(forward), len(feedback))
    forward = np.pad(forward, ((0, width - len(forward)), (0, 0)))
    lags = np.array([np.sum(forward[lag:] * forward[: width - lag]) for lag in range(width)])
    max_power_gain = float(np.max(np.abs(np.fft.rfft(bent)) ** 2)) / stride
    ending = _ending(feedback, forward, tail=len(bent) // stride + width)
    return BandedHessian(feedback, lags, ending, max_power_gain)


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


def apply_a(q: BandedHessian, v: Samples) -> Samples:
    """Return A v, shape (unknowns,)."""
    return np.convolve(v, q.feedback)[: len(v)]


def apply_a_transposed(q: BandedHessian, u: Samples) -> Samples:
    """Return A'u, shape (unknowns,)."""
    return np.convolve(u[::-1], q.feedback)[: len(u)][::-1]


def apply_q(q: BandedHessian, v: Samples) -> Samples:
    """Return Q v, shape (unknowns,), which are no fewer than the rows of `ending`."""
    size = len(q.lags) - 1
    product = np.convolve(v, np.concatenate([q.lags[:0:-1], q.lags]))[size : size + len(v)]
    product[-size:] += np.sum(q.ending * v[-size:], axis=1)
    return product


def q_diagonals(q: BandedHessian, unknowns: int) -> Samples:
    """Return the lower diagonals of Q, shape (width, unknowns)."""
    size = len(q.lags) - 1
    diagonals = np.repeat(q.lags[:, None], unknowns, axis=1)
    for lag in range(size):
        diagonals[lag, unknowns - size : unknowns - lag] += np.diagonal(q.ending, -lag)
    return diagonals


def newton_diagonals(q: BandedHessian, of_q: Samples, curvature: Samples) -> Samples:
    """Return the lower diagonals of Q + A'DA, shape (width, unknowns), from those of Q."""
    order, unknowns = len(q.feedback) - 1, len(curvature)
    diagonals = of_q.copy()
    padded = np.concatenate([curvature, np.zeros(order)])
    for lag in range(order + 1):
        products = q.feedback[lag:] * q.feedback[: order + 1 - lag]
        diagonals[lag, : unknowns - lag] += np.correlate(padded, products, "valid")[lag:unknowns]
    return diagonals


def hat(stride: int) -> Samples:
    """Return the straight rise to 1 and fall from it over `stride` samples each, shape (2 stride - 1,)."""
    rise = np.arange(1.0, stride + 1.0) / stride
    return np.concatenate([rise, rise[-2::-1]])

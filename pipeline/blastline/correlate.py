"""Where one signal lies in another, by normalised cross-correlation over the samples that count."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Match:
    """The best place of a pattern: how many samples late it lies, and its correlation there (negative: inverted)."""

    lag: float
    correlation: float


NO_MATCH = Match(math.nan, 0.0)
"""The match of a pattern with nothing to compare."""

_LEAST_SHARE = 0.05
"""A match that is believed for its correlation needs this share of the pattern's energy: less is alike by chance."""


def match_template(
    pattern: NDArray[np.float64],
    moving: NDArray[np.float64],
    mask: NDArray[np.bool_] | None = None,
    *,
    least_share: float = _LEAST_SHARE,
) -> Match:
    """Return where `pattern` lies in `moving`, over the samples of `moving` in the mask; None takes them all.

    A lag at which less than `least_share` of the pattern's energy is in the mask is no match.

    Masked normalised cross-correlation with parabolic interpolation. `moving` is longer than the pattern by the same
    number of samples, the search range, at either end. For each lag, where w is 1 in the mask and 0 elsewhere,

        c(lag) = sum w(k + lag) p(k) m(k + lag) / sqrt( sum w(k + lag) p(k)^2 * sum w(k + lag) m(k + lag)^2 )

    and a parabola through the largest |c| and its neighbours gives the fraction of a sample. The interpolated lag of a
    band-limited signal is good to some hundredths of a sample.
    """
    search = (len(moving) - len(pattern)) // 2
    if not pattern.any() or not moving.any():
        return NO_MATCH
    squares = pattern**2
    pattern_energy = float(squares.sum())  # a dot product would wake every core for so little
    weighted = moving if mask is None else np.where(mask, moving, 0.0)
    masked_energy = pattern_energy if mask is None else _slide(squares, mask.astype(np.float64))
    energy_before = np.cumsum(np.concatenate([[0.0], weighted**2]))
    moving_energy = energy_before[len(pattern) :] - energy_before[: len(energy_before) - len(pattern)]
    product = _slide(pattern, weighted)
    enough = (np.asarray(masked_energy) >= least_share * pattern_energy) & (moving_energy > 1e-9 * energy_before[-1])
    scale = np.sqrt(np.where(enough, masked_energy * moving_energy, 1.0))
    correlation = np.where(enough, product / scale, 0.0)
    best = int(np.argmax(np.abs(correlation)))
    if correlation[best] == 0.0 or not enough[max(0, best - 1) : best + 2].all():
        return NO_MATCH  # beside a lag at which too little counts, the largest need not be the peak
    beside = float(parabolic_offsets(np.abs(correlation), np.array([best]))[0])
    return Match(best - search + beside, float(np.clip(correlation[best], -1.0, 1.0)))


def normalised_product(samples: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    """Return the normalised product of two signals where they lie; 1 where both are silent, 0 where one is."""
    level, against = (float(np.sqrt(np.sum(each * each))) for each in (samples, reference))
    if level == 0.0 or against == 0.0:
        return float(level == against)
    return float(np.clip(np.sum((samples / level) * (reference / against)), -1.0, 1.0))


def lag_uncertainty(
    pattern: NDArray[np.float64], match: Match, moving: int, mask: NDArray[np.bool_] | None = None
) -> float:
    """Return by how many samples at most what is unlike the pattern can have moved the lag of a match.

    `moving` is the number of samples that the pattern was sought in, `mask` as in `match_template`. What is unlike
    the pattern p there is e, |e|^2 = 2 (1 - c) |p|^2. A normalised pattern cannot tell a lag from a gain, so what tells
    the lag is the part s of its slope that is not like itself. The best match makes up for <e, s>: it lies
    <e, s> / |s|^2 aside, and so, after Cauchy and Schwarz, |e| / |s| at most. Slow sounds tell a lag badly, and less
    than half a period tells none: infinite.
    """
    start = (moving - len(pattern)) // 2 + round(match.lag)
    counts = np.ones(len(pattern), dtype=np.bool_) if mask is None else mask[start : start + len(pattern)]
    own, slope = pattern[counts], np.gradient(pattern)[counts]
    energy = float(np.sum(own**2))
    steep = float(np.sum(slope**2)) - (float(np.sum(own * slope)) ** 2 / energy if energy > 0.0 else 0.0)
    if steep <= 0.0 or len(own) ** 2 * steep < math.pi**2 * energy:
        return math.inf
    between = 0.5 * steep / energy * (match.lag - round(match.lag)) ** 2  # the peak lies higher than its nearest sample
    return math.sqrt(2.0 * max(0.0, 1.0 - match.correlation - between) * energy / steep)


def lag_of_product(pattern: NDArray[np.float64], moving: NDArray[np.float64]) -> float:
    """Return by how many samples `pattern` lies late in `moving` where their product is greatest; 0 where it never is.

    As in `match_template`, but nothing is made of where `moving` is loud: it holds the pattern, changed, and no more.
    """
    product = _slide(pattern, moving)
    best = int(np.argmax(product))
    if product[best] <= 0.0:
        return 0.0
    return best - (len(moving) - len(pattern)) // 2 + float(parabolic_offsets(product, np.array([best]))[0])


def _slide(pattern: NDArray[np.float64], moving: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return sum over k of pattern(k) moving(k + j) for every j at which the pattern lies inside."""
    from scipy import fft

    size = fft.next_fast_len(len(moving), real=True)
    spectrum = fft.rfft(moving, size) * np.conj(fft.rfft(pattern, size))
    return np.asarray(fft.irfft(spectrum, size)[: len(moving) - len(pattern) + 1], dtype=np.float64)


def parabolic_offsets(values: NDArray[np.float64], peaks: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return how far beside each of n peaks, shape (n,), the parabola through it and its neighbours has its vertex.

    In samples, half of one at most; 0 where there is no neighbour on one side, or the parabola does not bend down.
    """
    before, at, after = _neighbours(values, peaks)
    bend = before - 2.0 * at + after
    away = np.divide(0.5 * (before - after), bend, out=np.zeros_like(at), where=bend < 0.0)
    return np.clip(away, -0.5, 0.5)


def parabolic_peaks(
    values: NDArray[np.float64], peaks: NDArray[np.intp], beside: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the value of each of n parabolas at its vertex, `beside` its peak as `parabolic_offsets` says."""
    before, at, after = _neighbours(values, peaks)
    return np.asarray(at + 0.25 * (after - before) * beside, np.float64)


def _neighbours(values: NDArray[np.float64], peaks: NDArray[np.intp]) -> Iterator[NDArray[np.float64]]:
    """Yield the values before, at and after some peaks; thrice that at a peak which has no neighbour on one side."""
    inside = (peaks > 0) & (peaks < values.shape[0] - 1)
    return (values[np.where(inside, peaks + by, peaks)] for by in (-1, 0, 1))

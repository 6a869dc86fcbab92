"""How sure a score is: films drawn anew, with replacement, and always the same draws for the same seed."""

from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from .matching import Counts

DRAWS, SEED = 2000, 1
_EDGES = (2.5, 97.5)


class Interval(msgspec.Struct, frozen=True):
    """The range that holds 95 % of the scores that films drawn anew give."""

    low: float
    high: float


class Intervals(msgspec.Struct, frozen=True):
    """The intervals of the three scores."""

    f1: Interval
    precision: Interval
    recall: Interval


def intervals(films: Sequence[Counts], *, seed: int = SEED, draws: int = DRAWS) -> Intervals:
    """Return the 95 % bootstrap intervals of the scores over films (percentile method, Efron 1979)."""
    hits, false, missed = _drawn(films, seed, draws)
    return Intervals(
        f1=_interval(_share(2 * hits, 2 * hits + false + missed)),
        precision=_interval(_share(hits, hits + false)),
        recall=_interval(_share(hits, hits + missed)),
    )


def f1_gain(films: Sequence[Counts], over: Sequence[Counts]) -> Interval:
    """Return the interval of the first F1 less the second, both on the same films and the same draws of them.

    Raises ValueError where they do not have the same number of films.
    """
    if len(films) != len(over):
        raise ValueError(f"{len(films)} films against {len(over)}: expected the same films")
    scores = []
    for counts in (films, over):
        hits, false, missed = _drawn(counts, SEED, DRAWS)
        scores.append(_share(2 * hits, 2 * hits + false + missed))
    return _interval(scores[0] - scores[1])


def _drawn(films: Sequence[Counts], seed: int, draws: int) -> tuple[NDArray[np.intp], ...]:
    """Return hits, false and missed of each draw, shape (draws,) each."""
    table = np.array([(each.hits, each.false, each.missed) for each in films], np.intp).reshape(-1, 3)
    chosen = np.random.default_rng(seed).integers(0, max(1, len(table)), (draws, len(table)))
    return tuple(table[chosen].sum(axis=1).T)


def _share(part: NDArray[np.intp], whole: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return part / whole; 1 where there is nothing."""
    return np.where(whole > 0, part / np.maximum(whole, 1), 1.0)


def _interval(scores: NDArray[np.float64]) -> Interval:
    low, high = np.percentile(scores, _EDGES)
    return Interval(float(low), float(high))

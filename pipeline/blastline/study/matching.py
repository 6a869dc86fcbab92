"""One-to-one matching of found onsets with true ones, and what follows from it.

Conventions
    Times are in milliseconds, ascending. A found onset matches a true one within a window; no onset is used twice,
    and as many as possible are matched, as mir_eval's onset scores have it, those that are nearest to each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

Times = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Counts:
    """How many found onsets were right, how many were not, and how many shots were missed."""

    hits: int
    false: int
    missed: int

    @property
    def precision(self) -> float:
        """Return the share of the found that is right; 1 where nothing was found."""
        return self.hits / (self.hits + self.false) if self.hits + self.false else 1.0

    @property
    def recall(self) -> float:
        """Return the share of the shots that was found; 1 where there was none."""
        return self.hits / (self.hits + self.missed) if self.hits + self.missed else 1.0

    @property
    def f1(self) -> float:
        """Return the harmonic mean of precision and recall; 1 where there was nothing to find and nothing found."""
        every = 2 * self.hits + self.false + self.missed
        return 2 * self.hits / every if every else 1.0

    @property
    def error_rate(self) -> float | None:
        """Return (false + missed) / shots, as sed_eval has it for events of one kind; None where there is no shot."""
        shots = self.hits + self.missed
        return (self.false + self.missed) / shots if shots else None

    def __add__(self, other: "Counts") -> "Counts":
        """Return the counts of two films together."""
        return Counts(self.hits + other.hits, self.false + other.false, self.missed + other.missed)


def match(
    found_ms: Times, true_ms: Times, window_ms: float, alternatives_ms: Sequence[Sequence[float]] = ()
) -> list[tuple[int, int]]:
    """Return pairs of indices (found, true) that lie within the window: as many as there can be, of these the nearest.

    A shot may also be met at one of its `alternatives_ms`, one sequence for each, where its own place is not found: its
    shock is heard before its blast.

    >>> match(np.array([5.0, 12.0]), np.array([10.0, 11.0]), 6.0)
    [(0, 0), (1, 1)]
    >>> match(np.array([960.0, 1000.0]), np.array([1000.0]), 50.0)
    [(1, 0)]
    """
    found, true, away_ms, aside = _within_reach(found_ms, true_ms, alternatives_ms, window_ms)
    pairs: list[tuple[int, int]] = []
    for edges in _connected(found, true, found_ms.size, true_ms.size):
        pairs += _nearest(found[edges], true[edges], away_ms[edges], aside[edges], window_ms)
    return sorted(pairs, key=lambda pair: pair[1])


def count(
    found_ms: Times,
    true_ms: Times,
    window_ms: float,
    *,
    alternatives_ms: Sequence[Sequence[float]] = (),
    forgiven_ms: Sequence[float] = (),
) -> Counts:
    """Return the counts of a film.

    A found onset near one of `forgiven_ms`, or near another place of a shot, that matches nothing is not counted.
    """
    pairs = match(found_ms, true_ms, window_ms, alternatives_ms)
    left = np.delete(found_ms, [found for found, _ in pairs])
    forgiven = np.array([*forgiven_ms, *chain.from_iterable(alternatives_ms)], np.float64)
    excused = (np.abs(left[:, None] - forgiven[None, :]) <= window_ms).any(axis=1) if forgiven.size else np.zeros(0)
    return Counts(len(pairs), int(left.size - excused.sum()), int(true_ms.size - len(pairs)))


def _within_reach(
    found_ms: Times, true_ms: Times, alternatives_ms: Sequence[Sequence[float]], window_ms: float
) -> tuple[Indices, Indices, Times, NDArray[np.bool_]]:
    """Return every found onset that lies within the window of a place of a shot, that shot, how far away it is, and
    whether that is another place than the shot's own.
    """
    others = [(shot, at_ms) for shot, places in enumerate(alternatives_ms) for at_ms in places]
    places_ms = np.concatenate([true_ms, [at_ms for _, at_ms in others]])
    shots = np.concatenate([np.arange(true_ms.size), [shot for shot, _ in others]]).astype(np.intp)
    first = np.searchsorted(found_ms, places_ms - window_ms, "left")
    near = np.searchsorted(found_ms, places_ms + window_ms, "right") - first
    place = np.repeat(np.arange(places_ms.size), near)
    found = np.arange(place.size) + np.repeat(first - np.cumsum(near) + near, near)
    return found, shots[place], np.abs(found_ms[found] - places_ms[place]), place >= true_ms.size


def _connected(found: Indices, true: Indices, founds: int, shots: int) -> list[Indices]:
    """Return the edges in groups that share neither a found onset nor a shot with any other."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not found.size:
        return []
    size = founds + shots
    graph = coo_array((np.ones(found.size, np.int8), (found, founds + true)), shape=(size, size))
    _, group = connected_components(graph, directed=False)
    order = np.argsort(group[found], kind="stable")
    return np.split(order, np.flatnonzero(np.diff(group[found][order])) + 1)


def _nearest(
    found: Indices, true: Indices, away_ms: Times, aside: NDArray[np.bool_], window_ms: float
) -> list[tuple[int, int]]:
    """Return as many pairs of some edges as there can be, as few of them aside, and then as near, as that allows."""
    from scipy.optimize import linear_sum_assignment

    rows, row = np.unique(found, return_inverse=True)
    columns, column = np.unique(true, return_inverse=True)
    most = min(rows.size, columns.size)
    aside_ms = (window_ms + 1.0) * (most + 1)  # more than all distances together
    apart_ms = aside_ms * (most + 2)  # more than all pairs together
    distance_ms = np.full((rows.size, columns.size), apart_ms)
    np.minimum.at(distance_ms, (row, column), away_ms + aside_ms * aside)
    chosen = zip(*linear_sum_assignment(distance_ms), strict=True)
    return [(int(rows[one]), int(columns[other])) for one, other in chosen if distance_ms[one, other] < apart_ms]

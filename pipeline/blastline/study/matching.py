"""One-to-one matching of found onsets with true ones, and what follows from it.

Conventions
    Times are in milliseconds, ascending. A found onset matches a true one within a window; no onset is used twice,
    and as many as possible are matched, as mir_eval's onset scores have it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Times = NDArray[np.float64]


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


def match(found_ms: Times, true_ms: Times, window_ms: float) -> list[tuple[int, int]]:
    """Return pairs of indices (found, true) that lie within the window, as many as there can be.

    On a line, taking for each true onset, from early to late, the earliest found one that is free and near enough
    is a largest matching.

    >>> match(np.array([5.0, 12.0]), np.array([10.0, 11.0]), 6.0)
    [(0, 0), (1, 1)]
    """
    pairs: list[tuple[int, int]] = []
    free = 0
    for index, time in enumerate(true_ms):
        while free < len(found_ms) and found_ms[free] < time - window_ms:
            free += 1
        if free < len(found_ms) and found_ms[free] <= time + window_ms:
            pairs.append((free, index))
            free += 1
    return pairs


def settled(found_ms: Times, true_ms: Times, alternatives_ms: Sequence[Sequence[float]], window_ms: float) -> Times:
    """Return the true onsets, in their order, each moved to an alternative where only that was found: a shock is heard
    first, so what is returned need not ascend.
    """
    settled_ms = true_ms.copy()
    for index, others in enumerate(alternatives_ms):
        reached = [at for at in (true_ms[index], *others) if (np.abs(found_ms - at) <= window_ms).any()]
        settled_ms[index] = reached[0] if reached else true_ms[index]
    return settled_ms


def count(found_ms: Times, true_ms: Times, window_ms: float, *, forgiven_ms: Sequence[float] = ()) -> Counts:
    """Return the counts of a film; a found onset near one of `forgiven_ms` that matches nothing is not counted."""
    pairs = match(found_ms, true_ms, window_ms)
    left = np.delete(found_ms, [found for found, _ in pairs])
    forgiven = np.array(forgiven_ms, np.float64)
    excused = (np.abs(left[:, None] - forgiven[None, :]) <= window_ms).any(axis=1) if forgiven.size else np.zeros(0)
    return Counts(len(pairs), int(left.size - excused.sum()), int(true_ms.size - len(pairs)))

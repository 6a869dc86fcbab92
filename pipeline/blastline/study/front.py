"""The Pareto front: what nothing else beats at once in cost and in accuracy; and where the tiers lie."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def on_front(costs: Sequence[float], accuracies: Sequence[float]) -> NDArray[np.bool_]:
    """Return which of n settings no other dominates, shape (n,): costs no more, is no less accurate, in one better.

    >>> on_front([1.0, 2.0, 3.0], [0.5, 0.4, 0.9]).tolist()
    [True, False, True]
    """
    cost, accuracy = np.asarray(costs, np.float64), np.asarray(accuracies, np.float64)
    no_worse = (cost[:, None] <= cost) & (accuracy[:, None] >= accuracy)
    better = (cost[:, None] < cost) | (accuracy[:, None] > accuracy)
    return np.asarray(~(no_worse & better).any(axis=0), np.bool_)


def shortfall(index: int, costs: Sequence[float], accuracies: Sequence[float]) -> float:
    """Return how much more accurate than a setting the best of those that cost no more is; 0 on the front."""
    affordable = [accuracy for cost, accuracy in zip(costs, accuracies, strict=True) if cost <= costs[index]]
    return max(affordable) - accuracies[index]

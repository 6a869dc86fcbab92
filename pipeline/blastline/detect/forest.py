"""Boosted trees, walked by many candidates at once.

        f3 <= 1.5               Every split rules out some leaves: those to its left where it sends a candidate right.
       /         \\              Of what no split rules out, the leftmost leaf is where the walk would have ended
   f0 <= 7      leaf 2          (QuickScorer; Lucchese et al. 2015). So all splits of all trees can be asked in any
   /     \\                      order, and what they rule out is a bit for each leaf.
leaf 0  leaf 1
"""

from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

MOST_LEAVES = 64
"""A tree's leaves are the bits of a word."""

_AT_ONCE = 256  # rows that are scored together: their columns stay in the cache


class Tree(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One tree, node by node; a leaf has feature -1. Values at most the threshold go left."""

    feature: list[int]
    threshold: list[float]
    left: list[int]
    right: list[int]
    value: list[float]


class ForestFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Boosted trees and what their features are called, in order; log-odds are the baseline and a leaf of each tree."""

    features: tuple[str, ...]
    baseline: float
    trees: list[Tree]


@dataclass(frozen=True, eq=False)
class Forest:
    """Trees as arrays: each split's feature, threshold, leaves to its left (splits, trees); values (trees, leaves)."""

    feature: NDArray[np.intp]
    threshold: NDArray[np.float64]
    left: NDArray[np.unsignedinteger]
    value: NDArray[np.float64]
    baseline: float


def forest_from(file: ForestFile) -> Forest:
    """Return the trees padded to one size. ValueError where one has more leaves than `MOST_LEAVES`."""
    trees = [_splits_and_values(tree) for tree in file.trees]
    most_splits = max((len(splits) for splits, _ in trees), default=0)
    most_leaves = max((len(values) for _, values in trees), default=1)
    if most_leaves > MOST_LEAVES:
        raise ValueError(f"a tree has {most_leaves} leaves; expected at most {MOST_LEAVES}")
    shape = (most_splits, len(trees))
    feature, left = np.zeros(shape, np.intp), np.zeros(shape, np.uint64 if most_leaves > 32 else np.uint32)
    threshold, value = np.full(shape, np.inf), np.zeros((len(trees), most_leaves))
    for column, (splits, values) in enumerate(trees):
        for row, (asked, at_most, leaves) in enumerate(splits):
            feature[row, column], threshold[row, column] = asked, at_most
            left[row, column] = sum(1 << leaf for leaf in leaves)
        value[column, : len(values)] = values
    return Forest(feature, threshold, left, value, file.baseline)


def probabilities(rows: NDArray[np.float64], forest: Forest) -> NDArray[np.float64]:
    """Return the probability of a shot of each row, shape (n,)."""
    return np.asarray(1.0 / (1.0 + np.exp(-forest_log_odds(rows, forest))), np.float64)


def forest_log_odds(rows: NDArray[np.float64], forest: Forest) -> NDArray[np.float64]:
    """Return the log-odds of a shot of each row, shape (n,): the baseline and a leaf of each tree."""
    log_odds = np.empty(rows.shape[0])
    trees, leaves = forest.value.shape
    for first in range(0, rows.shape[0], _AT_ONCE):
        columns = np.ascontiguousarray(rows[first : first + _AT_ONCE].T)
        ruled_out = np.zeros((trees, columns.shape[1]), forest.left.dtype)
        for feature, threshold, left in zip(forest.feature, forest.threshold, forest.left, strict=True):
            goes_right = columns[feature] > threshold[:, None]
            ruled_out |= goes_right * left[:, None]
        # the bits before the lowest that is not set
        leaf = np.bitwise_count(ruled_out & ~(ruled_out + forest.left.dtype.type(1)))
        place = np.arange(trees)[:, None] * leaves + leaf
        log_odds[first : first + _AT_ONCE] = forest.baseline + forest.value.take(place).sum(axis=0)
    return log_odds


def _splits_and_values(tree: Tree) -> tuple[list[tuple[int, float, range]], list[float]]:
    """Return the splits of a tree, each with the leaves to its left, and its leaves' values from left to right."""
    splits: list[tuple[int, float, range]] = []
    values: list[float] = []

    def walk(node: int) -> None:
        if tree.feature[node] < 0:
            values.append(tree.value[node])
            return
        first = len(values)
        walk(tree.left[node])
        splits.append((tree.feature[node], tree.threshold[node], range(first, len(values))))
        walk(tree.right[node])

    walk(0)
    return splits, values

"""Rows of sounds that follow one another at a pace: how even they are, and which belong together.

|   |   |   |   |      one pace, within a few percent from gap to gap, peaks within 3 dB
  .       .            what sounds between, an echo or something else, does not break the row
"""

import math
from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..ruleset import BurstRules, QualityRules
from ..units import samples_from_ms

_MOST_IN_ROW = 256
"""A longer row is taken in pieces, which say as much: hours of a machine take no longer than they are long."""

_ENOUGH = 4  # so many tell that a row may be one
_AT_ONCE = 1024  # sounds whose pairs are held together


@dataclass(frozen=True)
class Pace:
    """What makes sounds one row: `fewest` of them, gaps in ms in a range and as even, peaks within `within_db`."""

    shortest_gap_ms: float
    longest_gap_ms: float
    unevenness: float
    fewest: int
    within_db: float


def automatic(rules: BurstRules) -> Pace:
    """Return the pace of a weapon that reloads itself and goes on."""
    return Pace(rules.shortest_gap_ms, rules.longest_gap_ms, rules.unevenness, rules.fewest_even, rules.echo_drop_db)


def shot_by_shot(tier: QualityRules) -> Pace:
    """Return the pace of somebody who pulls the trigger each time: slower than a burst, up to that of steps."""
    bursts, rows = tier.bursts, tier.rows
    return Pace(bursts.longest_gap_ms, rows.longest_gap_ms, rows.unevenness, rows.fewest, bursts.echo_drop_db)


def rows_at(
    onsets: NDArray[np.intp], peaks_dbfs: NDArray[np.float64], pace: Pace, *, rate_hz: int
) -> list[NDArray[np.intp]]:
    """Return the rows at a pace among onsets, ascending, the longest row first, as indices; no sound is in two."""
    gaps = _gaps(pace, rate_hz)
    at, loud_db = onsets.tolist(), peaks_dbfs.tolist()  # a few at a time: lists are faster than arrays
    told: set[tuple[int, int]] = set()
    rows = []
    for first, second in _beginnings(onsets, peaks_dbfs, pace, gaps):
        if (first, second) not in told:
            row = _row_on(at, loud_db, first, second, gaps=gaps, pace=pace)
            told.update(pairwise(row))
            rows.append(row[:_MOST_IN_ROW])
    free = np.ones(onsets.size, bool)
    chosen = []
    for row in sorted(rows, key=len, reverse=True):
        if len(row) >= pace.fewest and free[row].all():
            free[row] = False
            chosen.append(np.array(row, np.intp))
    return chosen


def evenly_placed(
    onsets: NDArray[np.intp], peaks_dbfs: NDArray[np.float64], pace: Pace, *, rate_hz: int, count: int | None = None
) -> NDArray[np.bool_]:
    """Return which onsets, ascending, are among `count` that follow one another at a pace, shape (n,).

    Without a count they are `fewest`, at most four. Each next one is the nearest to where it is due. That takes a few
    passes over arrays, where `rows_at` follows each row to its end.
    """
    wanted = min(pace.fewest, _ENOUGH) if count is None else count
    placed = np.zeros(onsets.size, bool)
    for pairs in _alike_pairs(onsets, peaks_dbfs, pace, _gaps(pace, rate_hz)):
        row = list(pairs)
        while row[0].size and len(row) < wanted:
            gap = onsets[row[-1]] - onsets[row[-2]]
            due = onsets[row[-1]] + gap
            after = np.clip(np.searchsorted(onsets, due), 1, onsets.size - 1)
            nearest = after - (due - onsets[after - 1] < onsets[after] - due)
            fits = np.abs(onsets[nearest] - due) <= pace.unevenness * gap
            fits &= np.abs(peaks_dbfs[nearest] - peaks_dbfs[row[0]]) <= pace.within_db
            row = [each[fits] for each in (*row, nearest)]
        for each in row:
            placed[each] = True
    return placed


def _gaps(pace: Pace, rate_hz: int) -> tuple[int, int]:
    return samples_from_ms(pace.shortest_gap_ms, rate_hz), samples_from_ms(pace.longest_gap_ms, rate_hz)


def _alike_pairs(
    onsets: NDArray[np.intp], peaks_dbfs: NDArray[np.float64], pace: Pace, gaps: tuple[int, int]
) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Yield the pairs of sounds that are alike and a gap of the pace apart, in order, some at once; shape (pairs,)."""
    for start in range(0, onsets.size, _AT_ONCE):
        own = onsets[start : start + _AT_ONCE]
        firsts, stops = np.searchsorted(onsets, own + gaps[0]), np.searchsorted(onsets, own + gaps[1], side="right")
        count = np.maximum(stops - firsts, 0)  # the longest gap may be shorter than the shortest
        first = np.repeat(np.arange(start, start + own.size), count)
        second = np.arange(first.size) + np.repeat(firsts - (np.cumsum(count) - count), count)
        alike = np.abs(peaks_dbfs[second] - peaks_dbfs[first]) <= pace.within_db
        yield first[alike], second[alike]


def _beginnings(
    onsets: NDArray[np.intp], peaks_dbfs: NDArray[np.float64], pace: Pace, gaps: tuple[int, int]
) -> Iterator[tuple[int, int]]:
    """Yield the pairs that a row may begin with, in order: few pairs of sounds are alike and have a third in time."""
    for first, second in _alike_pairs(onsets, peaks_dbfs, pace, gaps):
        if pace.fewest > 2:
            gap = onsets[second] - onsets[first]
            late, due = np.ceil(pace.unevenness * gap).astype(np.intp), onsets[second] + gap
            third = np.searchsorted(onsets, due - late) < np.searchsorted(onsets, due + late, side="right")
            first, second = first[third], second[third]
        yield from zip(first.tolist(), second.tolist(), strict=True)


def _row_on(
    at: list[int], loud_db: list[float], first: int, second: int, *, gaps: tuple[int, int], pace: Pace
) -> list[int]:
    """Return the row that goes on from two sounds at their pace, each next one where it is due, if it is as loud.

    No gap is shorter or longer than `gaps` allow. Of a row that is taken in pieces, the next one's first sound is last.
    """
    row, due, late = [first], at[second], 0.0
    while len(row) <= _MOST_IN_ROW:
        latest = min(due + late, at[row[-1]] + gaps[1])
        place = bisect_left(at, max(due - late, at[row[-1]] + gaps[0]), row[-1])
        nearest, distance = None, math.inf
        while place < len(at) and at[place] <= latest:
            if abs(loud_db[place] - loud_db[first]) <= pace.within_db and abs(at[place] - due) < distance:
                nearest, distance = place, abs(at[place] - due)
            place += 1
        if nearest is None:
            break
        row.append(nearest)
        gap = at[row[-1]] - at[row[-2]]
        due, late = at[row[-1]] + gap, pace.unevenness * gap
    return row

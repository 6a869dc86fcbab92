"""Segments of the old film that want the same place of the new one: which gives way, and by how much."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .fingerprint import FRAME_HZ
from .segments import STEP, Lane, MatchedSegment

_TOLERATED_OVERLAP_S = 0.5
"""Segments may share so much of the new film: their ends are put to 20 ms afterwards."""

_AS_GOOD_S = 0.1
"""Places to part two segments whose likeness differs by no more than so much of a full second are as good."""


@dataclass(frozen=True)
class Yielded:
    """What a segment, given by its index, has to give up to another: from one second of the old film to another."""

    index: int
    start_s: float
    stop_s: float


def yielded(segments: Sequence[MatchedSegment], lanes: Sequence[Lane]) -> list[Yielded]:
    """Return what has to give way where two of the segments, in the old film's order, claim one place of the new one.

    Segments on the heaviest chain that keeps the film's order win over others; among equals the longer one does. Two
    on the chain may both linger past the cut between them, and are parted there.
    """
    weight = [(segment.stop_s - segment.start_s) * segment.alike for segment in segments]
    chain = _ordered_chain(segments, weight)
    order = sorted(range(len(segments)), key=lambda index: (index not in chain, -weight[index]))
    found: list[Yielded] = []

    def give_up(index: int, new_start_s: float, new_stop_s: float) -> None:
        if new_start_s < new_stop_s:
            line = segments[index].line
            found.append(Yielded(index, line.back(new_start_s), line.back(new_stop_s)))

    for place, index in enumerate(order):
        start_s, stop_s = segments[index].new_span_s
        for winner in order[:place]:
            low_s, high_s = segments[winner].new_span_s
            first_s, last_s = max(start_s, low_s), min(stop_s, high_s)  # what both claim
            if last_s - first_s <= _TOLERATED_OVERLAP_S:
                continue
            if index not in chain:
                give_up(index, first_s, last_s)
                continue
            earlier, later = sorted((index, winner))
            cut_s = _parting_s(segments[earlier], segments[later], lanes, first_s, last_s, first_wins=earlier == winner)
            give_up(earlier, cut_s, last_s)
            give_up(later, first_s, cut_s)
    return found


def _parting_s(
    one: MatchedSegment, two: MatchedSegment, lanes: Sequence[Lane], low_s: float, high_s: float, *, first_wins: bool
) -> float:
    """Return the moment of the new film, between two, up to which the first and from which the second is more alike.

    Of moments that are as good, as in a scene that comes twice, it is the one that leaves most to the winner.
    """
    count = max(1, round((high_s - low_s) * FRAME_HZ / STEP))
    edges_s = np.linspace(low_s, high_s, count + 1)
    middles_s = 0.5 * (edges_s[1:] + edges_s[:-1])
    better = _alike_at(one, lanes, middles_s) - _alike_at(two, lanes, middles_s)
    total = np.concatenate([[0.0], np.cumsum(better)])
    good = np.flatnonzero(total >= total.max() - _AS_GOOD_S * FRAME_HZ / STEP)
    return float(edges_s[good[-1 if first_wins else 0]])


def _alike_at(segment: MatchedSegment, lanes: Sequence[Lane], new_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how alike the films are along a segment at some moments of the new one."""
    for lane in lanes:
        if lane.line is segment.line:
            old_s = np.array([lane.line.back(each) for each in new_s.tolist()])
            steps = np.round(old_s * FRAME_HZ / STEP).astype(int) - lane.first
            return np.asarray(lane.likeness[np.clip(steps, 0, len(lane.likeness) - 1)], np.float64)
    return np.full(new_s.shape, segment.alike)


def _ordered_chain(segments: Sequence[MatchedSegment], weight: Sequence[float]) -> set[int]:
    """Return the heaviest set of segments that follow each other in both films.

    What two of them share of the new film counts for neither more than once: it is charged at the higher likeness.
    """
    best: list[float] = []
    before: list[int | None] = []
    for index, segment in enumerate(segments):
        start, stop = segment.new_span_s
        last, most = None, 0.0
        for other in range(index):
            low, high = segments[other].new_span_s
            if low <= start and high <= stop:
                shared = max(0.0, high - start) * max(segment.alike, segments[other].alike)
                if best[other] - shared > most:
                    last, most = other, best[other] - shared
        best.append(weight[index] + most)
        before.append(last)
    chain: set[int] = set()
    at: int | None = max(range(len(best)), key=best.__getitem__, default=None)
    while at is not None:
        chain.add(at)
        at = before[at]
    return chain

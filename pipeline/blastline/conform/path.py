"""Which line the film runs along at each moment: the path that agrees best, with as few cuts as it can.

e(t, line) is how much more alike the films are along the line, over a second around t, than two films are by chance;
along no line at all it is 0. `states` finds the path. Where two segments of the old film want the same place in the
new one, one of them loses it.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .fingerprint import FRAME_HZ, Fingerprint, summed_around
from .lines import Line, find_lines
from .states import NO_LINE, best_states

STEP = 10
"""Frames between two steps of the path: a tenth of a second. Cuts are put to the millisecond afterwards."""

_LIKENESS_WINDOW_S = 1.0
"""How alike the films are at a step is told over so much around it."""

_CHANCE_LIKENESS = 0.35
"""How alike two films are by chance: a line gains only what it is more."""

_CUT_COST_S = 0.8
"""What a cut costs, as seconds of a gain of 1: a path changes lines only where that gains more."""

_LANE_MARGIN_S = 60.0
"""So far before and after where it was found a line may be followed."""

_TOLERATED_OVERLAP_S = 0.5
"""Segments may share so much of the new film: their ends are put to the millisecond afterwards."""

_AS_GOOD_S = 0.1
"""Places to part two segments whose likeness differs by no more than so much of a full second are as good."""

_MAX_ROUNDS = 20
"""So often the path is sought anew, each time without what had to give way; what still does is left out."""

_FORBIDDEN = -10.0
"""A gain that no path bears: to leave a line and to come back costs less."""


@dataclass(frozen=True)
class MatchedSegment:
    """A piece of the old film, in seconds, that runs along a line of the new one; `alike` is how well, 0 to 1."""

    line: Line
    start_s: float
    stop_s: float
    alike: float

    @property
    def new_span_s(self) -> tuple[float, float]:
        """Return where it lies in the new film."""
        return self.line.at(self.start_s), self.line.at(self.stop_s)


def find_segments(
    old: Fingerprint, new: Fingerprint, tell: Callable[[int, int], None] | None = None
) -> list[MatchedSegment]:
    """Return the segments of the old film that the new one has, in the old film's order.

    `tell` hears how many seconds of how many have been looked for.
    """
    return find_path(old, new, find_lines(old, new, tell))


@dataclass(frozen=True, eq=False)
class Lane:
    """A line with how alike the films are along it at every step from `first` on, not far from where it was found.

    `likeness`, shape (steps,), is a correlation.
    """

    line: Line
    first: int
    likeness: NDArray[np.float32]

    @property
    def gain(self) -> NDArray[np.float32]:
        """Return how much more alike than by chance the films are, shape (steps,)."""
        return self.likeness - np.float32(_CHANCE_LIKENESS)


def find_path(old: Fingerprint, new: Fingerprint, lines: Sequence[Line]) -> list[MatchedSegment]:
    """Return the segments that the best path along some lines has."""
    lanes = list(_worthwhile(old, new, lines))
    if not lanes:
        return []
    steps = -(-len(old) // STEP)
    gains = [lane.gain for lane in lanes]
    for _ in range(_MAX_ROUNDS):
        segments = _segments(
            best_states([lane.first for lane in lanes], gains, steps, cost=_CUT_COST_S * FRAME_HZ / STEP), lanes
        )
        losers = _losers(segments, lanes)
        if not losers:
            return segments
        for index, start_s, stop_s in losers:
            number = next(n for n, lane in enumerate(lanes) if lane.line is segments[index].line)
            first, last = (round(time_s * FRAME_HZ / STEP) - lanes[number].first for time_s in (start_s, stop_s))
            gains[number][max(0, first) : max(0, last + 1)] = _FORBIDDEN
    kept = {index for index, _, _ in _losers(segments, lanes)}
    return [segment for index, segment in enumerate(segments) if index not in kept]


def _worthwhile(old: Fingerprint, new: Fingerprint, lines: Sequence[Line]) -> Iterator[Lane]:
    """Yield the lines that gain more somewhere than a cut costs.

    No path could run along any other line, so leaving those out changes nothing but the cost.
    """
    for line in lines:
        lane = _lane(old, new, line)
        gain = np.cumsum(lane.gain, dtype=np.float64)
        least = np.minimum.accumulate(np.concatenate([[0.0], gain[:-1]])) if gain.size else gain
        if gain.size and float(np.max(gain - least)) > _CUT_COST_S * FRAME_HZ / STEP:
            yield lane


def _lane(old: Fingerprint, new: Fingerprint, line: Line) -> Lane:
    """Return how alike the films are along a line at every step, not far from where the line was found."""
    count = -(-len(old) // STEP)
    first = max(0, int((line.first_s - _LANE_MARGIN_S) * FRAME_HZ) // STEP)
    stop = min(count, int((line.last_s + _LANE_MARGIN_S) * FRAME_HZ) // STEP + 1)
    frames = np.arange(first * STEP, min(stop * STEP, len(old)))
    ours = old.frames[first * STEP : min(stop * STEP, len(old))]
    theirs = new.at(line.scale * frames / FRAME_HZ + line.offset_s)
    size = round(_LIKENESS_WINDOW_S * FRAME_HZ)
    product = summed_around(np.sum(ours * theirs, axis=1), size)
    energy = summed_around(np.sum(ours**2, axis=1), size), summed_around(np.sum(theirs**2, axis=1), size)
    product, mine, yours = product[::STEP], energy[0][::STEP], energy[1][::STEP]
    scale = np.sqrt(mine * yours)
    least = 0.02 * size * ours.shape[1]
    # silence in both is no reason against a line, and none for it
    both_silent = (mine < least) & (yours < least)
    alike = np.where(scale > 0.0, product / np.where(scale > 0.0, scale, 1.0), 0.0)
    uneven = np.minimum(mine, yours) < 0.1 * np.maximum(mine, yours)
    return Lane(line, first, np.where(both_silent, _CHANCE_LIKENESS, np.where(uneven, 0.0, alike)).astype(np.float32))


def _segments(states: NDArray[np.int16], lanes: Sequence[Lane]) -> list[MatchedSegment]:
    edges = np.flatnonzero(np.diff(states)) + 1
    found = []
    for start, stop in zip([0, *edges], [*edges, len(states)], strict=True):
        state = int(states[start])
        if state != NO_LINE:
            lane = lanes[state]
            alike = float(np.mean(lane.likeness[start - lane.first : stop - lane.first]))
            step_s = STEP / FRAME_HZ
            found.append(
                MatchedSegment(lane.line, max(0.0, (float(start) - 0.5) * step_s), (float(stop) - 0.5) * step_s, alike)
            )
    return found


def _losers(segments: Sequence[MatchedSegment], lanes: Sequence[Lane]) -> list[tuple[int, float, float]]:
    """Return what has to give way, as (index, from, to) of the old film, where two segments claim one place.

    Those on the heaviest chain that keeps the film's order win over others; among equals the longer one. Two on the
    chain may both linger past the cut between them, and are parted there.
    """
    weight = [(segment.stop_s - segment.start_s) * segment.alike for segment in segments]
    chain = _ordered_chain(segments, weight)
    order = sorted(range(len(segments)), key=lambda index: (index not in chain, -weight[index]))
    losers = []
    for place, index in enumerate(order):
        start, stop = segments[index].new_span_s
        for other in order[:place]:
            low, high = segments[other].new_span_s
            first, last = max(start, low), min(stop, high)
            if last - first <= _TOLERATED_OVERLAP_S:
                continue
            parts = [(index, first, last)]
            if index in chain:
                one, two = sorted((index, other))
                cut = _parting_s(segments[one], segments[two], lanes, first, last, first_wins=one == other)
                parts = [(one, cut, last), (two, first, cut)]
            lines = [segments[loser].line for loser, _, _ in parts]
            losers += [(n, line.back(a), line.back(b)) for (n, a, b), line in zip(parts, lines, strict=True) if a < b]
    return losers


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

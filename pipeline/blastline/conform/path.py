"""Which line the film runs along at each moment: the path that agrees best, with as few cuts as it can.

e(t, line) is how much more alike the films are along the line, over a second around t, than two films are by chance;
along no line at all it is 0. `states` finds the path. Where two segments of the old film want the same place in the
new one, one of them gives way (`overlaps`).
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from .fingerprint import FRAME_HZ, Fingerprint, summed_around
from .lines import Line, find_lines
from .overlaps import yielded
from .segments import CHANCE_LIKENESS, STEP, Lane, MatchedSegment
from .states import NO_LINE, best_states

_LIKENESS_WINDOW_S = 1.0
"""How alike the films are at a step is told over so much around it."""

_CUT_COST_S = 0.8
"""What a cut costs, as seconds of a gain of 1: a path changes lines only where that gains more."""

_SILENT_POWER = 0.02
"""Below this power of a band, in the mean, a fingerprint is of silence."""

_UNEVEN_SHARE = 0.1
"""Where one film has less than this share of the other's power, they are not alike, whatever they correlate."""

_LANE_MARGIN_S = 60.0
"""So far before and after where it was found a line may be followed."""

_MAX_ROUNDS = 20
"""So often the path is sought anew, each time without what had to give way; what still does is left out."""

_FORBIDDEN = -10.0
"""A gain that no path bears: to leave a line and to come back costs less."""


def find_segments(
    old: Fingerprint, new: Fingerprint, tell: Callable[[int, int], None] | None = None, *, any_speed: bool = False
) -> list[MatchedSegment]:
    """Return the segments of the old film that the new one has, in the old film's order.

    `tell` hears how many seconds of how many have been looked for. With `any_speed`, unusual speeds are tried even
    where the usual ones seem to do.
    """
    return find_path(old, new, find_lines(old, new, tell, any_speed=any_speed))


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
        contested = yielded(segments, lanes)
        if not contested:
            return segments
        for part in contested:
            number = next(n for n, lane in enumerate(lanes) if lane.line is segments[part.index].line)
            first, last = (
                round(time_s * FRAME_HZ / STEP) - lanes[number].first for time_s in (part.start_s, part.stop_s)
            )
            gains[number][max(0, first) : max(0, last + 1)] = _FORBIDDEN
    dropped = {part.index for part in yielded(segments, lanes)}
    return [segment for index, segment in enumerate(segments) if index not in dropped]


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
    least = _SILENT_POWER * size * ours.shape[1]
    # silence in both is no reason against a line, and none for it
    both_silent = (mine < least) & (yours < least)
    alike = np.where(scale > 0.0, product / np.where(scale > 0.0, scale, 1.0), 0.0)
    uneven = np.minimum(mine, yours) < _UNEVEN_SHARE * np.maximum(mine, yours)
    return Lane(line, first, np.where(both_silent, CHANCE_LIKENESS, np.where(uneven, 0.0, alike)).astype(np.float32))


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

"""Anchors: lively moments of a segment that are looked for in the new film, and the line that most of them lie on."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .film import Film
from .fingerprint import FRAME_HZ, Fingerprint
from .segments import MatchedSegment
from .waveform import look

ANCHOR_S = (0.0, 0.5)  # what of the sound is compared, before and after an anchor's moment
SHORT_ANCHOR_S = (0.005, 0.06)  # where the pitch was kept, whose tool moves each piece of sound by itself
_EVERY_S = 5.0
_FEWEST, _MOST = 6, 60
"""A segment has an anchor every so often, but no fewer and no more than so many."""

SEARCH_S = 0.06  # to either side of where the line leads
_ALIKE = 0.4  # an anchor less alike than this is not found
_STEEPEST = 0.005
"""By how much a course may be steeper than its line: a step of the speeds that are tried, at 0.9 of the speed."""

_ROUNDS = 3
SHARP_S = 20e-6
"""Anchors are exact to some microseconds; those that are not are dropped, round by round."""

_FEWEST_TELLING = 4  # of three, two are always on a line, and the third may be the one that is right


@dataclass(frozen=True, eq=False)
class Anchors:
    """Anchors that were found in the new film, shape (n,) each: when in the old film, and how late and alike there."""

    old_s: NDArray[np.float64]
    late_s: NDArray[np.float64]
    likeness: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Consensus:
    """The line, lateness = slope * old time + level, that most anchors lie near, and which do, shape (n,)."""

    slope: float
    level_s: float
    near: NDArray[np.bool_]

    def beside_s(self, anchors: Anchors) -> NDArray[np.float64]:
        """Return how far each anchor lies from the line, shape (n,)."""
        return np.abs(anchors.late_s - self.slope * anchors.old_s - self.level_s)


def anchor_times(segment: MatchedSegment, fingerprint: Fingerprint) -> list[float]:
    """Return the liveliest moment of each of as many equal parts as a segment deserves."""
    length_s = segment.stop_s - segment.start_s
    count = int(np.clip(length_s / _EVERY_S, _FEWEST, _MOST))
    edges = np.linspace(segment.start_s, segment.stop_s, count + 1)
    times = []
    for start_s, stop_s in itertools.pairwise(edges):
        frames = np.arange(int(start_s * FRAME_HZ), max(int(start_s * FRAME_HZ) + 1, int(stop_s * FRAME_HZ)))
        frames = frames[frames < len(fingerprint)]
        if frames.size:
            rise = np.sum(np.maximum(fingerprint.frames[frames], 0.0), axis=1)
            times.append(float(frames[int(np.argmax(rise))]) / FRAME_HZ)
    return times


def find_anchors(
    segment: MatchedSegment,
    times: Sequence[float],
    old: Film,
    new: Film,
    *,
    pitch_scale: float,
    within_s: tuple[float, float],
    search_s: float = SEARCH_S,
) -> Anchors:
    """Return the anchors that are found in the new film, `search_s` beside the line at most.

    Of each, `within_s` before and after it is compared.
    """
    before_s, after_s = within_s
    rows = []
    for old_s in times:
        found = look(
            old,
            new,
            old_s=old_s,
            new_s=segment.line.at(old_s),
            before_s=before_s,
            after_s=after_s,
            scale=pitch_scale,
            search_s=search_s,
        )
        if found.likeness >= _ALIKE:
            rows.append((old_s, found.late_s, found.likeness))
    return Anchors(*np.array(rows, np.float64).reshape(-1, 3).T)


def consensus(anchors: Anchors, agree_s: float) -> Consensus:
    """Return the line near most anchors, of all lines through two of them and all level ones through one.

    Where that is not sharp, but more than half of these are so on another line, it is that one: an anchor that a hum
    has put a period aside would bend it, and shut out another for it. Where it is sharp, some of them may lie together
    on another by chance, which leads away from those that are far off.
    """
    old_s, late_s, weight = anchors.old_s, anchors.late_s, anchors.likeness
    best_weight, best = -1.0, np.zeros(len(old_s), bool)
    for one, other in [*itertools.combinations(range(len(old_s)), 2), *((n, n) for n in range(len(old_s)))]:
        slope = (late_s[other] - late_s[one]) / (old_s[other] - old_s[one]) if old_s[one] != old_s[other] else 0.0
        if abs(slope) > _STEEPEST:
            continue
        near = np.abs(late_s - late_s[one] - slope * (old_s - old_s[one])) <= agree_s
        total = float(weight[near].sum())
        if total > best_weight:
            best_weight, best = total, near
    if float(np.median(_line_by(anchors, best).beside_s(anchors)[best])) > SHARP_S:
        best = _near_sharp_line(anchors, best)
    for _ in range(_ROUNDS):
        line = _line_by(anchors, best)
        beside_s = line.beside_s(anchors)
        best = best & (beside_s <= _agreeing_s(float(np.median(beside_s[best]))))
    return replace(line, near=best)


def _line_by(anchors: Anchors, near: NDArray[np.bool_]) -> Consensus:
    """Return the line by some of the anchors."""
    slope, level_s = _fitted(anchors.old_s[near], anchors.late_s[near], anchors.likeness[near])
    return Consensus(slope, level_s, near)


def _near_sharp_line(anchors: Anchors, among: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which anchors lie near the line beside which more than half of some lie nearest, shape (n,).

    It goes through two of these, and a third has to bear it out. Where it is not sharp, they are those it was told of.
    """
    old_s, late_s = anchors.old_s[among], anchors.late_s[among]
    one, other = np.triu_indices(len(old_s), 1)
    apart = np.abs(late_s[other] - late_s[one]) <= _STEEPEST * np.abs(old_s[other] - old_s[one])
    apart &= old_s[one] != old_s[other]
    if len(old_s) < _FEWEST_TELLING or not apart.any():
        return among
    one, other = one[apart], other[apart]
    slopes = (late_s[other] - late_s[one]) / (old_s[other] - old_s[one])
    levels_s = late_s[one] - slopes * old_s[one]
    beside_s = np.sort(np.abs(late_s - slopes[:, None] * old_s - levels_s[:, None]), axis=1)[:, len(old_s) // 2]
    best = int(np.argmin(beside_s))
    if beside_s[best] > SHARP_S:
        return among
    line = Consensus(float(slopes[best]), float(levels_s[best]), among)
    return line.beside_s(anchors) <= _agreeing_s(float(beside_s[best]))


def _agreeing_s(median_s: float) -> float:
    """Return how near to a line an anchor has to lie to agree with others, half of which are so near to it."""
    return max(SHARP_S, 3.0 * median_s)


def _fitted(x: NDArray[np.float64], y: NDArray[np.float64], weight: NDArray[np.float64]) -> tuple[float, float]:
    """Return slope and level of the straight line through some anchors; level where they are too close together."""
    if len(x) < 3 or np.ptp(x) <= 1.0:
        return 0.0, float(np.average(y, weights=weight))
    slope, level = np.polyfit(x - x.mean(), y, 1, w=weight)
    return float(slope), float(level - slope * x.mean())

"""The exact course of each segment by the waveforms themselves.

Lively moments of the segment are looked for in the new film (`anchors`); the line that most of them lie on is the
segment's course. One that was sped up with its pitch kept has no such line to the sample, only one within the steps
of the tool that did it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .anchors import ANCHOR_S, SEARCH_S, SHARP_S, SHORT_ANCHOR_S, anchor_times, consensus, find_anchors
from .copied import copied_line
from .film import Film
from .lines import FITTED_S, SPEED_STEP, SPEEDS
from .segments import MatchedSegment

_AGREE_S = 0.5e-3  # an anchor so near to a line lies on it
_AGREE_STRETCHED_S = 0.03  # the same where the pitch was kept: by so much its tool moves sounds
_BESIDE = 5e-4
"""A course this near to the speed it was measured at needs no other speed: half of what 1001/1000 pulls."""

_TILT = 0.002
"""A fitted line may be so much beside its speed: one frame that was taken out is within it, and bends it."""

_LEAST_REST_S = 3.0
"""What lies before or after all anchors of a course, and lasts so long, may have a course of its own."""

_LEAST_TAKEN = 0.03
"""A course takes such a share of its segment at least, before the rest is measured as it is."""

_LEAST_KEPT_S, _FEWEST_KEPT = 4.0, 4
"""What kept its pitch lasts so long, and so many anchors and half of all agree: within 30 ms a few do by chance."""

_LEAST_HALVED_S = 30.0
"""A segment that lasts so long and is on no single course is measured in halves."""

_PULLS = (1.0, 1001.0 / 1000.0, 1000.0 / 1001.0)
"""By so much a copy may run faster besides, where pictures are counted at 23.976 for 24, or the other way round."""


@dataclass(frozen=True)
class Course:
    """A segment whose line was measured.

    `pitch_scale` is by how much longer a sound's own waveform is in the new film: the line's scale where the pitch
    moved with the speed, 1 where it was kept. `agree_s` is how far anchors lie from the line, `anchors` how many do.
    """

    segment: MatchedSegment
    pitch_scale: float
    agree_s: float
    anchors: int

    @property
    def keeps_pitch(self) -> bool:
        """Return whether the speed changed without the pitch."""
        return abs(self.pitch_scale / self.segment.line.scale - 1.0) > 1e-3

    def between(self, start_s: float, stop_s: float) -> "Course":
        """Return the course from one moment of the old film to another."""
        return replace(self, segment=replace(self.segment, start_s=start_s, stop_s=stop_s))


@dataclass(frozen=True)
class Anchored:
    """A course with the times of the first and the last of the most anchors on it that follow one another."""

    course: Course
    first_s: float
    last_s: float


def measured(segments: Sequence[MatchedSegment], old: Film, new: Film) -> list[Course]:
    """Return the courses of the segments in order, joined where one goes on as the last did.

    A segment whose anchors do not agree on any line is left out: what the coarse look took for it is not there.
    """
    return joined([each.course for segment in segments for each in _measured(segment, old, new)])


def _measured(segment: MatchedSegment, old: Film, new: Film) -> list[Anchored]:
    """Return the courses of a segment in order: a frame taken out, or put in, is too little for a cut of the path.

    Neighbours share the film from the one's last anchor to the other's first; where the cut is there, their waveforms
    tell.
    """
    best = _best(segment, old, new)
    if best is None:
        return _measured_in_halves(segment, old, new)
    if best.course.keeps_pitch:
        return [best]
    own = best.course.segment
    before: list[Anchored] = []
    after: list[Anchored] = []
    if best.first_s - own.start_s >= _LEAST_REST_S:
        before = _rest(replace(own, stop_s=best.first_s), own, old, new)
    while before and _goes_on(before[-1].course.segment, own):
        before.pop()
    if own.stop_s - best.last_s >= _LEAST_REST_S:
        after = _rest(replace(own, start_s=best.last_s), own, old, new)
    while after and _goes_on(own, after[0].course.segment):
        after.pop(0)
    start_s = before[-1].last_s if before else own.start_s
    stop_s = after[0].first_s if after else own.stop_s
    return [*before, replace(best, course=best.course.between(start_s, stop_s)), *after]


def _rest(rest: MatchedSegment, whole: MatchedSegment, old: Film, new: Film) -> list[Anchored]:
    """Return the courses of what a course leaves of a segment; where that is nearly all, of its halves.

    Else a course of one anchor at an end would be found again and again.
    """
    shorter_s = (whole.stop_s - whole.start_s) - (rest.stop_s - rest.start_s)
    if shorter_s < _LEAST_TAKEN * (whole.stop_s - whole.start_s):
        return _measured_in_halves(rest, old, new)
    return _measured(rest, old, new)


def _measured_in_halves(segment: MatchedSegment, old: Film, new: Film) -> list[Anchored]:
    """Return the courses of a segment of which no quarter is on one: a copy that lacks single frames in many places.

    The courses on either side of the middle share the film between their anchors, as neighbours do.
    """
    if segment.stop_s - segment.start_s < _LEAST_HALVED_S:
        return []
    middle_s = 0.5 * (segment.start_s + segment.stop_s)
    left = _measured(replace(segment, stop_s=middle_s), old, new)
    right = _measured(replace(segment, start_s=middle_s), old, new)
    if left and right:
        last, first = left[-1], right[0]
        left[-1] = replace(last, course=last.course.between(last.course.segment.start_s, first.first_s))
        right[0] = replace(first, course=first.course.between(last.last_s, first.course.segment.stop_s))
    return [*left, *right]


def _best(segment: MatchedSegment, old: Film, new: Film) -> Anchored | None:
    """Return the course that most anchors of a segment lie on, at its speed or one near it."""
    times = anchor_times(segment, old.fingerprint)
    found: list[tuple[tuple[int, float, float], Anchored]] = []
    for each in _at_near_speeds(segment):
        anchored = through_anchors(each, times, old, new, pitch_scale=each.line.scale)
        if anchored is not None:
            course = anchored.course
            beside = abs(course.segment.line.scale / each.line.scale - 1.0)
            # what was resampled by another speed is heard some microseconds beside its place
            found.append(((course.anchors, -max(course.agree_s, SHARP_S), -beside), anchored))
            if course.anchors >= 0.5 * len(times) and course.agree_s <= SHARP_S and beside <= _BESIDE:
                break
    best = max(found, key=lambda each: each[0])[1] if found else None
    lasts_s = segment.stop_s - segment.start_s
    may_be_kept = abs(segment.line.scale - 1.0) > _TILT and lasts_s >= _LEAST_KEPT_S
    if (best is None or best.course.anchors < len(times) // 3) and may_be_kept:
        kept = through_anchors(segment, times, old, new, pitch_scale=1.0)
        if kept is not None:  # half of the anchors are on it: more than on the best
            return kept
    return best


def _at_near_speeds(segment: MatchedSegment) -> Iterator[MatchedSegment]:
    """Yield a segment, and also at the speeds near it that copies have: of a short one its line may be a step off."""
    yield segment
    line = segment.line
    farthest = _TILT if line.last_s - line.first_s >= FITTED_S else 1.5 * SPEED_STEP
    middle_s = 0.5 * (segment.start_s + segment.stop_s)
    usual = [pull / speed for speed in SPEEDS for pull in _PULLS]
    for scale in (*usual, line.scale / (1.0 + SPEED_STEP), line.scale / (1.0 - SPEED_STEP)):
        if 1e-6 < abs(scale / line.scale - 1.0) < farthest:
            yield replace(segment, line=replace(line, scale=scale, offset_s=line.at(middle_s) - scale * middle_s))


def through_anchors(
    segment: MatchedSegment,
    times: Sequence[float],
    old: Film,
    new: Film,
    *,
    pitch_scale: float,
    search_s: float = SEARCH_S,
) -> Anchored | None:
    """Return the course that most anchors lie on; None where too few agree: a quarter and two, or half and four.

    They are looked for `search_s` beside the segment's line at most.
    """
    line = segment.line
    kept_pitch = abs(pitch_scale / line.scale - 1.0) > 1e-3
    within_s = SHORT_ANCHOR_S if kept_pitch else ANCHOR_S
    anchors = find_anchors(segment, times, old, new, pitch_scale=pitch_scale, within_s=within_s, search_s=search_s)
    if len(anchors.old_s) < 2:
        return None
    agree_s = _AGREE_STRETCHED_S if kept_pitch else _AGREE_S
    found = consensus(anchors, agree_s)
    count = int(found.near.sum())
    fewest = max(_FEWEST_KEPT, len(times) / 2) if kept_pitch else max(2, len(times) / 4)
    if count < fewest:
        return None
    beside_s = float(np.median(found.beside_s(anchors)[found.near]))
    if beside_s > agree_s:
        return None
    fitted = replace(line, scale=line.scale + found.slope, offset_s=line.offset_s + found.level_s)
    if not kept_pitch:
        near = [float(each) for each in anchors.old_s[found.near]]
        copied = copied_line(replace(segment, line=fitted), near, old, new, agreeing=count)
        fitted = fitted if copied is None else copied
    course = Course(replace(segment, line=fitted), pitch_scale if kept_pitch else fitted.scale, beside_s, count)
    run = _longest_run(found.near)
    return Anchored(course, float(anchors.old_s[run.start]), float(anchors.old_s[run.stop - 1]))


def _longest_run(chosen: NDArray[np.bool_]) -> slice:
    """Return the longest run of chosen ones that follow one another, the first of those that are as long."""
    edges = np.flatnonzero(np.diff(chosen, prepend=False, append=False))  # where a run starts, and where it stops
    starts, stops = edges[::2], edges[1::2]
    longest = int(np.argmax(stops - starts))
    return slice(int(starts[longest]), int(stops[longest]))


def joined(courses: Sequence[Course]) -> list[Course]:
    """Return courses with those joined that run along one line with nothing taken out or put in between."""
    through: list[Course] = []
    for course in courses:
        last = through[-1] if through else None
        if last is not None and last.keeps_pitch == course.keeps_pitch and _goes_on(last.segment, course.segment):
            longer = max(last, course, key=lambda each: each.anchors)
            alike = 0.5 * (last.segment.alike + course.segment.alike)
            segment = MatchedSegment(longer.segment.line, last.segment.start_s, course.segment.stop_s, alike)
            through[-1] = replace(longer, segment=segment, anchors=last.anchors + course.anchors)
        else:
            through.append(course)
    return through


def _goes_on(one: MatchedSegment, other: MatchedSegment) -> bool:
    """Return whether one line leads through both: to a millisecond at either end of both."""
    times = (one.start_s, one.stop_s, other.start_s, other.stop_s)
    return all(abs(one.line.at(time_s) - other.line.at(time_s)) <= 1e-3 for time_s in times)

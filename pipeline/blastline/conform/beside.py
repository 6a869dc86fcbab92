"""What lies beside a course and is on no line of the coarse look: the same film, a picture earlier or later.

old   |--------------|------------------------------|
new   |--------------|-|----------------------------|     one picture put in: the line of the right part
                                                          is too far from the left one where the bed is steady
"""

from collections.abc import Iterator, Sequence

from .anchors import anchor_times
from .courses import Course, through_anchors
from .ends import reached
from .film import Film

_REACH_S = 20.0
"""So much beside a course is looked at at a time; what is found there is a course whose neighbourhood is looked at."""

_SEARCH_S = 1.0  # half a second that is missing near an end of the film is found, and any number of pictures less
_LEAST_S = 1.0  # shorter gaps, and what is alike for less, are left
_SHARED_S = 0.5  # two courses may claim so much of the new film before their exact ends are known


def with_what_is_beside(courses: Sequence[Course], old: Film, new: Film) -> list[Course]:
    """Return the courses, whose ends are exact, and those found within a second of where one of them leads on."""
    kept, waiting = list(courses), list(courses)
    while waiting:
        course = waiting.pop(0)
        for from_s, to_s in _gaps_beside(course, kept, old):
            found = _in_gap(course, from_s, to_s, old, new)
            if found is not None and not any(_overlap_s(found, other) > _SHARED_S for other in kept):
                kept.append(found)
                waiting.append(found)
    return sorted(kept, key=lambda each: each.segment.start_s)


def _gaps_beside(course: Course, others: Sequence[Course], old: Film) -> Iterator[tuple[float, float]]:
    """Yield from where to where of the old film, the near end first, nothing is known beside a course, 20 s at most."""
    own = course.segment
    if course.keeps_pitch:
        return
    ends = [each.segment.stop_s for each in others if each.segment.stop_s <= own.start_s]
    earliest = max([0.0, own.start_s - _REACH_S, *ends])
    starts = [each.segment.start_s for each in others if each.segment.start_s >= own.stop_s]
    latest = min([old.duration_s, own.stop_s + _REACH_S, *starts])
    for near_s, far_s in ((own.start_s, earliest), (own.stop_s, latest)):
        if abs(far_s - near_s) >= _LEAST_S:
            yield near_s, far_s


def _in_gap(course: Course, from_s: float, to_s: float, old: Film, new: Film) -> Course | None:
    """Return the course of what is beside another, as far as it goes; None where the new film has something else."""
    low_s, high_s = sorted((from_s, to_s))
    part = course.between(low_s, high_s).segment
    times, scale = anchor_times(part, old.fingerprint), part.line.scale
    found = through_anchors(part, times, old, new, pitch_scale=scale, search_s=_SEARCH_S)
    if found is None:
        return None
    there = reached(found.course, from_s, to_s, old, new)
    return there if there.segment.stop_s - there.segment.start_s >= _LEAST_S else None


def _overlap_s(one: Course, other: Course) -> float:
    """Return how much of the new film both claim."""
    (start_s, stop_s), (low_s, high_s) = one.segment.new_span_s, other.segment.new_span_s
    return min(stop_s, high_s) - max(start_s, low_s)

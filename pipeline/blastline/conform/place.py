"""Each event's place in the new film: where its course leads, and where its own sound is heard.

old film   ──────|cut|────── event ──────|cut|──────
                      before   after               what is compared ends at a cut
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from ..model import HeardIn
from ..ruleset import ConformRules
from .courses import Course
from .film import Film
from .heard import hear_event
from .waveform import EXACT_S

_MORE_ALIKE = 0.1
"""By so much an event has to be more alike on a course further away than on one nearer."""

_ONE_PLACE_S = 0.02
"""Two events so close in the new film are at one place, where they are twice as far apart in the old one."""


class Loss(StrEnum):
    """Why an event was not placed."""

    REMOVED = "not in the new film: the scene was taken out or replaced"
    CHANGED = "the new film goes on here, but the shot's sound is not in it"
    TAKEN = "its place in the new film belongs to another shot, which sounds the same"


@dataclass(frozen=True)
class Placed:
    """An event in the new film: its time, how far that is from where its course leads, and how alike it sounds."""

    new_s: float
    residual_ms: float
    likeness: float
    course: int


@dataclass(frozen=True)
class Lost:
    """An event that was not placed, why, the nearest place (s of the new film) and the best likeness that was seen."""

    reason: Loss
    near_s: float
    likeness: float


def place(
    onsets_s: Sequence[float],
    courses: Sequence[Course],
    old: Film,
    new: Film,
    rules: ConformRules,
    *,
    mixes: Sequence[HeardIn] | None = None,
) -> list[Placed | Lost]:
    """Return for each onset of the old film, ascending, its place in the new one, or why it has none.

    `mixes` are those in which they are heard in the old film: what cancels in its mains may be in those of the new one.
    """
    nexts_s = [*onsets_s, old.duration_s][1:]  # none where there is no onset
    in_mains: list[HeardIn] = ["mains"] * len(onsets_s)
    found = [
        _place(onset_s, next_s - onset_s, mix, courses, old, new, rules)
        for onset_s, next_s, mix in zip(onsets_s, nexts_s, mixes or in_mains, strict=True)
    ]
    return _without_doubles(onsets_s, found, courses)


def moment(old_s: float, courses: Sequence[Course], *, within_s: float) -> float | None:
    """Return when a moment of the old film comes in the new one, by its course alone; None where its scene does not.

    A scene that begins or ends so little beside the moment, `within_s`, holds it: an end is measured, not exact.
    """
    nearest = min(courses, key=lambda course: course.segment.outside_s(old_s), default=None)
    if nearest is None or nearest.segment.outside_s(old_s) > within_s:
        return None
    return nearest.segment.line.at(old_s)


def _place(
    onset_s: float,
    room_s: float,
    mix: HeardIn,
    courses: Sequence[Course],
    old: Film,
    new: Film,
    rules: ConformRules,
) -> Placed | Lost:
    """Return the place of an event that has `room_s` to the next one and is heard in a mix."""
    best: Placed | None = None
    seen = 0.0
    inside = False
    for index in _candidates(onset_s, courses, rules.reach_s):
        course = courses[index]
        holds = course.segment.outside_s(onset_s) == 0.0
        inside |= holds
        heard = hear_event(onset_s, room_s, course, old, new, rules)
        if not heard.is_alike and mix != "mains":
            heard = hear_event(onset_s, room_s, course, old, new, rules, mix)
        found = heard.found
        seen = max(seen, found.likeness)
        late_s = 0.0 if abs(found.late_s) <= EXACT_S else found.late_s
        new_s = course.segment.line.at(onset_s) + late_s
        if not heard.is_alike or not -0.5 / new.rate_hz <= new_s < new.duration_s:
            continue
        if not holds and _claimed(new_s, index, courses, rules.shortest_ms / 1000.0):
            continue
        if best is None or found.likeness > best.likeness + _MORE_ALIKE:
            best = Placed(max(0.0, new_s), late_s * 1000.0, found.likeness, index)
        if holds:
            break
    if best is not None:
        return best
    near_s = min(_nearest(onset_s, courses), new.duration_s)
    return Lost(Loss.CHANGED if inside else Loss.REMOVED, max(0.0, near_s), seen)


def _candidates(onset_s: float, courses: Sequence[Course], reach_s: float) -> list[int]:
    """Return the courses that an event may be on, the likeliest first: those around it, and those next to it."""

    def outside_s(index: int) -> float:
        return courses[index].segment.outside_s(onset_s)

    near = [index for index in range(len(courses)) if outside_s(index) <= reach_s]
    before = [index for index, course in enumerate(courses) if course.segment.stop_s <= onset_s][-1:]
    after = [index for index, course in enumerate(courses) if course.segment.start_s > onset_s][:1]
    chosen = near if any(outside_s(index) == 0.0 for index in near) else [*near, *before, *after]
    return sorted(set(chosen), key=outside_s)


def _claimed(new_s: float, index: int, courses: Sequence[Course], shortest_s: float) -> bool:
    """Return whether a moment of the new film lies well inside another segment."""
    for other, course in enumerate(courses):
        start_s, stop_s = course.segment.new_span_s
        if other != index and start_s + shortest_s < new_s < stop_s - shortest_s:
            return True
    return False


def _nearest(onset_s: float, courses: Sequence[Course]) -> float:
    """Return the moment of the new film that is nearest to a lost event: the cut where it would have been."""
    if not courses:
        return 0.0
    course = min(courses, key=lambda each: max(each.segment.start_s - onset_s, onset_s - each.segment.stop_s, 0.0))
    inside_s = min(max(onset_s, course.segment.start_s), course.segment.stop_s)
    return float(course.segment.line.at(inside_s))


def _without_doubles(
    onsets_s: Sequence[float], found: Sequence[Placed | Lost], courses: Sequence[Course]
) -> list[Placed | Lost]:
    """Return the same, but where two events came to one place only the one that belongs there keeps it."""
    kept = list(found)
    placed = {index: each for index, each in enumerate(found) if isinstance(each, Placed)}
    order = sorted(placed, key=lambda index: placed[index].new_s)
    for one, other in itertools.pairwise(order):
        first, second = placed[one], placed[other]
        apart_s = abs(onsets_s[other] - onsets_s[one])
        if first.course == second.course or second.new_s - first.new_s > min(_ONE_PLACE_S, 0.5 * apart_s):
            continue
        loser = min(one, other, key=lambda index: _belongs(onsets_s[index], placed[index], courses))
        kept[loser] = Lost(Loss.TAKEN, placed[loser].new_s, placed[loser].likeness)
    return kept


def _belongs(onset_s: float, placed: Placed, courses: Sequence[Course]) -> tuple[bool, float]:
    """Return what tells of two events which belongs to a place more: one inside its course, then the more alike."""
    return courses[placed.course].segment.outside_s(onset_s) == 0.0, placed.likeness

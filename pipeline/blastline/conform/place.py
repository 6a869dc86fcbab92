"""Each event's place in the new film: where its course leads, and where its own sound is heard.

old film   ──────|cut|────── event ──────|cut|──────
                      before   after               what is compared ends at a cut
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from ..model import HeardIn
from ..ruleset import ConformRules
from .courses import Course
from .film import Film
from .waveform import EXACT_S, Found, look

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


@dataclass(frozen=True)
class _Heard:
    """Where an event is heard on a course, and the likeness that it has to reach there."""

    found: Found
    least: float

    @property
    def is_alike(self) -> bool:
        """Return whether it sounds as it has to."""
        return self.found.likeness >= self.least


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
    nearest = min(courses, key=lambda course: _distance(old_s, course), default=None)
    if nearest is None or _distance(old_s, nearest) > within_s:
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
        holds = _distance(onset_s, course) == 0.0
        inside |= holds
        heard = _heard(onset_s, room_s, course, old, new, rules)
        if not heard.is_alike and mix != "mains":
            heard = _heard(onset_s, room_s, course, old, new, rules, mix)
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
    near = [index for index, course in enumerate(courses) if _distance(onset_s, course) <= reach_s]
    before = [index for index, course in enumerate(courses) if course.segment.stop_s <= onset_s][-1:]
    after = [index for index, course in enumerate(courses) if course.segment.start_s > onset_s][:1]
    chosen = near if any(_distance(onset_s, courses[index]) == 0.0 for index in near) else [*near, *before, *after]
    return sorted(set(chosen), key=lambda index: _distance(onset_s, courses[index]))


def _distance(onset_s: float, course: Course) -> float:
    """Return how far outside a segment an event is, 0 inside."""
    segment = course.segment
    if segment.start_s <= onset_s < segment.stop_s:
        return 0.0
    return max(segment.start_s - onset_s, onset_s - segment.stop_s, 1e-9)


def _claimed(new_s: float, index: int, courses: Sequence[Course], shortest_s: float) -> bool:
    """Return whether a moment of the new film lies well inside another segment."""
    for other, course in enumerate(courses):
        start_s, stop_s = course.segment.new_span_s
        if other != index and start_s + shortest_s < new_s < stop_s - shortest_s:
            return True
    return False


def _heard(
    onset_s: float, room_s: float, course: Course, old: Film, new: Film, rules: ConformRules, mix: HeardIn = "mains"
) -> _Heard:
    """Return where the event, as a mix of the old film has it, is heard on a course, by as much as both films have."""
    if course.keeps_pitch:
        return _attack_heard(onset_s, course, old, new, rules, mix)
    segment, scale = course.segment, course.segment.line.scale
    shortest_s = rules.shortest_ms / 1000.0
    length_s = min(rules.after_ms / 1000.0, max(shortest_s, room_s * scale))
    if onset_s < segment.start_s:  # what follows the cut would be alike without the shot, too
        length_s = min(length_s, max(rules.attack_ms / 1000.0, (segment.start_s - onset_s) * scale))
    elif onset_s < segment.stop_s:
        length_s = min(length_s, max(shortest_s, (segment.stop_s - onset_s) * scale))
    least = rules.least if _distance(onset_s, course) <= rules.reach_s else rules.least_parted
    if length_s < shortest_s:
        ways = [(length_s, rules.close_ms / 1000.0, rules.least_short)]
    else:
        ways = [(length_s, rules.close_ms / 1000.0, least), (length_s, rules.far_ms / 1000.0, rules.least_far)]
    for after_s, search_s, enough in ways:
        found = look(
            old,
            new,
            old_s=onset_s,
            new_s=segment.line.at(onset_s),
            before_s=rules.before_ms / 1000.0,
            after_s=after_s,
            scale=course.pitch_scale,
            search_s=search_s,
            mix=mix,
        )
        heard = _Heard(found, enough)
        if heard.is_alike:
            break
    return heard


def _attack_heard(onset_s: float, course: Course, old: Film, new: Film, rules: ConformRules, mix: HeardIn) -> _Heard:
    """Return where the event is heard where the pitch was kept: there a tool moved each piece of sound by itself.

    The attack alone is compared, since a step of the tool may follow it. Where another place is nearly as good,
    nothing is enough.
    """

    def around(new_s: float, within_s: float) -> Found:
        return look(
            old,
            new,
            old_s=onset_s,
            new_s=new_s,
            before_s=rules.before_ms / 1000.0,
            after_s=rules.attack_ms / 1000.0,
            scale=course.pitch_scale,
            search_s=within_s,
            mix=mix,
        )

    search_s, rival_s = rules.kept_pitch_ms / 1000.0, rules.rival_ms / 1000.0
    expected_s = course.segment.line.at(onset_s)
    found = around(expected_s, search_s)
    if found.likeness < rules.least_kept_pitch:
        return _Heard(found, rules.least_kept_pitch)
    half_s = (search_s - rival_s) / 2.0
    sides = (expected_s + found.late_s + side * (rival_s + half_s) for side in (-1.0, 1.0))
    rival = max(around(side_s, half_s).likeness for side_s in sides)
    return _Heard(found, rules.least_kept_pitch if rival <= found.likeness - rules.rival_less else math.inf)


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
    return _distance(onset_s, courses[placed.course]) == 0.0, placed.likeness

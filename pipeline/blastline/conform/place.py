"""Each event's place in the new film: where its course leads, and where its own sound is heard.

old film   ──────|cut|────── event ──────|cut|──────
                      before   after               what is compared ends at a cut
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from .courses import Course
from .film import Film
from .waveform import Found, look

_BEFORE_S, _AFTER_S, _SHORTEST_S = 0.005, 0.2, 0.06
"""The shot's own sound, up to the next shot: what is before it would be alike without it, too."""

_LEFT_S = 0.02
"""Of a shot that a cut parts from its course, at least so much is compared."""

_NEAR_S, _FAR_S, _KEPT_PITCH_S = 0.0005, 0.004, 0.04
"""First close to the course, then further off: a hum is as much alike a period away."""

_LEAST, _LEAST_PARTED, _LEAST_SHORT, _LEAST_FAR = 0.35, 0.45, 0.5, 0.6
"""By chance, in 5,000 tries, 200 ms close to a course reach 0.18, 60 ms 0.3, 15 ms 0.44; further off it is 0.5."""

_LEAST_KEPT_PITCH = 0.9
"""A tool that keeps the pitch copies the sound in pieces: an attack that is less alike lies across two of them."""

_RIVAL_S, _RIVAL_LESS = 0.001, 0.1
"""There the search is wide: in a hum, a place a period off is as good, and none can be told."""

_REACH_S = 1.5
"""An event so near to a stretch's end is tried on its course as if it was inside: ends may be faded or dubbed over."""


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


def place(onsets_s: Sequence[float], courses: Sequence[Course], old: Film, new: Film) -> list[Placed | Lost]:
    """Return for each onset of the old film, ascending, its place in the new one, or why it has none."""
    nexts_s = [*onsets_s[1:], old.duration_s]
    found = [
        _place(onset_s, next_s - onset_s, courses, old, new) for onset_s, next_s in zip(onsets_s, nexts_s, strict=True)
    ]
    return _without_doubles(onsets_s, found, courses)


def _place(onset_s: float, room_s: float, courses: Sequence[Course], old: Film, new: Film) -> Placed | Lost:
    """Return the place of an event that has `room_s` to the next one."""
    best: Placed | None = None
    seen = 0.0
    inside = False
    for index in _candidates(onset_s, courses):
        course = courses[index]
        holds = _distance(onset_s, course) == 0.0
        inside |= holds
        found, least = _heard(onset_s, room_s, course, old, new)
        seen = max(seen, found.likeness)
        new_s = course.stretch.line.at(onset_s) + found.late_s
        if found.likeness < least or not 0.0 <= new_s < new.duration_s:
            continue
        if not holds and _claimed(new_s, index, courses):
            continue
        if best is None or holds or found.likeness > best.likeness + 0.1:
            best = Placed(new_s, found.late_s * 1000.0, found.likeness, index)
        if holds:
            break
    if best is not None:
        return best
    return Lost(Loss.CHANGED if inside else Loss.REMOVED, _nearest(onset_s, courses), seen)


def _candidates(onset_s: float, courses: Sequence[Course]) -> list[int]:
    """Return the courses that an event may be on, the likeliest first: those around it, and those next to it."""
    near = [index for index, course in enumerate(courses) if _distance(onset_s, course) <= _REACH_S]
    before = [index for index, course in enumerate(courses) if course.stretch.stop_s <= onset_s][-1:]
    after = [index for index, course in enumerate(courses) if course.stretch.start_s > onset_s][:1]
    chosen = near if any(_distance(onset_s, courses[index]) == 0.0 for index in near) else [*near, *before, *after]
    return sorted(set(chosen), key=lambda index: _distance(onset_s, courses[index]))


def _distance(onset_s: float, course: Course) -> float:
    """Return how far outside a stretch an event is, 0 inside."""
    stretch = course.stretch
    if stretch.start_s <= onset_s < stretch.stop_s:
        return 0.0
    return max(stretch.start_s - onset_s, onset_s - stretch.stop_s, 1e-9)


def _claimed(new_s: float, index: int, courses: Sequence[Course]) -> bool:
    """Return whether a moment of the new film lies well inside another stretch."""
    for other, course in enumerate(courses):
        start_s, stop_s = course.stretch.new_span_s
        if other != index and start_s + _SHORTEST_S < new_s < stop_s - _SHORTEST_S:
            return True
    return False


def _heard(onset_s: float, room_s: float, course: Course, old: Film, new: Film) -> tuple[Found, float]:
    """Return where the event is heard on a course, from as much of it as both films have, and what it has to reach."""
    stretch, scale = course.stretch, course.stretch.line.scale
    length_s = min(_AFTER_S, max(_SHORTEST_S, room_s * scale))
    if onset_s < stretch.start_s:  # what follows the cut would be alike without the shot, too
        length_s = min(length_s, max(_LEFT_S, (stretch.start_s - onset_s) * scale))
    elif onset_s < stretch.stop_s:
        length_s = min(length_s, max(_SHORTEST_S, (stretch.stop_s - onset_s) * scale))
    least = _LEAST if _distance(onset_s, course) <= _REACH_S else _LEAST_PARTED
    if course.keeps_pitch:
        return _attack_heard(onset_s, course, old, new), _LEAST_KEPT_PITCH
    if length_s < _SHORTEST_S:
        ways = [(length_s, _NEAR_S, _LEAST_SHORT)]
    else:
        ways = [(length_s, _NEAR_S, least), (length_s, _FAR_S, _LEAST_FAR)]
    for after_s, search_s, enough in ways:
        found, least = (
            look(
                old,
                new,
                old_s=onset_s,
                new_s=stretch.line.at(onset_s),
                before_s=_BEFORE_S,
                after_s=after_s,
                scale=course.pitch_scale,
                search_s=search_s,
            ),
            enough,
        )
        if found.likeness >= least:
            break
    return found, least


def _attack_heard(onset_s: float, course: Course, old: Film, new: Film) -> Found:
    """Return where an event's attack is heard in a film whose tool moved each piece of sound by as much as suited it.

    The attack alone is compared, since a step of the tool may follow it. Where another place is nearly as good,
    nothing was heard.
    """

    def around(new_s: float, search_s: float) -> Found:
        return look(
            old,
            new,
            old_s=onset_s,
            new_s=new_s,
            before_s=_BEFORE_S,
            after_s=_LEFT_S,
            scale=course.pitch_scale,
            search_s=search_s,
        )

    expected_s = course.stretch.line.at(onset_s)
    found = around(expected_s, _KEPT_PITCH_S)
    if found.likeness < _LEAST_KEPT_PITCH:
        return found
    half_s = (_KEPT_PITCH_S - _RIVAL_S) / 2.0
    sides = (expected_s + found.late_s + side * (_RIVAL_S + half_s) for side in (-1.0, 1.0))
    rival = max(around(side_s, half_s).likeness for side_s in sides)
    return found if rival <= found.likeness - _RIVAL_LESS else Found(found.late_s, 0.0)


def _nearest(onset_s: float, courses: Sequence[Course]) -> float:
    """Return the moment of the new film that is nearest to a lost event: the cut where it would have been."""
    if not courses:
        return 0.0
    course = min(courses, key=lambda each: max(each.stretch.start_s - onset_s, onset_s - each.stretch.stop_s, 0.0))
    inside_s = min(max(onset_s, course.stretch.start_s), course.stretch.stop_s)
    return float(course.stretch.line.at(inside_s))


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
        if first.course == second.course or second.new_s - first.new_s > min(0.02, 0.5 * apart_s):
            continue
        loser = min(one, other, key=lambda index: _belongs(onsets_s[index], placed[index], courses))
        kept[loser] = Lost(Loss.TAKEN, placed[loser].new_s, placed[loser].likeness)
    return kept


def _belongs(onset_s: float, placed: Placed, courses: Sequence[Course]) -> tuple[bool, float]:
    return _distance(onset_s, courses[placed.course]) == 0.0, placed.likeness

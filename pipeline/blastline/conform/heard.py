"""Where an event is heard on a course: what follows it, as much as both films have, or its attack alone."""

import math
from dataclasses import dataclass

import numpy as np

from ..model import HeardIn
from ..ruleset import ConformRules
from .courses import Course
from .film import Film
from .waveform import WORK_HZ, Found, Samples, look, piece

_MUTED = 1e-4
"""An attack whose share of a shot's energy is less than this part of what it was, 40 dB down, is not there: no limiter
takes so much of it, and what is put over a shot only adds.
"""

_REPLACED = 0.5
"""Of an attack that is another sound, before a decay that stayed, less than half is there: it is less than half as
alike as the shot as a whole, and that not for what was put over it, which would be louder by as much.
"""

_TOLD = 2.0
"""Of a soft attack 20 ms do not tell where the new film is as loud there as this many times what is due of it."""


@dataclass(frozen=True)
class HeardEvent:
    """Where an event is heard on a course, and the likeness that it has to reach there."""

    found: Found
    least: float

    @property
    def is_alike(self) -> bool:
        """Return whether it sounds as it has to."""
        return self.found.likeness >= self.least


def hear_event(
    onset_s: float, room_s: float, course: Course, old: Film, new: Film, rules: ConformRules, mix: HeardIn = "mains"
) -> HeardEvent:
    """Return where the event, as a mix of the old film has it, is heard on a course, by as much as both films have."""
    if course.keeps_pitch:
        return _attack_heard(onset_s, course, old, new, rules, mix)
    segment, length_s = course.segment, _length_s(onset_s, room_s, course, rules)
    least = rules.least if segment.outside_s(onset_s) <= rules.reach_s else rules.least_parted
    if length_s < rules.shortest_ms / 1000.0:
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
        heard = HeardEvent(found, enough)
        if heard.is_alike:
            break
    if heard.is_alike and _is_by_its_end(found, course, old, new, rules, onset_s=onset_s, length_s=length_s, mix=mix):
        return HeardEvent(found, math.inf)
    return heard


def _is_by_its_end(
    found: Found,
    course: Course,
    old: Film,
    new: Film,
    rules: ConformRules,
    *,
    onset_s: float,
    length_s: float,
    mix: HeardIn,
) -> bool:
    """Return whether a shot is alike by its decay alone, behind black or behind another sound."""
    scale, attack_s = course.pitch_scale, rules.attack_ms / 1000.0
    new_s, attack = course.segment.line.at(onset_s) + found.late_s, round(attack_s * WORK_HZ)
    before, _ = piece(old, onset_s, length_s / scale, scale=scale, mix=mix)
    after, _ = piece(new, new_s, length_s)
    if _is_muted(after[:attack], after, before[:attack], before):
        return True
    is_soft = _rms(before[:attack]) < _REPLACED * _rms(before)
    due, there = _rms(before[:attack]) * found.likeness * _rms(after) / _rms(before), _rms(after[:attack])
    if is_soft and there >= _TOLD * due:
        return False
    of_attack = look(
        old,
        new,
        old_s=onset_s,
        new_s=new_s,
        before_s=0.0,
        after_s=attack_s,
        scale=scale,
        search_s=1.0 / WORK_HZ,
        mix=mix,
    )
    return of_attack.likeness * max(1.0 / found.likeness, there / due) < _REPLACED


def _rms(samples: Samples) -> float:
    return float(np.sqrt(np.mean(samples**2)))


def _length_s(onset_s: float, room_s: float, course: Course, rules: ConformRules) -> float:
    """Return how much is compared from the onset on, in the new film's time: as far as the next event, or a cut."""
    segment, scale, shortest_s = course.segment, course.segment.line.scale, rules.shortest_ms / 1000.0
    length_s = min(rules.after_ms / 1000.0, max(shortest_s, room_s * scale))
    if onset_s < segment.start_s:  # what follows the cut would be alike without the shot, too
        return min(length_s, max(rules.attack_ms / 1000.0, (segment.start_s - onset_s) * scale))
    if onset_s < segment.stop_s:
        return min(length_s, max(shortest_s, (segment.stop_s - onset_s) * scale))
    return length_s


def _is_muted(attack: Samples, whole: Samples, old_attack: Samples, old_whole: Samples) -> bool:
    """Return whether an attack has next to nothing of the energy that it had in the old film, against the whole."""
    now, before = (np.sum(part**2) * np.sum(other**2) for part, other in ((attack, old_whole), (old_attack, whole)))
    return bool(now < _MUTED * before)


def _attack_heard(
    onset_s: float, course: Course, old: Film, new: Film, rules: ConformRules, mix: HeardIn
) -> HeardEvent:
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
        return HeardEvent(found, rules.least_kept_pitch)
    half_s = (search_s - rival_s) / 2.0
    sides = (expected_s + found.late_s + side * (rival_s + half_s) for side in (-1.0, 1.0))
    rival = max(around(side_s, half_s).likeness for side_s in sides)
    return HeardEvent(found, rules.least_kept_pitch if rival <= found.likeness - rules.rival_less else math.inf)

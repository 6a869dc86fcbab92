"""Where an event is heard on a course: what follows it, as much as both films have, or its attack alone."""

import math
from dataclasses import dataclass

from ..model import HeardIn
from ..ruleset import ConformRules
from .courses import Course
from .film import Film
from .waveform import Found, look


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
    segment, scale = course.segment, course.segment.line.scale
    shortest_s = rules.shortest_ms / 1000.0
    length_s = min(rules.after_ms / 1000.0, max(shortest_s, room_s * scale))
    if onset_s < segment.start_s:  # what follows the cut would be alike without the shot, too
        length_s = min(length_s, max(rules.attack_ms / 1000.0, (segment.start_s - onset_s) * scale))
    elif onset_s < segment.stop_s:
        length_s = min(length_s, max(shortest_s, (segment.stop_s - onset_s) * scale))
    least = rules.least if segment.outside_s(onset_s) <= rules.reach_s else rules.least_parted
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
        heard = HeardEvent(found, enough)
        if heard.is_alike:
            break
    return heard


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

"""What of an old film is where in a new one, from fingerprints to the moments at which waveforms part."""

from collections.abc import Callable

from .beside import with_what_is_beside
from .courses import Course, joined, measured
from .ends import with_exact_ends
from .film import Film
from .path import find_segments


def find_courses(old: Film, new: Film, tell: Callable[[int, int], None] | None = None) -> list[Course]:
    """Return the courses of the old film in the new one, in the old film's order; none where they share nothing.

    What is alike at a speed beside its own may have no course; then every speed is tried. `tell` hears how many seconds
    of how many have been looked for.
    """
    for any_speed in (False, True):
        segments = find_segments(old.fingerprint, new.fingerprint, tell, any_speed=any_speed)
        if courses := measured(segments, old, new):
            courses = with_exact_ends(courses, old, new)
            more = with_what_is_beside(courses, old, new)
            return with_exact_ends(joined(more), old, new) if len(more) > len(courses) else courses
    return []

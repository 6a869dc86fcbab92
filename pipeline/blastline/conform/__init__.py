"""A timeline for a new cut: what of the old film is where in the new one, and each event's place in it.

old film ──► fingerprint ──┐
                           ├─► lines ─► path ─► courses ─► ends, beside ─► places ─► the new timeline
new film ──► fingerprint ──┘
"""

from .courses import Course, measured
from .ends import with_exact_ends
from .film import Film, hear
from .find import find_courses
from .path import find_segments
from .place import Loss, Lost, Placed, moment, place
from .report import new_timecode, write_events, write_stretches
from .retime import Retimed, retimed

__all__ = [
    "Course",
    "Film",
    "Loss",
    "Lost",
    "Placed",
    "Retimed",
    "find_courses",
    "find_segments",
    "hear",
    "measured",
    "moment",
    "new_timecode",
    "place",
    "retimed",
    "with_exact_ends",
    "write_events",
    "write_stretches",
]

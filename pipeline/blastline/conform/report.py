"""What a conform did, as two tables: one row per event, one per segment of film."""

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

from ..model import Event
from .courses import Course
from .place import Lost, Placed

EVENT_COLUMNS = ("id", "placed", "old_onset_s", "new_onset_s", "residual_ms", "likeness", "stretch", "reason")
SEGMENT_COLUMNS = (
    "stretch",
    "old_start_s",
    "old_stop_s",
    "new_start_s",
    "new_stop_s",
    "speed",
    "pitch",
    "alike",
    "anchors",
    "agree_ms",
)


def write_events(path: Path, events: Sequence[Event], found: Sequence[Placed | Lost]) -> None:
    """Write where each event of the old film went.

    `new_onset_s` of an event that was not placed is the moment of the new film at which it is missing.
    """
    rows = []
    for event, each in zip(events, found, strict=True):
        if isinstance(each, Placed):
            rest = [f"{each.new_s:.9f}", f"{each.residual_ms:z.4f}", f"{each.likeness:z.3f}", each.course + 1, ""]
        else:
            rest = [f"{each.near_s:.9f}", "", f"{each.likeness:z.3f}", "", each.reason.value]
        rows.append([event.id, "yes" if isinstance(each, Placed) else "no", f"{event.onset_s:.9f}", *rest])
    _write(path, EVENT_COLUMNS, rows)


def write_segments(path: Path, courses: Sequence[Course]) -> None:
    """Write which part of the old film is where in the new one.

    `speed` is how much faster the new film runs, `pitch` how much higher it sounds; `alike` how alike the two sound,
    0 to 1; `agree_ms` how far, in the middle, the anchors are from the straight line.
    """
    rows = []
    for number, course in enumerate(courses, start=1):
        segment = course.segment
        start_s, stop_s = segment.new_span_s
        times = [f"{time_s:z.6f}" for time_s in (segment.start_s, segment.stop_s, start_s, stop_s)]
        speed, pitch = 1.0 / segment.line.scale, 1.0 / course.pitch_scale
        agree = [f"{segment.alike:.3f}", course.anchors, f"{course.agree_s * 1000.0:.4f}"]
        rows.append([number, *times, f"{speed:.7f}", f"{pitch:.7f}", *agree])
    _write(path, SEGMENT_COLUMNS, rows)


def _write(path: Path, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)

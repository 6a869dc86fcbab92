"""What a conform did, as two tables: one row per event, one per stretch of film."""

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

from ..model import Event, Source
from ..timecode import timecode_at
from ..units import samples_from_s
from .courses import Course
from .place import Lost, Placed

EVENT_COLUMNS = (
    "id",
    "placed",
    "old_timecode",
    "new_timecode",
    "old_onset_s",
    "new_onset_s",
    "residual_ms",
    "likeness",
    "stretch",
    "reason",
)
STRETCH_COLUMNS = (
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


def write_events(path: Path, events: Sequence[Event], found: Sequence[Placed | Lost], *, source: Source) -> None:
    """Write where each event of the old film went; `source` is the new film.

    `new_onset_s` of an event that was not placed is the moment of the new film at which it is missing.
    """
    rows = []
    for event, each in zip(events, found, strict=True):
        if isinstance(each, Placed):
            new_s, residual, stretch, reason = each.new_s, f"{each.residual_ms:z.4f}", str(each.course + 1), ""
        else:
            new_s, residual, stretch, reason = each.near_s, "", "", each.reason.value
        at = [event.timecode, new_timecode(each, source), f"{event.onset_s:.9f}", f"{new_s:.9f}"]
        placed = "yes" if isinstance(each, Placed) else "no"
        rows.append([event.id, placed, *at, residual, f"{each.likeness:z.3f}", stretch, reason])
    _write(path, EVENT_COLUMNS, rows)


def new_timecode(found: Placed | Lost, source: Source) -> str:
    """Return where an event is in the new film, or where it is missing there, as the new film counts."""
    new_s = found.new_s if isinstance(found, Placed) else found.near_s
    sample = samples_from_s(new_s, source.sample_rate_hz)
    return timecode_at(source, min(max(0, sample), source.frames - 1))


def write_stretches(path: Path, courses: Sequence[Course]) -> None:
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
    _write(path, STRETCH_COLUMNS, rows)


def _write(path: Path, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)

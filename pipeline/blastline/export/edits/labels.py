"""Edited label tracks, as Audacity exports them: `start<TAB>end<TAB>text`, in seconds."""

from collections.abc import Iterator
from pathlib import Path

from ...errors import TimelineError
from .row import Cell, Edit, EditedFile
from .text import lines_of

_FREQUENCIES = "\\"
"""Begins the line that follows a label with a selection of frequencies."""


def read_labels(text: str, path: Path) -> EditedFile:
    """Return the events of a label track: each begins where its label does; a label with a length ends its window."""
    return EditedFile(path, tuple(_edits(text, path)), shows_ends=True)


def _edits(text: str, path: Path) -> Iterator[Edit]:
    for line, label in enumerate(lines_of(text), start=1):
        if not label.strip() or label.startswith(_FREQUENCIES):
            continue
        place, cells = f"line {line}", label.split("\t", 2)
        if len(cells) < 2:
            raise TimelineError(f"{path}: {place}: {label[:60]!r}: expected start, end and text, separated by tabs")
        start, stop = Cell(path, place, "start", cells[0]), Cell(path, place, "end", cells[1])
        onset, end = start.seconds(decimal_comma=True), stop.seconds(decimal_comma=True)
        assert onset.seconds is not None
        assert end.seconds is not None
        if end.seconds < onset.seconds:
            raise stop.refused(f"a time from {cells[0].strip()}, where the label starts")
        yield Edit(
            place,
            onset,
            text=cells[2].strip() if len(cells) > 2 else "",
            window_stop=end if end.seconds > onset.seconds else None,
        )

"""The edited table, `timeline.csv`, as spreadsheets and scripts write it."""

from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import get_args

import msgspec

from ...errors import TimelineError
from ...model import Origin
from ..table import COLUMNS
from .row import Cell, Edit, EditedFile, Point
from .text import Grid, Row

ONSETS = ("onset_sample", "onset_s")
_ASIDE = ("timecode", "drive_model")
_MAY_BE_EMPTY = {
    "window_start": {"window_start_sample", "window_start_s"},
    "window_stop": {"window_stop_sample", "window_stop_s"},
    "confidence": {"confidence"},
    "gain_db": {"gain_db"},
}


def read_table(grid: Grid, path: Path) -> EditedFile:
    """Return the events of a table with a header; it has an onset, in samples or seconds, all else may be missing.

    Columns that this version does not know are left aside, with a note.
    """
    header, *rows = grid.rows
    names = header.cells
    for index, name in enumerate(names):
        if name and name in names[:index]:
            raise TimelineError(f"{path}: line {header.line}: two columns are called {name!r}; expected each once")
    if not set(names) & set(ONSETS):
        raise TimelineError(
            f"{path}: line {header.line}: no column onset_sample or onset_s; expected one of them or both, "
            f"found: {', '.join(names)}"
        )
    unknown = [name for name in names if name and name not in COLUMNS]
    notes = (f"not used: column {', '.join(unknown)}",) if unknown else ()
    edits = tuple(_edit(row, names, path, decimal_comma=grid.decimal_comma) for row in rows)
    steps = {"confidence": _step(edit.confidence for edit in edits), "gain_db": _step(edit.gain_db for edit in edits)}
    return EditedFile(path, edits, notes=notes, steps=steps)


def _step(numbers: Iterable[Decimal | None]) -> Decimal:
    """Return the step of a column's longest number: a spreadsheet that shows few digits saves no more."""
    exponents = (number.as_tuple().exponent for number in numbers if number is not None)
    return Decimal(1).scaleb(min((exponent for exponent in exponents if isinstance(exponent, int)), default=0))


def _edit(row: Row, names: Sequence[str], path: Path, *, decimal_comma: bool) -> Edit:
    place = f"line {row.line}"
    if len(row.cells) > len(names) and any(row.cells[len(names) :]):
        raise TimelineError(
            f"{path}: {place}: {len(row.cells)} cells; expected {len(names)}, as many as the header has columns"
        )
    cells = {n: Cell(path, place, n, text) for n, text in zip(names, row.cells, strict=False) if text}
    onset = _point(cells, *ONSETS, decimal_comma=decimal_comma)
    if onset is None:
        unread = "; timecode is not read" if "timecode" in cells else ""
        raise TimelineError(f"{path}: {place}: no onset; expected a time in {' or '.join(ONSETS)}{unread}")
    confidence, gain, origin = cells.get("confidence"), cells.get("gain_db"), cells.get("origin")
    blast_start = cells.get("blast_start_sample")
    return Edit(
        place,
        onset,
        id=cells["id"].text if "id" in cells else None,
        window_start=_point(cells, "window_start_sample", "window_start_s", decimal_comma=decimal_comma),
        window_stop=_point(cells, "window_stop_sample", "window_stop_s", decimal_comma=decimal_comma),
        confidence=confidence.number(decimal_comma=decimal_comma) if confidence else None,
        gain_db=gain.number(decimal_comma=decimal_comma) if gain else None,
        blast_start=blast_start.sample(decimal_comma=decimal_comma) if blast_start else None,
        origin=_origin(origin) if origin else None,
        aside={name: cells[name].text for name in _ASIDE if name in cells},
        emptied=tuple(
            name
            for name, columns in _MAY_BE_EMPTY.items()
            if not columns.isdisjoint(names) and columns.isdisjoint(cells)
        ),
    )


def _point(cells: Mapping[str, Cell], in_samples: str, in_seconds: str, *, decimal_comma: bool) -> Point | None:
    sample, seconds = cells.get(in_samples), cells.get(in_seconds)
    if sample is None:
        return None if seconds is None else seconds.seconds(decimal_comma=decimal_comma)
    index = sample.sample(decimal_comma=decimal_comma)
    if seconds is None:
        return Point(index, said=(sample.said,))
    time = seconds.seconds(decimal_comma=decimal_comma)
    return Point(index, time.seconds, time.step_s, (sample.said, *time.said))


def _origin(cell: Cell) -> Origin:
    try:
        origin: Origin = msgspec.convert(cell.text, Origin)
    except msgspec.ValidationError as error:
        raise cell.refused(f"one of: {', '.join(get_args(Origin))}") from error
    return origin

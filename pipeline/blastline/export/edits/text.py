"""Text files of any tool and system: their lines, their columns."""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

from ...errors import TimelineError

_SEPARATORS = ",;\t"
_SEPARATOR_LINE = re.compile(r"sep=(.)")
_LONGEST_CELL = 100_000


@dataclass(frozen=True)
class Row:
    """The cells of one row and the line that it begins on, counted from 1."""

    line: int
    cells: tuple[str, ...]


@dataclass(frozen=True)
class Grid:
    """A file of separated values; `decimal_comma` says that its numbers may have one."""

    rows: tuple[Row, ...]
    decimal_comma: bool


def lines_of(text: str) -> list[str]:
    """Return the lines of a text; a vertical tab, as Excel writes for a break in a cell, or U+2028 ends none."""
    return re.split(r"\r\n|\r|\n", text)


def separated(text: str, path: Path) -> Grid:
    """Return the rows of a table, without empty ones; its separator is the one that the header has most of.

    Where that is not a comma, numbers may have a decimal comma. Excel's first line `sep=;` is understood. Raises
    TimelineError where the rows cannot be told, or the last was cut off.
    """
    lines = [line + "\n" for line in lines_of(text)]
    skipped = 0
    separator = None
    if lines and (said := _SEPARATOR_LINE.fullmatch(lines[0].strip('\n "'))):
        separator, skipped = said[1], 1
    header = next((line for line in lines[skipped:] if line.strip()), "")
    separator = separator or max(_SEPARATORS, key=header.count)
    reader = csv.reader(lines[skipped:], delimiter=separator, strict=True)
    rows: list[Row] = []
    line = skipped + 1
    try:
        for cells in reader:
            if any(len(cell) > _LONGEST_CELL for cell in cells):
                raise TimelineError(f"{path}: line {line}: a cell is longer than any that a tool writes")
            if any(cell.strip() for cell in cells):
                rows.append(Row(line, tuple(cell.strip() for cell in cells)))
            line = skipped + reader.line_num + 1
    except csv.Error as error:
        raise TimelineError(f"{path}: line {line}: not a row of a table: {error}") from error
    if rows and lines[-1].strip(f'{separator}" \t\n'):
        _refuse_cut_off(rows, path)
    return Grid(tuple(rows), decimal_comma=separator != ",")


def _refuse_cut_off(rows: list[Row], path: Path) -> None:
    """Raise TimelineError where the last row, which no line end follows, is shorter than the header.

    Its last cell may be the first digits of a number.
    """
    header, last = rows[0], rows[-1]
    columns = max((place for place, cell in enumerate(header.cells, start=1) if cell.strip()), default=0)
    if len(last.cells) < columns:
        raise TimelineError(
            f"{path}: line {last.line}: the file ends in it, after {last.cells[-1][:60]!r} in cell "
            f"{len(last.cells)} of {columns}: it was cut off; expected a whole row, or a line end behind it"
        )

"""Tables of numbers that users bring as CSV: named columns, ascending frequencies, `# key: value` notes before them."""

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import RuleError
from ..plurals import counted
from .text import read_utf_8

FREQUENCY = "frequency_hz"


@dataclass(frozen=True, eq=False)
class Columns:
    """What a file holds: one array for each column by its name, all of one length, and the notes by their key."""

    values: dict[str, NDArray[np.float64]]
    notes: dict[str, str]


def read_columns(path: Path, *, needed: Sequence[str], optional: Sequence[str] = ()) -> Columns:
    """Return the columns of a CSV file whose first line names them, in any order; `frequency_hz` is one, and ascends.

    Raises RuleError with one line that names the file, the line, the value and what was expected.
    """
    notes, lines = _lines(path)
    names = [name.strip().lower() for name in lines[0][1]] if lines else []
    header = ", ".join([*needed, *(f"[{name}]" for name in optional)])
    if any(name not in names for name in needed):
        shown = ", ".join(names)[:80] or "nothing"
        raise RuleError(f"{path}: the first line names {shown}; expected the columns {header}")
    known = [name for name in names if name in {*needed, *optional}]
    if len(set(known)) < len(known):
        raise RuleError(f"{path}: the first line names a column twice: {', '.join(names)}")
    places = {name: names.index(name) for name in known}
    rows = [[_number(path, number, cells, names, place) for place in places.values()] for number, cells in lines[1:]]
    if not rows:
        raise RuleError(f"{path}: holds no measurement below its line of names; expected rows of {header}")
    values = dict(zip(places, np.array(rows, dtype=np.float64).T, strict=True))
    _require_ascending(path, values[FREQUENCY], [number for number, _ in lines[1:]])
    return Columns(values, notes)


def _lines(path: Path) -> tuple[dict[str, str], list[tuple[int, list[str]]]]:
    """Return the notes, and the cells of every other line that is not empty with its number."""
    text = read_utf_8(path, kind="a CSV file")
    notes: dict[str, str] = {}
    lines: list[tuple[int, list[str]]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        if line.lstrip().startswith("#"):
            key, _, value = line.lstrip(" #").partition(":")
            notes[key.strip()] = value.strip()
        elif line.strip():
            try:
                lines.append((number, next(csv.reader([line]))))
            except csv.Error as error:
                raise RuleError(f"{path}: line {number}: not a line of a CSV file: {error}") from error
    return notes, lines


def _number(path: Path, line: int, cells: Sequence[str], names: Sequence[str], place: int) -> float:
    if len(cells) != len(names):
        raise RuleError(
            f"{path}: line {line}: {counted(len(cells), 'cell')}; expected {len(names)}, as the first line names"
        )
    try:
        value = float(cells[place])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RuleError(f"{path}: line {line}: {names[place]} = {cells[place].strip()!r}: expected a finite number")
    return value


def _require_ascending(path: Path, frequencies_hz: NDArray[np.float64], lines: Sequence[int]) -> None:
    before = 0.0
    for line, frequency_hz in zip(lines, frequencies_hz.tolist(), strict=True):
        if frequency_hz <= before:
            wanted = f"more than {before:g} Hz, the row before" if before else "more than 0"
            raise RuleError(f"{path}: line {line}: {FREQUENCY} = {frequency_hz:g}: expected {wanted}")
        before = frequency_hz

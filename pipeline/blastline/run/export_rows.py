"""What a timeline can be written as, for tables: on the command line and in the report."""

from collections.abc import Collection
from fnmatch import fnmatchcase

from ..export import FORMATS, HAPTIC_FORMATS, known_formats
from ..report import ExportRow
from . import names


def files_of_results() -> list[str]:
    """Return the names, and patterns of names, of all files that a result may have, but for the tables of `conform`."""
    every = known_formats((*FORMATS, *HAPTIC_FORMATS))
    return [names.DRIVE, names.REPORT, *(name for each in every for name in (*each.files, *each.sets))]


def export_rows(*, written: Collection[str] = ()) -> tuple[ExportRow, ...]:
    """Return every format: its files, the tool that opens them and how, and how exact its times are.

    `written` are the names of files that were written; a format of which none was has the names that they would have.
    """
    rows = []
    for known in known_formats((*FORMATS, *HAPTIC_FORMATS)):
        tool, _, how = known.tool.partition(": ")
        patterns = (*known.files, *known.sets)
        mine = tuple(name for name in written if any(fnmatchcase(name, pattern) for pattern in patterns))
        rows.append(ExportRow(known.name, mine or patterns, tool, how, known.exactness, bool(mine)))
    return tuple(rows)

"""What a timeline can be written as, for tables: on the command line and in the report."""

from collections.abc import Collection

from ..export import FORMATS, resolution
from ..report import ExportRow


def exports(*, written: Collection[str] = ()) -> tuple[ExportRow, ...]:
    """Return every format: its file, the tool that opens it and how, how exact its times are, whether it is written."""
    rows = []
    for known in FORMATS.values():
        tool, _, how = known.tool.partition(": ")
        rows.append(ExportRow(known.name, known.file_name, tool, how, resolution(known.name), known.name in written))
    return tuple(rows)

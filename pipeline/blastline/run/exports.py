"""What a timeline can be written as, for tables: on the command line and in the report."""

from collections.abc import Collection

from ..export import FORMATS, HAPTIC_FORMATS, known_formats, resolution
from ..report import ExportRow


def exports(*, written: Collection[str] = ()) -> tuple[ExportRow, ...]:
    """Return every format: its file, the tool that opens it and how, how exact its times are, whether it is written."""
    rows = []
    for known in known_formats((*FORMATS, *HAPTIC_FORMATS)):
        tool, _, how = known.tool.partition(": ")
        rows.append(ExportRow(known.name, known.files[0], tool, how, resolution(known.name), known.name in written))
    return tuple(rows)

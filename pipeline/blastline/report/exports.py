"""The table of files for other tools: which there are, who opens them, and how."""

from collections.abc import Sequence
from dataclasses import dataclass

from .words import safe


@dataclass(frozen=True)
class ExportRow:
    """A format of the timeline: its name and file, the tool that opens it and how, how exact its times are.

    `written` says whether the file lies beside the report.
    """

    name: str
    file: str
    tool: str
    how: str
    exactness: str
    written: bool


def exports_table(rows: Sequence[ExportRow]) -> str:
    """Return the formats as a table, those that were written first and linked."""
    there = [row for row in rows if row.written]
    others = [row for row in rows if not row.written]
    command = "blastline export timeline.json --format NAME -o FOLDER"
    note = f'<p class="note">Files without a link are made by <code>{command}</code>.</p>' if others else ""
    body = "".join(_row(row) for row in (*there, *others))
    heads = "<th>File</th><th>Name</th><th>For</th><th>How to open it there</th><th>Exact to</th>"
    return f'{note}<div class="card scroll"><table><thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table></div>'


def _row(row: ExportRow) -> str:
    file = f'<a href="{safe(row.file)}">{safe(row.file)}</a>' if row.written else safe(row.file)
    return (
        f'<tr><td>{file}</td><td><code>{safe(row.name)}</code></td><td class="wide">{safe(row.tool)}</td>'
        f'<td class="wide">{safe(row.how)}</td><td class="wide">{safe(row.exactness)}</td></tr>'
    )

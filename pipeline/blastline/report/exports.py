"""The table of files for other tools: which there are, who opens them, and how."""

from collections.abc import Sequence
from dataclasses import dataclass

from .words import safe


@dataclass(frozen=True)
class ExportRow:
    """A format of the timeline: its name and files, the tool that opens them and how, how exact its times are.

    `written` says whether they lie beside the report; where not, `*` in a file's name stands for a number.
    """

    name: str
    files: tuple[str, ...]
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
    files = "<br>".join(f'<a href="{safe(f)}">{safe(f)}</a>' if row.written else safe(f) for f in row.files)
    return (
        f'<tr><td>{files}</td><td><code>{safe(row.name)}</code></td><td class="wide">{safe(row.tool)}</td>'
        f'<td class="wide">{safe(row.how)}</td><td class="wide">{safe(row.exactness)}</td></tr>'
    )

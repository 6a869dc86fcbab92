"""Which tool an edited file comes from, by what is in it, and reading it."""

from dataclasses import replace
from pathlib import Path

from ...errors import TimelineError
from ..kinds import kind_of_text
from ..reading import read_text
from .document import read_document
from .labels import read_labels
from .reaper import is_reaper, read_reaper
from .row import EditedFile, with_common_steps
from .table import ONSETS, read_table
from .text import separated

_EXPECTED = "an edited timeline: timeline.json, timeline.csv, Audacity labels or REAPER's CSV"

_HEADERS = "onset_sample or onset_s, as timeline.csv has, or #,Name,Start,End,Length, as REAPER writes"


def read_edits(path: Path) -> EditedFile:
    """Return the events of an edited timeline: JSON, a table, Audacity's labels, or REAPER's markers and regions.

    An empty label track, and a table with nothing but its header, have no events. Raises TimelineError, in one line
    with the place, the value and what was expected, for anything that is none of them.
    """
    edited = _read(path)
    return replace(edited, edits=with_common_steps(edited.edits))


def _read(path: Path) -> EditedFile:
    text = read_text(path, expected=_EXPECTED)
    if path.suffix.lower() == ".json" or text.lstrip().startswith("{"):
        return read_document(text, path, expected=_EXPECTED)
    is_table = path.suffix.lower() in (".csv", ".tsv")
    if not text.strip():
        if is_table:
            raise TimelineError(f"{path}: line 1: no header; expected {_HEADERS}")
        return EditedFile(path, (), shows_ends=True)
    first = text.lstrip().split("\n", 1)[0].lower()
    if is_table or any(name in first for name in ONSETS) or first.startswith(("#", '"#"', "sep=")):
        grid = separated(text, path)
        if not grid.rows:  # blank cells alone, or nothing after `sep=;`
            raise TimelineError(f"{path}: line 1: no header; expected {_HEADERS}")
        header = grid.rows[0].cells
        if is_reaper(header):
            return read_reaper(grid, path)
        if not set(header) & set(ONSETS) and header[0] != "id":
            raise TimelineError(f"{path}: line {grid.rows[0].line}: not a header of a timeline; expected {_HEADERS}")
        return read_table(grid, path)
    if kind := kind_of_text(text):
        raise TimelineError(f"{path}: {kind}; expected {_EXPECTED}")
    return read_labels(text, path)

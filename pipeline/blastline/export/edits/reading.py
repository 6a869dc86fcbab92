"""Which tool an edited file comes from, by what is in it, and reading it."""

from dataclasses import replace
from pathlib import Path

from ...errors import TimelineError
from ..kinds import begins_as_labels, kind_of_text
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
    """Return the events of a file as what it holds; its name counts only where that tells nothing."""
    text = read_text(path, expected=_EXPECTED)
    suffix = path.suffix.lower()
    if text.lstrip().startswith(("{", "[{")):
        return read_document(text, path, expected=_EXPECTED)
    if _begins_as_table(text):
        return _read_grid(text, path)
    if kind := kind_of_text(text):
        raise TimelineError(f"{path}: {kind}; expected {_EXPECTED}")
    if begins_as_labels(text):
        return read_labels(text, path)
    if suffix == ".json":
        return read_document(text, path, expected=_EXPECTED)
    if suffix in (".csv", ".tsv"):
        return _read_grid(text, path)
    return read_labels(text, path)


def _begins_as_table(text: str) -> bool:
    first = text.lstrip().split("\n", 1)[0].lower()
    return any(name in first for name in ONSETS) or first.startswith(("#", '"#"', "sep="))


def _read_grid(text: str, path: Path) -> EditedFile:
    """Return the events of a table, by its header: REAPER's, or one like `timeline.csv`."""
    grid = separated(text, path)
    if not grid.rows:  # nothing, blank cells alone, or nothing after `sep=;`
        raise TimelineError(f"{path}: line 1: no header; expected {_HEADERS}")
    header = grid.rows[0].cells
    if is_reaper(header):
        return read_reaper(grid, path)
    if not set(header) & set(ONSETS) and header[0] != "id":
        raise TimelineError(f"{path}: line {grid.rows[0].line}: not a header of a timeline; expected {_HEADERS}")
    return read_table(grid, path)

"""The timeline as files: a writer for each tool that opens it, a reader of `timeline.json`; `edits` reads them back."""

from .formats import FORMATS, Format, export_timeline, known_formats
from .reading import read_timeline

__all__ = ["FORMATS", "Format", "export_timeline", "known_formats", "read_timeline"]

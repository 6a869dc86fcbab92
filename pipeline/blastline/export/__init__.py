"""The timeline as files: one writer for each tool that opens it, and the reader of `timeline.json`."""

from .formats import FORMATS, Format, export_timeline, known_formats
from .frames import require_frame_rate
from .reading import read_timeline
from .rounding import resolution, rounding

__all__ = [
    "FORMATS",
    "Format",
    "export_timeline",
    "known_formats",
    "read_timeline",
    "require_frame_rate",
    "resolution",
    "rounding",
]

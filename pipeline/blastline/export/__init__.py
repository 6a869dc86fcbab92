"""The timeline as files: a writer for each tool that opens it, a reader of `timeline.json`; `edits` reads them back."""

from .formats import FORMATS, Format, export_timeline, known_formats, needs_drive
from .frames import require_frame_rate, require_late_enough
from .haptics import HAPTIC_FORMATS, DriveReader, HapticFormat, HapticTrack, Rounding, haptic_track
from .reading import read_timeline
from .rounding import rounding

__all__ = [
    "FORMATS",
    "HAPTIC_FORMATS",
    "DriveReader",
    "Format",
    "HapticFormat",
    "HapticTrack",
    "Rounding",
    "export_timeline",
    "haptic_track",
    "known_formats",
    "needs_drive",
    "read_timeline",
    "require_frame_rate",
    "require_late_enough",
    "rounding",
]

"""Sound in and out: the only stage that opens media.

`open_soundtrack` decodes one track of an audio file or a film, once, and cuts exact samples from it afterwards;
`write_drive` writes the finished drive; `timecode_at` names the picture that shows while a sample plays.
"""

from ..timecode import timecode_at
from .bwf import Cue
from .mix import as_front, heard_mix
from .opening import open_soundtrack
from .reader import Soundtrack
from .writer import write_drive, write_excerpt

__all__ = [
    "Cue",
    "Soundtrack",
    "as_front",
    "heard_mix",
    "open_soundtrack",
    "timecode_at",
    "write_drive",
    "write_excerpt",
]

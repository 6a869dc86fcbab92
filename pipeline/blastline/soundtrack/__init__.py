"""Sound in and out: the only stage that opens media.

`open_soundtrack` decodes one track of an audio file or a film, once, and reads exact samples of it again afterwards;
`write_drive` writes the finished drive, whose markers `written_cues` tells.
"""

from .bwf import Cue, written_cues
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
    "write_drive",
    "write_excerpt",
    "written_cues",
]

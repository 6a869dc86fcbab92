"""The haptic formats: the drive as breakpoints, for the players of vibration.

drive.wav + timeline ─► pulses and segments (`haptic_track`) ─► reduced to breakpoints ─► .ahap | .haptic | .hjif
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from .ahap import CONTINUOUS, TRANSIENTS, write_ahap
from .hjif import FILE, write_hjif
from .making import haptic_track
from .meta import INDEX, REELS, write_haptic
from .rounding import Rounding
from .track import DriveReader, HapticTrack, Pulse, VibrationSegment


@dataclass(frozen=True)
class HapticFormat:
    """A format that is written from the drive: its name on the command line, its files, the tools that open it.

    `exactness` is how exactly it holds the time of an event, in words. `sets` are patterns of further files, of which
    there are more the longer the film is.
    """

    name: str
    files: tuple[str, ...]
    tool: str
    write: Callable[[HapticTrack, Path], Rounding]
    exactness: str
    sets: tuple[str, ...] = ()


_ALL = (
    HapticFormat(
        "ahap",
        (CONTINUOUS, TRANSIENTS),
        "Core Haptics on iPhone and iPad: load the two patterns and start them together",
        write_ahap,
        "0.0005 ms: six decimals of a second",
    ),
    HapticFormat(
        "haptic",
        (INDEX,),
        "Meta Haptics Studio, FMOD, Wwise, Unity, Unreal: import the reels, each placed where the index says",
        write_haptic,
        "0.031 ms: 32-bit seconds, in reels",
        (REELS,),
    ),
    HapticFormat(
        "hjif",
        (FILE,),
        "MPEG haptics encoders and players: open it as an HJIF file",
        write_hjif,
        "0.5 ms: whole milliseconds",
    ),
)

HAPTIC_FORMATS: Mapping[str, HapticFormat] = MappingProxyType({known.name: known for known in _ALL})

__all__ = [
    "HAPTIC_FORMATS",
    "DriveReader",
    "HapticFormat",
    "HapticTrack",
    "Pulse",
    "Rounding",
    "VibrationSegment",
    "haptic_track",
]

"""What FFmpeg's probe tells of a file, and what it does not: when a stream starts of which it saw no packet.

The probe reads 5 MB or 5 s. To a stream that has none there, FFmpeg gives the start and the length of the whole file:

file     [sound][sound] ... [sound] | [sound][picture][sound][picture] ...
probe    <------------------------->           ^ where the picture starts; told is 0, where the file does
"""

from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .track import TrackFacts

if TYPE_CHECKING:
    from av.container import InputContainer
    from av.packet import Packet
    from av.stream import Stream

_UNTOLD = frozenset({"matroska,webm", "nut"})
"""Formats that say neither start nor length of a stream: one that has a length has it from the file, or by a guess."""

_SIZED = frozenset({"mpegts", "mpeg"})
"""Formats in which pictures tell their size themselves: one without has not been seen, and its start is the file's."""

_SOUGHT_S = 600
"""So much of a film is read for its picture's first packet, 1/12 of two hours, where there is none for so long.

Pictures later than their sound are late by a leader or an overture, which end before. What it costs is reading: 50 MB
with one track of compressed sound, 700 MB with one of 7.1 at 24 bits.
"""


def opened(path: Path, options: dict[str, str] | None = None) -> "InputContainer":
    """Return a file open in FFmpeg, with the options given. Raises FFmpegError where it is no media."""
    import av

    # PyAV 18 refuses a film of which a tag is no UTF-8; 19 never does, and takes no word about it any more
    tags: Any = {"metadata_errors": "replace"} if int(av.__version__.partition(".")[0]) < 19 else {}
    # an absolute path, because FFmpeg takes what comes before a colon for a protocol
    container: InputContainer = av.open(str(path.resolve()), options=options or {}, **tags)
    return container


def told_start(stream: "Stream") -> Fraction | None:
    """Return when a stream starts as FFmpeg tells it, in seconds; None where it does not, or did not see its start."""
    if is_unseen(stream) or stream.start_time is None or not stream.time_base:
        return None
    return Fraction(stream.start_time * stream.time_base)


def told_duration(stream: "Stream") -> Fraction | None:
    """Return how long a stream is as FFmpeg tells it, in seconds; None where it does not, or has it from the file's."""
    if stream.container.format.name in _UNTOLD or not stream.duration or not stream.time_base:
        return None
    return Fraction(stream.duration * stream.time_base)


def start_of(stream: "Stream") -> Fraction | None:
    """Return when a stream starts, in seconds, by its first packet where the probe did not see it; None if unknown."""
    return _sought_start(stream) if is_unseen(stream) else told_start(stream)


def picture_warnings(facts: TrackFacts) -> list[str]:
    """Return the line for the user where a film has a track of pictures, but the first of them was not found."""
    if not facts.is_picture_missing:
        return []
    sought = f"its picture has no frame in the first {_SOUGHT_S // 60} minutes of the file"
    return [f"{sought}: times are counted as if it began with the sound"]


def is_unseen(stream: "Stream") -> bool:
    """Return whether the probe may have met no packet of a stream, so that its start, if it has one, is the file's."""
    from av.video.stream import VideoStream

    if stream.container.format.name in _SIZED:
        return isinstance(stream, VideoStream) and not stream.width
    return stream.container.format.name in _UNTOLD and (stream.start_time is None or bool(stream.duration))


def _sought_start(stream: "Stream") -> Fraction | None:
    """Return when the first packet of a stream plays, None where there is none in the first `_SOUGHT_S` of the file.

    The file is opened a second time, so that nobody's place in it moves.
    """
    from av.error import FFmpegError

    begin: Fraction | None = None
    try:
        with opened(Path(stream.container.name)) as container:
            for packet in container.demux():
                time = _time(packet)
                if not packet.size or time is None:
                    continue
                if packet.stream_index == stream.index:
                    return time
                begin = time if begin is None else begin
                if time - begin > _SOUGHT_S:
                    return None
    except (FFmpegError, IndexError):  # damage, told where it is decoded; the second: see decode.py
        return None
    return None


def _time(packet: "Packet[Stream]") -> Fraction | None:
    stamp = packet.dts if packet.pts is None else packet.pts
    return None if stamp is None or not packet.time_base else Fraction(stamp * packet.time_base)

"""What a film says about a sound stream before it is decoded: when it starts, how long it is, its timecode."""

import re
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from ..plurals import counted
from ..timecode import SHAPE, clock, standard_rate
from .decode import Tally
from .layouts import ChannelNames, named
from .matroska import stores_duration
from .probe import is_unseen, start_of, told_duration, told_start
from .track import Length, TrackFacts, time_stamp
from .xing import counts_its_frames

if TYPE_CHECKING:
    from av import AudioFrame
    from av.audio.stream import AudioStream
    from av.container import InputContainer
    from av.video.stream import VideoStream

_TIME_STAMP = re.compile(r"\d{1,20}", re.ASCII)  # no more digits than a number of 64 bits
_FASTEST_PICTURES = 1000  # a second
_AVERAGE_OFF = Fraction(1, 200)  # so much less than the rate the average of a fragmented film may be
UNSTAMPED = frozenset({"aac", "ac3", "dts", "dtshd", "eac3", "loas", "mlp", "truehd"})
"""Formats without time stamps: FFmpeg counts what it finds."""
_ESTIMATED = UNSTAMPED | {"mpeg", "mpegts"}
"""Formats that declare no length: FFmpeg guesses one from the size of the file."""
_OF_ALL = frozenset({"asf", "flv"})
"""Formats whose streams have the length of the file."""


def origin_of(first: "AudioFrame", stream: "AudioStream", tally: Tally) -> Fraction | None:
    """Return when sample 0 plays, in seconds: with the first frame, or earlier where what came before it was lost."""
    time = None if first.pts is None or not first.time_base else Fraction(first.pts * first.time_base)
    codec = stream.codec_context.codec
    if time is None or tally.first_time is None or not (tally.failed or (codec.lossless and not codec.lossy)):
        return time
    declared = told_start(stream)
    return min(time, tally.first_time if declared is None else max(tally.first_time, declared))


def sound_streams(container: "InputContainer", names: ChannelNames) -> list[str]:
    """Return the sound streams of a file in words, each with its number."""
    return [f"{place} ({_description(stream, names)})" for place, stream in enumerate(container.streams.audio)]


def title_of(stream: "AudioStream") -> str | None:
    """Return what a stream is called, None where it has no name; MP4 and MOV have it under another key than others."""
    return stream.metadata.get("title") or stream.metadata.get("name")


def film_facts(
    container: "InputContainer",
    stream: "AudioStream",
    first: "AudioFrame",
    origin: Fraction | None,
    names: ChannelNames,
    *,
    is_cut: bool,
) -> TrackFacts:
    """Return what container, stream and first frame tell; `origin` is when sample 0 plays.

    `is_cut` tells that the file stops before its own end.
    """
    picture = next((v for v in container.streams.video if not _is_cover(v)), None)
    declared, length = _declared(
        container, stream, first.sample_rate, origin or Fraction(0), is_cut=is_cut, has_picture=picture is not None
    )
    picture_start = None if picture is None else start_of(picture)
    offset_s = _offset(picture_start, origin)
    unsure_s = abs(offset_s) if length == "shared" else _unsure_s(container, origin)
    stamp = time_stamp(_time_reference(container), first.sample_rate)
    timecode = _start_timecode(container)
    if timecode is None and stamp.believed is not None:
        timecode = clock(stamp.believed, first.sample_rate, decimals=6)
    index, streams = container.streams.audio.index(stream), sound_streams(container, names)
    return TrackFacts(
        rate_hz=first.sample_rate,
        channels=first.layout.nb_channels,
        layout=named(first, names[stream.index]),
        declared_frames=declared,
        length=length,
        unsure_frames=int(unsure_s * first.sample_rate),
        breaks_off=is_cut and container.format.name == "matroska,webm",
        stream=index,
        is_pcm=_is_pcm(stream),
        start_timecode=timecode,
        has_picture=picture is not None,
        frame_rate=None if picture is None else _frame_rate(picture),
        start_offset_s=float(offset_s),
        is_picture_missing=picture is not None and is_unseen(picture) and picture_start is None,
        ignored_reference=stamp.ignored,
        guessed_s=container.duration / 1_000_000 if container.duration else None,
        beside=(*streams[:index], *streams[index + 1 :]),
    )


def header_frames(container: "InputContainer", stream: "AudioStream", rate_hz: int) -> int | None:
    """Return the frames that the header of a stream in AVI declares, None where it does not, and for other formats.

    Of a file that is cut, FFmpeg tells the length of what is left instead.
    """
    if container.format.name != "avi" or not stream.frames or not stream.time_base:
        return None
    return int(stream.frames * stream.time_base * rate_hz)


def _offset(picture_start: Fraction | None, origin: Fraction | None) -> Fraction:
    """Return how much later than the picture sample 0 plays, in seconds; 0 where either does not say."""
    return Fraction(0) if picture_start is None or origin is None else origin - picture_start


def _unsure_s(container: "InputContainer", origin: Fraction | None) -> Fraction:
    """Return how much of a stream's length may be time before its sound: FFmpeg counts an edit of an MP4 that is empty,
    unless the whole track is played behind it.
    """
    return max(origin or Fraction(0), Fraction(0)) if _is_mp4(container) else Fraction(0)


def _is_mp4(container: "InputContainer") -> bool:
    return "mp4" in container.format.name.split(",")


def _description(stream: "AudioStream", names: ChannelNames) -> str:
    if stream.codec_context is None:
        return "a format that cannot be decoded"
    words = [stream.codec_context.name, counted(len(names[stream.index]), "channel")]
    tags = [tag for tag in (stream.metadata.get("language"), title_of(stream)) if tag]
    return ", ".join(words + [tag.encode("utf-8", "surrogateescape").decode("utf-8", "replace") for tag in tags])


def _is_cover(stream: "VideoStream") -> bool:
    from av.stream import Disposition

    return bool(stream.disposition & Disposition.attached_pic)


def _start_timecode(container: "InputContainer") -> str | None:
    """Return the timecode of the first picture, as HH:MM:SS:FF or, counting drop-frame, HH:MM:SS;FF."""
    tags = [stream.metadata for stream in (*container.streams.video, *container.streams.data)]
    for metadata in (*tags, container.metadata):
        match = SHAPE.fullmatch(metadata.get("timecode") or metadata.get("TIMECODE", ""))
        if match:
            seconds, mark, frame = match.groups()
            return f"{seconds}{':' if mark == ':' else ';'}{frame}"
    return None


def _time_reference(container: "InputContainer") -> int | None:
    """Return the samples after midnight that a broadcast WAV says; Matroska keeps its tags in capitals."""
    tag = container.metadata.get("time_reference") or container.metadata.get("TIME_REFERENCE", "")
    return int(tag) if _TIME_STAMP.fullmatch(tag) else None


def _frame_rate(picture: "VideoStream") -> str | None:
    """Return the rate as a fraction; measured rates are a little off and are taken for the one they are meant to be."""
    measured = picture.average_rate or picture.guessed_rate
    if not measured or measured > _FASTEST_PICTURES:  # the clock of a picture of which the probe saw nothing
        return None
    rate, guessed = Fraction(measured), Fraction(picture.guessed_rate or measured)
    meant = guessed if abs(guessed - rate) < _AVERAGE_OFF * rate else rate
    return str(standard_rate(rate) or standard_rate(meant) or rate)


def _declared(
    container: "InputContainer",
    stream: "AudioStream",
    rate_hz: int,
    origin: Fraction,
    *,
    is_cut: bool,
    has_picture: bool,
) -> tuple[int | None, Length]:
    """Return how many frames the container says the stream has, None where it does not say, and how it says so."""
    in_header = header_frames(container, stream, rate_hz)
    if in_header is not None and (is_cut or _is_pcm(stream)):
        return in_header, "counted" if _is_pcm(stream) else "packets"
    if container.format.name in _ESTIMATED or _is_guessed(container):
        return None, "rounded"
    own: Length = "rounded" if in_header is None else "packets"
    if _is_pcm(stream) and (container.format.name == "mxf" or _is_mp4(container)):
        own = "counted"
    of_all: Length = "shared" if has_picture else own
    duration = told_duration(stream)
    if duration is not None:
        return int(duration * rate_hz), of_all if container.format.name in _OF_ALL else own
    end = _tagged(stream)
    length = own if end is not None else of_all
    if end is None and container.duration and not _is_guessed_whole(container):
        end = Fraction(container.duration, 1_000_000)
    return None if end is None else max(0, int((end - max(origin, Fraction(0))) * rate_hz)), length


def _is_guessed(container: "InputContainer") -> bool:
    """Return whether the length of a stream is FFmpeg's guess, from the size of the file."""
    return container.format.name == "mp3" and not counts_its_frames(Path(container.name))


def _is_guessed_whole(container: "InputContainer") -> bool:
    """Return whether the length of a file is FFmpeg's guess, from its size."""
    return container.format.name == "matroska,webm" and not stores_duration(Path(container.name))


def _is_pcm(stream: "AudioStream") -> bool:
    return stream.codec_context.name.startswith("pcm_")


def _tagged(stream: "AudioStream") -> Fraction | None:
    """Return when a stream ends, in seconds, as a tag of Matroska says, None where there is none."""
    tag = stream.metadata.get("DURATION", "")
    if not re.fullmatch(r"\d+:\d\d:\d\d(\.\d+)?", tag):
        return None
    hours, minutes, seconds = tag.split(":")
    return 3600 * int(hours) + 60 * int(minutes) + Fraction(seconds)

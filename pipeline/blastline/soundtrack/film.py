"""Films and compressed sound through PyAV: which stream, when it starts, and its samples in one sequential pass."""

import re
from collections.abc import Iterator
from fractions import Fraction
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import SoundtrackError
from ..timecode import clock, standard_rate
from .chunks import ChunkTable
from .decode import Tally, decoded, packed
from .placement import Placement
from .track import Samples, TrackFacts

if TYPE_CHECKING:
    from av import AudioFrame
    from av.audio.stream import AudioStream
    from av.container import InputContainer
    from av.video.stream import VideoStream

_TIMECODE = re.compile(r"(\d\d:\d\d:\d\d)([:;.,])(\d\d\d?)")
_ESTIMATED = frozenset({"aac", "ac3", "dts", "dtshd", "eac3", "loas", "mlp", "mpeg", "mpegts", "truehd"})
"""Formats that declare no length: FFmpeg guesses one from the size of the file."""

_MAX_UNDECLARED_S = 24 * 3600
_SLACK_S = 10


class FilmTrack:
    """One sound stream of a file, decoded from its first packet to its last."""

    def __init__(self, container: "InputContainer", stream: "AudioStream", table: ChunkTable | None) -> None:
        """Take over an open container and decode the first frame, which says what the sound really is."""
        self._container, self._stream = container, stream
        self._tally = Tally()
        self._frames = decoded(container, stream, self._tally)
        first = next(self._frames, None)
        if first is None:
            self._tally.require_readable()
            raise SoundtrackError("no sound could be decoded")
        self._first = first
        self._origin = _origin(first, stream, self._tally)
        self.facts = _facts(container, stream, first, self._origin)
        rate_hz, declared = self.facts.rate_hz, self.facts.declared_frames
        longest = _MAX_UNDECLARED_S * rate_hz if declared is None else declared + _SLACK_S * rate_hz
        self._placement: Placement[AudioFrame] = Placement(rate_hz, longest, self._origin)
        self._table = table

    def pieces(self) -> Iterator[Samples]:
        """Yield all samples in order, shape (frames, channels). Raises SoundtrackError where too much is damaged."""
        placed = self._placement.place(chain([self._first], self._frames))
        yield from packed(placed, rate_hz=self.facts.rate_hz, channels=self.facts.channels)
        self._tally.require_readable()

    def near(self, start_s: float, frames: int) -> Iterator[Samples]:
        """Yield at least so many samples, if there are, from about that time on.

        The track cannot be decoded as a whole afterwards. Raises SoundtrackError where no place in it can be found.
        """
        from av.error import FFmpegError

        stream, base = self._stream, Fraction(self._stream.time_base or Fraction(1, 1_000_000))
        start = (stream.start_time or 0) + round(Fraction(start_s) / base)
        try:
            self._container.seek(start, stream=stream)
        except FFmpegError as error:
            raise SoundtrackError(f"cannot be read from {start_s:.0f} s on: {error.strerror}") from error
        heard, left = decoded(self._container, stream, Tally(), earliest_s=start * base), frames
        for samples in packed(heard, rate_hz=self.facts.rate_hz, channels=self.facts.channels):
            yield samples
            left -= samples.shape[0]
            if left <= 0:
                return

    def warnings(self) -> list[str]:
        """Return what was damaged, filled or overruled, one line each."""
        tally, rate_hz = self._tally, self.facts.rate_hz
        lines = []
        if tally.failed:
            packets = f"{tally.failed} of {tally.packets} packets of sound"
            lines.append(f"{packets} could not be decoded ({tally.last_error})")
        if gaps := self._placement.gaps:
            total_s, first_s = sum(gap for _, gap in gaps) / rate_hz, gaps[0][0] / rate_hz
            count = "1 gap was" if len(gaps) == 1 else f"{len(gaps)} gaps were"
            lines.append(f"{count} filled with silence, {total_s:.3f} s in all, first at {first_s:.3f} s")
        for position, jump in self._placement.jumps:
            lines.append(
                f"the time stamps jump by {jump / rate_hz:+.3f} s at {position / rate_hz:.3f} s; "
                "the sound was kept in one piece, so what follows may play beside its picture"
            )
        if self._table is not None and self._table.data_bytes == 0:
            lines.append("the header was never finished; the sound was read to the end of the file")
        elif self._table is not None and (self._table.data_bytes or 0) > self._table.present_bytes:
            declared, present = self._table.data_bytes, self._table.present_bytes
            lines.append(f"the header declares {declared} bytes of sound but {present} follow: the end is missing")
        if tally.stopped:
            lines.append(f"reading stopped early: {tally.stopped}")
        return lines

    def close(self) -> None:
        """Close the file."""
        self._frames.close()
        self._container.close()


def open_film(path: Path, *, stream: int | None, table: ChunkTable | None = None) -> FilmTrack:
    """Open one sound stream, the default or first one where `stream` is None; `table` is what a WAV header declares.

    Raises SoundtrackError where the file is not media, has no such stream, or nothing can be decoded.
    """
    import av
    from av.error import FFmpegError

    try:
        # an absolute path, because FFmpeg takes what comes before a colon for a protocol
        container = av.open(str(path.resolve()), metadata_errors="replace")
    except FFmpegError as error:
        raise SoundtrackError(f"is not a sound file or film that can be read: {error.strerror}") from error
    try:
        return FilmTrack(container, _chosen(container, stream), table)
    except BaseException:
        container.close()
        raise


def _chosen(container: "InputContainer", index: int | None) -> "AudioStream":
    from av.stream import Disposition

    streams = container.streams.audio
    if not streams:
        raise SoundtrackError("has no sound stream")
    if index is None:
        stream = next((s for s in streams if s.disposition & Disposition.default), streams[0])
    elif 0 <= index < len(streams):
        stream = streams[index]
    else:
        there = "; ".join(f"{place} ({_description(s)})" for place, s in enumerate(streams))
        raise SoundtrackError(f"has no sound stream {index}; it has {there}")
    if stream.codec_context is None:
        raise SoundtrackError(f"sound stream {streams.index(stream)} is in a format that cannot be decoded")
    return stream


def _description(stream: "AudioStream") -> str:
    if stream.codec_context is None:
        return "a format that cannot be decoded"
    channels = stream.codec_context.channels
    words = [stream.codec_context.name, f"{channels} channel{'s' if channels != 1 else ''}"]
    return ", ".join(words + [tag for key in ("language", "title") if (tag := stream.metadata.get(key))])


def _origin(first: "AudioFrame", stream: "AudioStream", tally: Tally) -> Fraction | None:
    """Return when sample 0 plays, in seconds: with the first frame, or earlier where what came before it was lost."""
    time = None if first.pts is None or not first.time_base else Fraction(first.pts * first.time_base)
    codec = stream.codec_context.codec
    if time is None or tally.first_time is None or not (tally.failed or (codec.lossless and not codec.lossy)):
        return time
    declared = Fraction((stream.start_time or 0) * (stream.time_base or 0))
    return min(time, max(tally.first_time, declared))


def _facts(
    container: "InputContainer", stream: "AudioStream", first: "AudioFrame", origin: Fraction | None
) -> TrackFacts:
    names = tuple(channel.name for channel in first.layout.channels)
    picture = next((v for v in container.streams.video if not _is_cover(v)), None)
    offset = Fraction(0)
    if picture is not None and picture.start_time is not None and picture.time_base and origin is not None:
        offset = origin - picture.start_time * picture.time_base
    tag = container.metadata.get("time_reference", "")
    reference = int(tag) if tag.isdecimal() else None
    timecode = _start_timecode(container)
    if timecode is None and reference is not None:
        timecode = clock(reference, first.sample_rate, decimals=6)
    return TrackFacts(
        rate_hz=first.sample_rate,
        channels=len(names),
        layout=names if len(set(names)) == len(names) and "NONE" not in names else None,
        declared_frames=_declared_frames(container, stream, first.sample_rate, origin or Fraction(0)),
        stream=container.streams.audio.index(stream),
        start_timecode=timecode,
        frame_rate=None if picture is None else _frame_rate(picture),
        start_offset_s=float(offset),
        time_reference=reference,
        guessed_s=container.duration / 1_000_000 if container.duration else None,
    )


def _is_cover(stream: "VideoStream") -> bool:
    from av.stream import Disposition

    return bool(stream.disposition & Disposition.attached_pic)


def _start_timecode(container: "InputContainer") -> str | None:
    """Return the timecode of the first picture, as HH:MM:SS:FF or, counting drop-frame, HH:MM:SS;FF."""
    tags = [stream.metadata for stream in (*container.streams.video, *container.streams.data)]
    for metadata in (*tags, container.metadata):
        match = _TIMECODE.fullmatch(metadata.get("timecode") or metadata.get("TIMECODE", ""))
        if match:
            clock, mark, frame = match.groups()
            return f"{clock}{':' if mark == ':' else ';'}{frame}"
    return None


def _frame_rate(picture: "VideoStream") -> str | None:
    """Return the rate as a fraction; measured rates are a little off and are taken for the one they are meant to be."""
    measured = picture.average_rate or picture.guessed_rate
    if not measured:
        return None
    rate = Fraction(measured)
    return str(standard_rate(rate) or rate)


def _declared_frames(container: "InputContainer", stream: "AudioStream", rate_hz: int, origin: Fraction) -> int | None:
    """Return how many frames the container says the stream has, None where it does not say."""
    if container.format.name in _ESTIMATED:
        return None
    if stream.duration and stream.time_base:
        return int(stream.duration * stream.time_base * rate_hz)
    tag = stream.metadata.get("DURATION", "")
    if re.fullmatch(r"\d+:\d\d:\d\d(\.\d+)?", tag):
        hours, minutes, seconds = tag.split(":")
        end = 3600 * int(hours) + 60 * int(minutes) + Fraction(seconds)
    elif container.duration:
        end = Fraction(container.duration, 1_000_000)
    else:
        return None
    return max(0, int((end - max(origin, Fraction(0))) * rate_hz))

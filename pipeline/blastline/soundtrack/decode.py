"""From packets to packed float samples: damage is counted and stepped over, never hidden.

Samples are converted, never resampled; planar sound is packed by FFmpeg first, because PyAV cannot read eight planes.
"""

from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from ..errors import SoundtrackError
from ..plurals import counted
from .layouts import keep_list
from .reach import Reach
from .stamped import Gap, Overlap
from .track import PIECE, Samples

if TYPE_CHECKING:
    from av import AudioFrame, AudioResampler, FFmpegError, Packet
    from av.audio.stream import AudioStream
    from av.container import InputContainer

MAX_FAILED_SHARE = 0.1
_HOPELESS = 500  # packets without a single sample

_RESYNC_BYTES, _LEAST_RETRIES = 65_536, 16
"""A demuxer that has found no packet in so many bytes gives up, and goes on behind them if it is asked again: over all
damage that a file of a size can hold, in so many times and a few more."""

_CHECKSUMMED = frozenset({"ac3", "eac3", "flac", "tta", "wavpack"})
"""Codecs whose frames carry a checksum that FFmpeg compares only when it is asked to."""


@dataclass
class Tally:
    """What happened to the packets: how many there were, how many failed, where they lie, where reading stopped early.

    A packet fails where it cannot be decoded, or only to sound that is known to be wrong. `resumed` counts how often
    reading broke off and went on behind the damage. Times are time stamps.
    """

    packets: int = 0
    failed: int = 0
    frames: int = 0
    first_time: Fraction | None = None
    first_failed_time: Fraction | None = None
    last_error: str = ""
    stopped: str = ""
    resumed: int = 0
    reach: Reach = field(default_factory=Reach)

    def fail(self, reason: str, time_s: Fraction | None) -> None:
        """Count one more failure, at most one for each packet."""
        # what fails in emptying the decoder at the end is no packet of its own
        self.failed = min(self.failed + 1, self.packets)
        self.last_error = reason
        if self.first_failed_time is None:
            self.first_failed_time = time_s

    def require_readable(self) -> None:
        """Raise SoundtrackError where too much failed for the rest to be trusted."""
        if self.failed > max(1, MAX_FAILED_SHARE * self.packets) or (self.failed and not self.frames):
            first_s, failed_s = self.first_time, self.first_failed_time
            place = "" if first_s is None or failed_s is None else f", first at {float(failed_s - first_s):.3f} s"
            raise SoundtrackError(
                f"{self.failed} of {self.packets} packets of sound cannot be decoded ({self.last_error}){place}; "
                f"expected no more than {MAX_FAILED_SHARE:.0%}"
            )


def decoded(
    container: "InputContainer", stream: "AudioStream", tally: Tally, *, earliest_s: Fraction | None = None
) -> Generator["AudioFrame", None, None]:
    """Yield the frames of a stream in order, stepping over packets that fail, and over those before `earliest_s`.

    A frame with a wrong checksum would be noise, and noise is easily a shot: it is lost, as one that cannot be decoded.
    Raises SoundtrackError where hundreds of packets give no sound at all.
    """
    for packet in _packets(container, stream, tally):
        if packet.size:  # the last one is empty and only empties the decoder
            if earliest_s is not None and (time_s := _time(packet)) is not None and time_s < earliest_s:
                continue
            if not tally.packets:
                tally.first_time = _time(packet)
            tally.packets += 1
            tally.reach.note(packet.pos, packet.size)
        for frame in _frames(packet, tally):
            tally.frames += 1
            yield frame
        if tally.packets >= _HOPELESS and not tally.frames:
            tally.require_readable()


def _time(packet: "Packet[AudioStream]") -> Fraction | None:
    """Return a packet's time stamp in seconds; to ask each for it costs a twentieth of decoding."""
    return None if packet.pts is None or not packet.time_base else Fraction(packet.pts * packet.time_base)


def _packets(container: "InputContainer", stream: "AudioStream", tally: Tally) -> Iterator["Packet[AudioStream]"]:
    """Yield the packets of a stream; where damage breaks reading off, it goes on behind. A disk that fails ends it."""
    from av.error import FFmpegError, InvalidDataError

    retries = _LEAST_RETRIES + container.size // _RESYNC_BYTES
    packets, behind = container.demux(stream), 0
    while True:
        try:
            packet = next(packets, None)
        except FFmpegError as error:
            tally.stopped, behind = _reason(error), 0
            if not retries or not isinstance(error, InvalidDataError | BlockingIOError):
                return
            retries -= 1
            packets = container.demux(stream)
            continue
        except IndexError:  # PyAV stumbles at the end over streams that began on the way, behind this one's last packet
            return
        if packet is None:
            return
        behind += bool(packet.size)
        if tally.stopped and behind > 1:  # one may have been waiting for its end since before
            tally.stopped, tally.resumed = "", tally.resumed + 1
        yield packet


def _reason(error: "FFmpegError") -> str:
    """Return why reading broke off; what the system calls busy is, of a file, a stretch without any packet."""
    return "damage" if isinstance(error, BlockingIOError) else str(error.strerror)


def set_up_decoder(stream: "AudioStream") -> None:
    """Have the decoder of a stream refuse frames whose checksum is wrong, and cut nothing off ALAC in a CAF.

    Only before the first frame is decoded. The last packet of ALAC is as short as its sound; what it lacks of a whole
    one, which a CAF tells, FFmpeg takes off again.
    """
    if stream.codec_context.codec.name in _CHECKSUMMED:
        stream.codec_context.options = {"err_detect": "crccheck+explode"}
    elif (stream.container.format.name, stream.codec_context.codec.name) == ("caf", "alac"):
        stream.codec_context.options = {"flags2": "+skip_manual"}


def _frames(packet: "Packet[AudioStream]", tally: Tally) -> list["AudioFrame"]:
    from av.error import FFmpegError

    try:
        frames = packet.decode()
    except FFmpegError as error:
        tally.fail(str(error.strerror), _time(packet))
        return []
    except ValueError as error:  # so PyAV from 19 on tells a codec that is unknown or has not been opened
        tally.fail(str(error), _time(packet))
        return []
    for frame in frames:
        keep_list(frame)
    sound = [frame for frame in frames if not frame.is_corrupt]
    if len(sound) < len(frames):
        tally.fail("damaged", _time(packet))
    return sound


def packed(placed: Iterable["AudioFrame | Gap | Overlap"], *, rate_hz: int, channels: int) -> Iterator[Samples]:
    """Yield the placed frames as float32, shape (frames, channels), silence for the gaps, and no overlaps.

    Raises SoundtrackError where the sound changes its sample rate or its number of channels on the way.
    """
    from av import AudioResampler

    packer: AudioResampler | None = None
    kind: tuple[str, str, int] | None = None
    position = cut = 0
    for frame in placed:
        if isinstance(frame, Overlap):
            yield from _emptied(packer, channels)
            packer, cut = None, frame.samples
            continue
        if isinstance(frame, Gap):
            yield from _emptied(packer, channels)
            packer = None
            yield from _silence(frame.samples, channels)
            position += frame.samples
            continue
        found = (frame.format.name, frame.layout.name, frame.sample_rate)
        if packer is None or kind != found:
            _require_same(frame, rate_hz=rate_hz, channels=channels, position=position)
            yield from _emptied(packer, channels)
            packer, kind = AudioResampler(format="flt", frame_size=PIECE), found
        position += frame.samples - cut
        frame.pts = None
        pieces = [_samples(piece, channels) for piece in packer.resample(frame)]
        if cut:
            yield np.concatenate([*pieces, *_emptied(packer, channels)])[cut:]
            packer, cut = None, 0
            continue
        yield from pieces
    yield from _emptied(packer, channels)


def _emptied(packer: "AudioResampler | None", channels: int) -> Iterator[Samples]:
    if packer is not None:
        yield from (_samples(piece, channels) for piece in packer.resample(None))


def _samples(frame: "AudioFrame", channels: int) -> Samples:
    keep_list(frame)
    return np.asarray(frame.to_ndarray(), dtype=np.float32).reshape(-1, channels)


def _silence(frames: int, channels: int) -> Iterator[Samples]:
    for start in range(0, frames, PIECE):
        yield np.zeros((min(PIECE, frames - start), channels), dtype=np.float32)


def _require_same(frame: "AudioFrame", *, rate_hz: int, channels: int, position: int) -> None:
    found = frame.layout.nb_channels
    if (frame.sample_rate, found) != (rate_hz, channels):
        raise SoundtrackError(
            f"the sound changes from {counted(channels, 'channel')} at {rate_hz} Hz to {counted(found, 'channel')} at "
            f"{frame.sample_rate} Hz after {position / rate_hz:.3f} s; convert it to one format first, or the file is "
            "damaged there"
        )

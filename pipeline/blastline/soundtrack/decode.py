"""From packets to packed float samples: damage is counted and stepped over, never hidden.

Samples are converted, never resampled; planar sound is packed by FFmpeg first, because PyAV cannot read eight planes.
"""

from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from ..errors import SoundtrackError
from .placement import Gap
from .track import PIECE, Samples

if TYPE_CHECKING:
    from av import AudioFrame, AudioResampler
    from av.audio.stream import AudioStream
    from av.container import InputContainer

MAX_FAILED_SHARE = 0.1
_HOPELESS = 500  # packets without a single sample


@dataclass
class Tally:
    """What happened to the packets: how many there were, how many failed, and where reading stopped early."""

    packets: int = 0
    failed: int = 0
    frames: int = 0
    first_time: Fraction | None = None
    last_error: str = ""
    stopped: str = ""

    def require_readable(self) -> None:
        """Raise SoundtrackError where too much failed for the rest to be trusted."""
        if self.failed > max(1, MAX_FAILED_SHARE * self.packets) or (self.failed and not self.frames):
            raise SoundtrackError(
                f"{self.failed} of {self.packets} packets of sound cannot be decoded ({self.last_error})"
            )


def decoded(
    container: "InputContainer", stream: "AudioStream", tally: Tally, *, earliest_s: Fraction | None = None
) -> Generator["AudioFrame", None, None]:
    """Yield the frames of a stream in order, stepping over packets that fail, and over those before `earliest_s`.

    Raises SoundtrackError where hundreds of packets give no sound at all.
    """
    from av.error import FFmpegError

    packets = container.demux(stream)
    while True:
        try:
            packet = next(packets, None)
        except FFmpegError as error:
            tally.stopped = str(error.strerror)
            packet = None
        if packet is None:
            return
        time_s = None if packet.pts is None or not packet.time_base else packet.pts * packet.time_base
        if packet.size and earliest_s is not None and time_s is not None and time_s < earliest_s:
            continue
        if packet.size:  # the last one is empty and only empties the decoder
            if not tally.packets and packet.pts is not None and packet.time_base:
                tally.first_time = Fraction(packet.pts * packet.time_base)
            tally.packets += 1
        try:
            frames = packet.decode()
        except FFmpegError as error:
            tally.failed += 1
            tally.last_error = str(error.strerror)
            frames = []
        for frame in frames:
            tally.frames += 1
            yield frame
        if tally.packets >= _HOPELESS and not tally.frames:
            tally.require_readable()


def packed(placed: Iterable["AudioFrame | Gap"], *, rate_hz: int, channels: int) -> Iterator[Samples]:
    """Yield the placed frames as float32, shape (frames, channels), and silence for the gaps.

    Raises SoundtrackError where the sound changes its sample rate or its number of channels on the way.
    """
    from av import AudioResampler

    packer: AudioResampler | None = None
    kind: tuple[str, str, int] | None = None
    position = 0
    for frame in placed:
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
        position += frame.samples
        frame.pts = None
        yield from (_samples(piece, channels) for piece in packer.resample(frame))
    yield from _emptied(packer, channels)


def _emptied(packer: "AudioResampler | None", channels: int) -> Iterator[Samples]:
    if packer is not None:
        yield from (_samples(piece, channels) for piece in packer.resample(None))


def _samples(frame: "AudioFrame", channels: int) -> Samples:
    return np.asarray(frame.to_ndarray(), dtype=np.float32).reshape(-1, channels)


def _silence(frames: int, channels: int) -> Iterator[Samples]:
    for start in range(0, frames, PIECE):
        yield np.zeros((min(PIECE, frames - start), channels), dtype=np.float32)


def _require_same(frame: "AudioFrame", *, rate_hz: int, channels: int, position: int) -> None:
    found = frame.layout.nb_channels
    if (frame.sample_rate, found) != (rate_hz, channels):
        raise SoundtrackError(
            f"the sound changes from {channels} channels at {rate_hz} Hz to {found} channels at {frame.sample_rate} Hz "
            f"after {position / rate_hz:.3f} s; convert it to one format first"
        )

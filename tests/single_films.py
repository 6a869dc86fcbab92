"""Films whose channels lie in streams of their own, and what is heard of them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

from blastline.model import Source
from blastline.soundtrack import open_soundtrack
from media import RATE_HZ, Samples, encoded

SIX = (0, 1, 2, 3, 4, 5)
FRAMES = 100_003


def apart(samples: Samples) -> list[Samples]:
    return [np.ascontiguousarray(channel)[:, None] for channel in samples.T]


def different(frames: int = FRAMES, channels: int = 6) -> Samples:
    """Return noise that differs from channel to channel, in whole 16-bit steps."""
    noise = np.random.default_rng(channels).integers(-16_000, 16_000, (frames, channels))
    return (noise / 32_768).astype(np.float32)


@dataclass(frozen=True)
class Single:
    """A stream of one channel as it is to be written; packets whose time lies in `lost_s` are left out.

    `channel` is what QuickTime is told that it is.
    """

    samples: Samples
    rate_hz: int = RATE_HZ
    start_s: float = 0.0
    lost_s: tuple[float, float] = (0.0, 0.0)
    channel: str = "FC"


def write_singles(path: Path, *singles: Single) -> Path:
    with av.open(str(path), "w") as container:
        streams: list[Any] = [
            container.add_stream("pcm_s16le", rate=each.rate_hz, layout=f"1 channels ({each.channel})")
            for each in singles
        ]
        for stream, each in zip(streams, singles, strict=True):
            start, (first_s, last_s) = round(each.start_s * each.rate_hz), each.lost_s
            for packet in encoded(stream, each.samples, rate_hz=each.rate_hz, start=start):
                if not first_s <= packet.pts * packet.time_base < last_s:
                    container.mux(packet)
    return path


def heard(
    path: Path, *, stream: int | tuple[int, ...] | None, mix: str = "mains", frames: int = 65_536
) -> tuple[NDArray[np.float32], Source]:
    with open_soundtrack(path, stream=stream, mix=mix, rereadable=False) as track:
        blocks = [np.column_stack([clip.samples, *clip_sides(clip.sides)]) for clip in track.blocks(frames, sides=True)]
        return np.concatenate(blocks), track.source()


def clip_sides(sides: NDArray[np.floating] | None) -> list[NDArray[np.floating]]:
    return [] if sides is None else [sides]

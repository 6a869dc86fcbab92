"""Films that tests write, read whole, and damage."""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

from blastline.model import Source, Span
from blastline.soundtrack import open_soundtrack
from media import onsets

SHOTS = [5_000, 47_000, 119_000]
FRAMES = 120_000
LONG_SHOTS = [5_000, 247_000, 399_000]
LONG = 480_000
FILM_RATE = Fraction(24_000, 1001)


def is_broken_off(source: Source) -> bool:
    """Return whether a warning says that a film stops before its own end; it has to say where its sound does."""
    begins = "the file stops or breaks before its own end: the end of the sound is missing"
    told = [warning for warning in source.warnings if warning.startswith(begins)]
    assert told in ([], [f"{begins}, from {source.frames / source.sample_rate_hz:.3f} s on"])
    return bool(told)


def read(path: Path, **options: Any) -> tuple[NDArray[np.float32], Source]:
    """Return all samples and the source, and require that a cut is what the pass gave."""
    with open_soundtrack(path, **options) as track:
        samples = np.concatenate([block.samples for block in track.blocks(10_007)])
        half = Span(len(samples) // 3, len(samples))
        np.testing.assert_array_equal(track.read(half).samples, samples[half.start :].astype(np.float64))
        assert track.read(half).samples.dtype == np.float64
        source = track.source()
        assert source.frames == len(samples)
        return samples, source


def shots_in_film(samples: NDArray[np.float32], source: Source) -> list[float]:
    """Return the shots' times against the picture, in samples."""
    return [shot + source.start_offset_s * source.sample_rate_hz for shot in onsets(samples[:, 0])]


def damaged(path: Path, places: Sequence[float]) -> tuple[bytes, float]:
    """Return a file with one byte flipped in the packets at these parts of it, and when the first of them plays."""
    with av.open(str(path)) as container:
        demuxed = [packet for packet in container.demux(audio=0) if packet.size]
        packets = [(bytes(packet), float((packet.pts or 0) * packet.time_base)) for packet in demuxed]
    data, searched = bytearray(path.read_bytes()), 0
    wanted = [round(place * (len(packets) - 1)) for place in places]
    for index, (packet, _) in enumerate(packets):
        searched = data.index(packet, searched)
        if index in wanted:
            data[searched + len(packet) // 2] ^= 0x55
        searched += len(packet)
    return bytes(data), packets[wanted[0]][1] - packets[0][1]

"""Films in QuickTime and MP4 whose description of the sound is another than the one that was written."""

import struct
from collections.abc import Iterator
from pathlib import Path

from media import Samples, write_media

_HOLD_BOXES = {b"moov": 8, b"trak": 8, b"mdia": 8, b"minf": 8, b"stbl": 8, b"stsd": 16}
"""Boxes that hold others, and how many bytes come before these."""


def film_with_layout(path: Path, tracks: list[Samples], layout: bytes, *, codec: str = "pcm_s16le") -> Path:
    """Write a film, its last track in the order of `layout`: the body of `chan` or, in MP4, `chnl`."""
    name = b"chnl" if path.suffix == ".mp4" else b"chan"
    data = bytearray(write_media(path, tracks, codec=codec).read_bytes())
    at = data.rindex(name) - 4
    (size,) = struct.unpack_from(">I", data, at)
    for start, length in list(_boxes(data, 0, len(data))):
        if start < at < start + length:
            struct.pack_into(">I", data, start, length + 8 + len(layout) - size)
    data[at : at + size] = struct.pack(">I4s", 8 + len(layout), name) + layout
    path.write_bytes(data)
    return path


def _boxes(data: bytearray, start: int, stop: int) -> Iterator[tuple[int, int]]:
    """Yield where each box begins and how long it is, those inside others too."""
    while start + 8 <= stop:
        size, name = struct.unpack_from(">I4s", data, start)
        yield start, size
        if name in _HOLD_BOXES:
            yield from _boxes(data, start + _HOLD_BOXES[name], start + size)
        start += size

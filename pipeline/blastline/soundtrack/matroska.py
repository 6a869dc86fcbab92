"""Whether a Matroska or WebM file says how long it is, where FFmpeg guesses if not, and whether it breaks off.

file      [EBML][Segment [SeekHead][Info [Duration]][Tracks][Cluster][Cluster] ... ]
element   [name][size][body]    the first bits of name and size tell how long these are; all others 1: size unknown

What is written into a pipe, or was never finished, has no Duration, or one of 0.
"""

import struct
from pathlib import Path
from typing import BinaryIO

_SEGMENT, _INFO, _DURATION, _CLUSTER = 0x18538067, 0x1549A966, 0x4489, 0x1F43B675
_FLOATS = {4: ">f", 8: ">d"}


def stores_duration(path: Path) -> bool:
    """Return whether a Matroska or WebM file holds its duration."""
    with path.open("rb") as file:
        start, end = 0, path.stat().st_size
        for name in (_SEGMENT, _INFO, _DURATION):
            found = _body(file, name, start, end)
            if found is None:
                return False
            start, end = found
        file.seek(start)
        kind = _FLOATS.get(end - start)
        return kind is not None and struct.unpack(kind, file.read(end - start))[0] > 0


def breaks_off_in_a_cluster(path: Path) -> bool:
    """Return whether the last cluster of a file, which holds its sound, is longer than what is there of it.

    What else is missing, as the index behind all clusters, is no sound; nor is it told of clusters of unknown size.
    """
    with path.open("rb") as file:
        file_bytes = path.stat().st_size
        place, end = _body(file, _SEGMENT, 0, file_bytes) or (0, 0)
        while place < end:
            file.seek(place)
            name, size = _number(file, keeps_length=True), _number(file)
            if name is None or size is None:
                return False
            place = file.tell() + size
            if place > file_bytes:
                return name == _CLUSTER
    return False


def _body(file: BinaryIO, wanted: int, start: int, end: int) -> tuple[int, int] | None:
    """Return where the body of the first element of a name begins and ends, among those that lie side by side."""
    while start < end:
        file.seek(start)
        name, size = _number(file, keeps_length=True), _number(file)
        if name is None or (size is None and name != wanted):
            return None
        start = file.tell()
        if name == wanted:
            return start, end if size is None else min(end, start + size)
        start += size or 0
    return None


def _number(file: BinaryIO, *, keeps_length: bool = False) -> int | None:
    """Return the number that begins here, None where it is unknown or none; names keep the bits of their length."""
    first = file.read(1)
    if not first or not first[0]:
        return None
    further = 8 - first[0].bit_length()
    number = int.from_bytes(first + file.read(further), "big")
    most = (1 << 7 * (further + 1)) - 1
    return number if keeps_length else None if number & most == most else number & most

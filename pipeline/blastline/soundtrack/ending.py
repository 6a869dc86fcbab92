"""Whether a file stops before its own end, where FFmpeg takes what is there for the whole.

Ogg, AVI, MPEG transport and program streams, and NUT; MP4 in fragments is in `boxes.py`, Matroska in `matroska.py`:

Ogg   [page][page] ... [page, marked as the last of its stream]
AVI   [RIFF, size, ...][RIFF, size, ...] ...    the further ones only beyond 1 GiB
TS    [0x47, ...][0x47, ...][0x47, ...] ...    all of 188 bytes, with 4 more before or 16 more behind each
PS    [pack][PES, length, ...][PES, length, ...][pack] ...
NUT   [syncpoint][frame][frame] ... [syncpoint][frame] ... [index, ..., its length, checksum]
"""

import struct
from pathlib import Path

from .boxes import breaks_off_in_fragments
from .matroska import breaks_off_in_a_cluster

_PAGE = struct.Struct("<4sBB20xB")
_LONGEST_PAGE_BYTES = 27 + 255 + 255 * 255
_LAST_PAGE = 4


def _check_of(byte: int) -> int:
    """Return the checksum of one byte, by the polynomial of Ogg."""
    check = byte << 24
    for _ in range(8):
        check = (check << 1 & 0xFFFFFFFF) ^ (_POLYNOMIAL if check >> 31 else 0)
    return check


_POLYNOMIAL = 0x04C11DB7
_CHECKS = tuple(map(_check_of, range(256)))

_TS_BYTES, _TS_DISTANCES, _TS_COMPARED = 188, (188, 192, 204), 8
"""How long a packet of a transport stream is, how far apart two may begin, and how many in a row are no chance."""

_LONGEST_PES_BYTES = 6 + 65_535

_SYNCPOINT, _INDEX = b"NK\xe4\xad\xee\xca\x45\x69", b"NX\xdd\x67\x2f\x23\xe6\x4e"
_SYNCPOINTS_APART_BYTES = 1 << 20
"""How far apart syncpoints of a NUT file are at most, with a frame that is longer than usual."""

_ODD_BYTES = 16
"""Some programs count the head of a chunk as a part of it."""


def stops_early(path: Path, container_format: str) -> bool:
    """Return whether the end of a file is missing by what the file itself says; False for formats that do not say."""
    if container_format == "ogg":
        return not _has_last_page(path)
    if "mp4" in container_format.split(","):
        return breaks_off_in_fragments(path)
    if container_format == "matroska,webm":
        return breaks_off_in_a_cluster(path)
    if container_format == "mpegts":
        return _is_cut_in_a_packet(path)
    if container_format == "mpeg":
        return _is_cut_in_a_pack(path)
    if container_format == "nut":
        return _lacks_its_index(path)
    return container_format == "avi" and _is_cut_avi(path)


def _tail(path: Path, count: int) -> bytes:
    """Return so many of a file's last bytes."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - count))
        return file.read()


def _has_last_page(path: Path) -> bool:
    """Return whether the last whole page of an Ogg file is marked as the last one, and is as it was written."""
    tail = _tail(path, 2 * _LONGEST_PAGE_BYTES)  # tags of music players may follow the last one
    place = len(tail)
    while (place := tail.rfind(b"OggS", 0, place)) >= 0:
        if place + _PAGE.size > len(tail):
            continue
        _, version, flags, segments = _PAGE.unpack_from(tail, place)
        body = place + _PAGE.size
        end = body + segments + sum(tail[body : body + segments])
        if version == 0 and end <= len(tail):
            return bool(flags & _LAST_PAGE) and _is_as_written(tail[place:end])
    return False


def _is_as_written(page: bytes) -> bool:
    """Return whether the checksum of an Ogg page is right: FFmpeg drops one where it is not, the last one unnoticed."""
    check = 0
    for byte in page[:22] + bytes(4) + page[26:]:
        check = (check << 8 & 0xFFFFFFFF) ^ _CHECKS[check >> 24 ^ byte]
    return check == int.from_bytes(page[22:26], "little")


def _is_cut_avi(path: Path) -> bool:
    """Return whether one of an AVI file's outermost chunks is longer than what is there of it."""
    file_bytes, place = path.stat().st_size, 0
    with path.open("rb") as file:
        while True:
            file.seek(place)
            head = file.read(8)
            if len(head) < 8 or not head.startswith(b"RIFF"):
                return False
            place += 8 + int.from_bytes(head[4:], "little")
            if place > file_bytes + _ODD_BYTES:
                return True
            place += place % 2


def _is_cut_in_a_packet(path: Path) -> bool:
    """Return whether the last packet of a transport stream is shorter than it should be."""
    tail = _tail(path, _TS_COMPARED * max(_TS_DISTANCES))
    for distance in _TS_DISTANCES:
        for place in range(len(tail) - 1, len(tail) - 1 - distance, -1):
            if tail[place::-distance][:_TS_COMPARED] == b"\x47" * _TS_COMPARED:
                return place + _TS_BYTES > len(tail)
    return False


def _is_cut_in_a_pack(path: Path) -> bool:
    """Return whether the last packet of a program stream, or the head of a pack, is longer than what is there of it."""
    tail, place = _tail(path, 2 * _LONGEST_PES_BYTES), -1
    while (place := tail.find(b"\0\0\1\xba", place + 1)) >= 0:
        end = place
        while end < len(tail) and (size := _packet_bytes(tail[end : end + 14])):
            end += size
        if end == len(tail):
            return False
        if end > len(tail):
            return True
    return False


def _packet_bytes(head: bytes) -> int:
    """Return how long what begins here in a program stream is, by its head; 0 where nothing does."""
    if not head.startswith(b"\0\0\1"):
        return 0
    code, is_mpeg_2 = head[3:4], head[4:5] >= b"\x40"
    if code == b"\xba":
        return 14 + (head[13:14] or b"\0")[0] % 8 if is_mpeg_2 else 12
    if code == b"\xb9":
        return 4
    return 6 + int.from_bytes(head[4:6], "big") if code > b"\xba" or not code else 0


def _lacks_its_index(path: Path) -> bool:
    """Return whether a NUT file has syncpoints, and no index of them at its end; a pipe's has neither."""
    tail = _tail(path, _SYNCPOINTS_APART_BYTES)
    index_bytes = int.from_bytes(tail[-12:-4], "big")
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - index_bytes))
        return file.read(len(_INDEX)) != _INDEX and _SYNCPOINT in tail

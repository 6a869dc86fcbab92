"""Whether a file stops before its own end, where FFmpeg takes what is there for the whole: Ogg and AVI.

Ogg   [page][page] ... [page, marked as the last of its stream]
AVI   [RIFF, size, ...][RIFF, size, ...] ...    the further ones only beyond 1 GiB
"""

import struct
from pathlib import Path

_PAGE = struct.Struct("<4sBB20xB")
_LONGEST_PAGE_BYTES = 27 + 255 + 255 * 255
_LAST_PAGE = 4

_ODD_BYTES = 16
"""Some programs count the head of a chunk as a part of it."""


def stops_early(path: Path, container_format: str) -> bool:
    """Return whether the end of a file is missing by what the file itself says; False for formats that do not say."""
    if container_format == "ogg":
        return not _has_last_page(path)
    return container_format == "avi" and _is_cut_avi(path)


def _has_last_page(path: Path) -> bool:
    """Return whether the last whole page of an Ogg file is marked as the last one."""
    file_bytes = path.stat().st_size
    with path.open("rb") as file:
        # twice the longest page: tags of music players may follow the last one
        file.seek(max(0, file_bytes - 2 * _LONGEST_PAGE_BYTES))
        tail = file.read()
    place = len(tail)
    while (place := tail.rfind(b"OggS", 0, place)) >= 0:
        if place + _PAGE.size > len(tail):
            continue
        _, version, flags, segments = _PAGE.unpack_from(tail, place)
        body = place + _PAGE.size
        if version == 0 and body + segments + sum(tail[body : body + segments]) <= len(tail):
            return bool(flags & _LAST_PAGE)
    return False


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

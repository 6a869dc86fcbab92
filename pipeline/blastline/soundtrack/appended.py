"""Another file behind the sound of the first, as where files were joined end to end: its sound is not read.

[RIFF, fmt, data, LIST][RIFF, fmt, data]    so in all files of chunks: the table of the first ends where another begins
[ftyp, mdat, moov][ftyp, mdat, moov]        see `boxes.py`
[TTA1, sizes of frames, frames, tags][TTA1, sizes of frames, frames]
"""

import struct
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from .boxes import appended_film_at
from .id3 import ID3_HEAD_BYTES, ID3_NAME, id3_bytes
from .reach import percent

BEGINNING_BYTES = 28
"""So many bytes tell whether a file of chunks begins here."""

_WAVES, _AIFFS = (b"RIFF", b"RF64", b"BW64", b"RIFX"), (b"AIFF", b"AIFC")
_RIFF_GUID, _WAVE_GUID = b"riff\x2e\x91\xcf\x11\xa5\xd6\x28\xdb", b"wave"

_TTA = struct.Struct("<4sHHHII4x")
_TTA_FRAME_S = (256, 245)
_TAG_BYTES = 1 << 16
"""Tags of music players may stand between two files."""

_SCANNED_BYTES = 1 << 20


@dataclass(frozen=True)
class Appended:
    """Where another file begins, in bytes, in one of so many."""

    place: int
    file_bytes: int


def appended_warning(found: Appended) -> str:
    """Return the line for the user."""
    share = percent(found.file_bytes - found.place, found.file_bytes)
    return (
        f"another file begins at byte {found.place}, behind the sound: "
        f"only the first is read, not the last {share} of the bytes"
    )


def begins_file(start: bytes) -> bool:
    """Return whether a sound file of chunks begins with these bytes."""
    name, kind = start[:4], start[8:12]
    if name == b"caff":
        return start[4:6] == b"\0\1"
    if name == b"riff":
        return start.startswith(_RIFF_GUID) and start[24:28] == _WAVE_GUID
    return (name in _WAVES and kind == b"WAVE") or (name == b"FORM" and kind in _AIFFS)


def find_begun(file: BinaryIO, places: Iterable[int], file_bytes: int) -> Appended | None:
    """Return where another file of chunks begins, if at one of some places of a file; None where none does."""
    for place in places:
        if place + BEGINNING_BYTES <= file_bytes:
            file.seek(place)
            if begins_file(file.read(BEGINNING_BYTES)):
                return Appended(place, file_bytes)
    return None


def behind_zeros(file: BinaryIO, place: int) -> int:
    """Return where in a file the first byte from a place on is that is not 0; its end where all are."""
    file.seek(place)
    while block := file.read(_SCANNED_BYTES):
        if rest := block.lstrip(b"\0"):
            return file.tell() - len(rest)
    return file.tell()


def find_appended(path: Path, container_format: str) -> Appended | None:
    """Return where another file follows in an MP4, QuickTime film or TTA; None without one, and for other formats."""
    place = None
    if "mp4" in container_format.split(","):
        place = appended_film_at(path)
    elif container_format == "tta":
        place = _appended_tta_at(path)
    return None if place is None else Appended(place, path.stat().st_size)


def _appended_tta_at(path: Path) -> int | None:
    """Return where another TTA begins behind the frames of the first one, or behind its tags."""
    with path.open("rb") as file:
        start = _tta_from(file, 0)
        file.seek(start or 0)
        head = file.read(_TTA.size)
        if start is None or len(head) < _TTA.size:
            return None
        _, _, _, _, rate_hz, samples = _TTA.unpack(head)
        frame_samples = rate_hz * _TTA_FRAME_S[0] // _TTA_FRAME_S[1]
        frames = -(-samples // frame_samples) if frame_samples else 0
        sizes = file.read(4 * frames)
        end = file.tell() + 4 + sum(struct.unpack(f"<{len(sizes) // 4}I", sizes[: len(sizes) // 4 * 4]))
        return _tta_from(file, end)


def _tta_from(file: BinaryIO, place: int) -> int | None:
    """Return where a TTA begins at a place or behind the tags there; None where none does."""
    while True:
        file.seek(place)
        start = file.read(_TAG_BYTES)
        found, id3 = start.find(b"TTA1"), start.find(ID3_NAME)
        if id3 < 0 or 0 <= found < id3 or len(start) < id3 + ID3_HEAD_BYTES:
            return None if found < 0 else place + found
        place += id3 + id3_bytes(start[id3:])  # a tag with pictures may be larger

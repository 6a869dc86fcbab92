"""The outermost boxes of an MP4 or QuickTime film: whether they lead to its end, and whether another film follows.

In one piece    [size, ftyp, ...][size, moov, ...][size, mdat, ...]    moov, its index, may come last
In fragments    [size, ftyp, ...][size, moov, ...][size, moof, ...][size, mdat, ...][size, moof, ...] ...
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

_FIRST_BOXES = (b"ftyp", b"wide", b"free", b"skip")
_WHOLE = frozenset({b"moov", b"mdat"})
"""What every film in one piece has, once each or more: some programs leave a second `moov` for safety."""

_MOST_PADDING_BYTES = 1 << 16
"""The largest usual cluster of a file system: what is left of the last one may be zeros. More of them is what a copy
leaves that never finished, in a file that was given its full size before."""


@dataclass(frozen=True)
class _Box:
    """A box and where it begins; its size counts its head, and is 0 where it goes on to the end of the file."""

    name: bytes
    place: int
    size: int


def _boxes(path: Path) -> Iterator[_Box]:
    """Yield the boxes one after the other, up to one that does not say where the next begins."""
    file_bytes, place, size = path.stat().st_size, 0, 8
    with path.open("rb") as file:
        while size >= 8 and place < file_bytes:
            file.seek(place)
            head = file.read(16)
            size = int.from_bytes(head[:4], "big")
            if size == 1:
                size = int.from_bytes(head[8:], "big")
            yield _Box(head[4:8], place, size)
            place += size


def ends_before_its_index(path: Path) -> bool:
    """Return whether a file begins as an MP4 or QuickTime film, but lacks its `moov`, which comes last in most."""
    is_film = False
    for box in _boxes(path):
        if box.name == b"moov" or (box.place == 0 and box.name not in _FIRST_BOXES):
            return False
        is_film = is_film or box.size >= 8
    return is_film


def breaks_off_in_fragments(path: Path) -> bool:
    """Return whether the boxes of an MP4 in fragments fail to lead to its end; one in one piece declares its length.

    Where a fragment was damaged, what follows cannot be found: FFmpeg ends there, as if the film did.
    """
    file_bytes, is_fragmented = path.stat().st_size, False
    for box in _boxes(path):
        if box.size == 0:  # up to the end of the file, or no box at all
            return is_fragmented and box.name != b"mdat" and not _is_padding(path, box)
        is_fragmented = is_fragmented or box.name == b"moof"
        if box.size < 8 or box.place + box.size > file_bytes:
            return is_fragmented
    return False


def _is_padding(path: Path, box: _Box) -> bool:
    """Return whether nothing but zeros follows the head of the last box, and no more of them than padding has."""
    if not box.name.strip(b"\0") and path.stat().st_size - box.place > _MOST_PADDING_BYTES:
        return False
    with path.open("rb") as file:
        file.seek(box.place + 16)
        while block := file.read(1 << 20):
            if block.strip(b"\0"):
                return False
    return True


def appended_film_at(path: Path) -> int | None:
    """Return where another film begins behind the first one of a file, of which nothing is read; None without one.

    A film in fragments goes on with those of another, which FFmpeg takes for its own and reads.
    """
    seen: set[bytes] = set()
    seen_behind: set[bytes] = set()
    behind = None
    for box in _boxes(path):
        if box.name == b"moof":
            return None
        if not seen >= _WHOLE:
            seen.add(box.name)
            continue
        if box.name == b"ftyp":
            return box.place
        behind = box.place if behind is None else behind
        seen_behind.add(box.name)
    return behind if seen_behind >= _WHOLE else None  # QuickTime films of old have no ftyp

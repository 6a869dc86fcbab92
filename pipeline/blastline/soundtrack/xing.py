"""Whether an MP3 says how long it is; where it does not, FFmpeg guesses by its size and its first frames.

file   [ID3 tag][frame of silence, with "Xing", "Info" or "VBRI" and the number of frames][frame][frame] ... [tags]

A file that is longer than its own count of bytes FFmpeg takes for several and guesses, too, be it but a tag with a
picture that makes it so.
"""

import struct
from os import SEEK_END
from pathlib import Path

from .id3 import ID3_HEAD_BYTES, ID3_NAME, id3_bytes

_COUNTS = (b"Xing", b"Info")
_FIELDS = struct.Struct(">4xIII")  # behind the name: which of the numbers follow, of frames, of bytes
_HAS_FRAMES, _HAS_BYTES = 1, 2
_MOST_BEYOND = 16
"""The share of its bytes, one in so many, that FFmpeg lets a file be longer by."""

_LONGEST_FRAME_BYTES = 2_881  # 160 kbit/s at 8 kHz


def counts_its_frames(path: Path) -> bool:
    """Return whether the first frame of an MP3 holds the number of those that follow, and FFmpeg believes it."""
    with path.open("rb") as file:
        head = file.read(ID3_HEAD_BYTES)
        start = file.seek(id3_bytes(head) if head.startswith(ID3_NAME) and len(head) == ID3_HEAD_BYTES else 0)
        frame = file.read(_LONGEST_FRAME_BYTES)
        file_bytes = file.seek(0, SEEK_END) - start
    place = max(map(frame.find, _COUNTS))
    if place < 0 or place + _FIELDS.size > len(frame):
        return b"VBRI" in frame
    numbers, frames, count = _FIELDS.unpack_from(frame, place)
    if not (numbers & _HAS_FRAMES and frames):
        return False
    return not (numbers & _HAS_BYTES and count) or file_bytes - count <= count // _MOST_BEYOND

"""Whether an MP3 says how long it is; where it does not, FFmpeg guesses by its size and its first frames.

file   [ID3 tag][frame of silence, with "Xing", "Info" or "VBRI" and the number of frames][frame][frame] ...
"""

from pathlib import Path

_COUNTS = (b"Xing", b"Info", b"VBRI")
_LONGEST_FRAME_BYTES = 2_881  # 160 kbit/s at 8 kHz

_ID3_HEAD_BYTES = 10


def counts_its_frames(path: Path) -> bool:
    """Return whether the first frame of an MP3 holds the number of those that follow."""
    with path.open("rb") as file:
        head, place = file.read(_ID3_HEAD_BYTES), 0
        if head.startswith(b"ID3") and len(head) == _ID3_HEAD_BYTES:
            # of the four bytes of its size each counts seven bits
            size = sum((byte & 0x7F) << shift for byte, shift in zip(head[6:], (21, 14, 7, 0), strict=True))
            place = _ID3_HEAD_BYTES + size
        file.seek(place)
        frame = file.read(_LONGEST_FRAME_BYTES)
    return any(name in frame for name in _COUNTS)

"""Whether an MP3 says how long it is; where it does not, FFmpeg guesses by its size and its first frames.

file   [ID3 tag][frame of silence, with "Xing", "Info" or "VBRI" and the number of frames][frame][frame] ...
"""

from pathlib import Path

from .id3 import ID3_HEAD_BYTES, ID3_NAME, id3_bytes

_COUNTS = (b"Xing", b"Info", b"VBRI")
_LONGEST_FRAME_BYTES = 2_881  # 160 kbit/s at 8 kHz


def counts_its_frames(path: Path) -> bool:
    """Return whether the first frame of an MP3 holds the number of those that follow."""
    with path.open("rb") as file:
        head = file.read(ID3_HEAD_BYTES)
        file.seek(id3_bytes(head) if head.startswith(ID3_NAME) and len(head) == ID3_HEAD_BYTES else 0)
        frame = file.read(_LONGEST_FRAME_BYTES)
    return any(name in frame for name in _COUNTS)

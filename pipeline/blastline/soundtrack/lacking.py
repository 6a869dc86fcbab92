"""How many bytes a file of chunks has lost: the sizes in its header say how long it was.

RIFF size  fmt  data 1000 [ 999 bytes ]                 1 byte is missing, in the sound or at its end
RIFF size  fmt  data 1000 [ 999 bytes ][ LIST ]         so it is here: the size of the whole says so, and no chunk
                                                        begins where the sound should end
RIFF size  fmt  data 1008 [ 1000 bytes ]                none is, if by the size of the whole all is there: some
                                                        programs count the head of a chunk as a part of it
"""

import struct
from typing import BinaryIO

from .forms import Form

_UNKNOWN = (0, 0xFFFFFFFF, -1)

_ODD_BYTES = 8
"""Some programs count the head of the whole file, or a padding that they do not write."""


def lacking_bytes(file: BinaryIO, form: Form, sound_end: int, walked: int, ds64: bytes | None) -> int:
    """Return how many bytes the sound lacks, 0 where nothing says that it lacks any.

    `sound_end` is where the sound ends by its declared size, `walked` where the last of the chunks behind it does, or
    where there was none any more; `ds64` are the sizes of 64 bits, where the file has them.
    """
    file_bytes, end = file.seek(0, 2), _declared_end(file, form, ds64)
    beyond, lacking = sound_end - file_bytes, 0 if end is None else max(0, end - file_bytes)
    if beyond > 0:
        is_no_witness = end is None or sound_end - end > _ODD_BYTES
        return max(beyond, lacking) if is_no_witness or lacking else 0
    # chunks follow to the end by chance where a list of notes lost just its head: its notes are built as chunks are
    is_whole = file_bytes <= walked <= file_bytes + form.alignment
    return 0 if is_whole and lacking <= _ODD_BYTES else lacking


def _declared_end(file: BinaryIO, form: Form, ds64: bytes | None) -> int | None:
    """Return where the file ends by the size of the whole, None where that was never written or the form has none."""
    whole = form.whole_size
    if whole is None:
        return None
    file.seek(whole.place)
    (size,) = whole.number.unpack(file.read(whole.number.size))
    if size == 0xFFFFFFFF and ds64 is not None and len(ds64) >= 8:
        (size,) = struct.unpack_from("<Q", ds64)
    return None if size in _UNKNOWN else int(size) + whole.counted_from

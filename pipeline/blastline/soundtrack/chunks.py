"""The chunk table of WAV, RF64, BW64, W64, AIFF and CAF: what the header promises, which sample readers do not tell.

A recorder that lost power leaves a data size of 0, a broken copy leaves a size beyond the end of the file, and beyond
4 GiB the 32 bits of a size start again at 0; all read silently as something else. The broadcast extension holds the
time of day of the first sample, the format chunk (in CAF and AIFF the layout chunk) says which loudspeaker each channel
feeds.
"""

import os
import struct
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO

from ..errors import SoundtrackError
from .appended import Appended, behind_zeros, find_begun
from .core_audio import named_channels
from .forms import FORMS, Form, is_name
from .lacking import lacking_bytes
from .overflow import more_follows

_UNKNOWN_SIZE = 0xFFFFFFFF
_EXTENSIBLE = 0xFFFE
# by bit of the channel mask
_SPEAKERS = (
    "FL",
    "FR",
    "FC",
    "LFE",
    "BL",
    "BR",
    "FLC",
    "FRC",
    "BC",
    "SL",
    "SR",
    "TC",
    "TFL",
    "TFC",
    "TFR",
    "TBL",
    "TBC",
    "TBR",
)
_MAX_KEPT = 1 << 16
_AIFF_SAMPLES = frozenset((b"", b"none", b"sowt", b"twos", b"raw ", b"in24", b"in32", b"fl32", b"fl64"))
"""What an AIFF calls samples that it stores as they are; of coded ones their number does not tell the bytes."""

_MAX_FRAME_BYTES = 1 << 10
"""128 channels of 64 bits; the frames of an AIFF that would be longer were never counted."""


@dataclass(frozen=True)
class ChunkTable:
    """What a header declares.

    `data_bytes` is the declared size of the samples, None where it is left open; `present_bytes` is how many follow
    in the file. `time_reference` counts samples since midnight, None without a broadcast extension. `layout` names
    the channels, None where the header does not. `goes_on` tells that the declared sound is followed by much that is
    no chunk, so that it can only be more of it; `is_wave` that the file is a WAV, which decoders can read beyond it.
    `frame_bytes` is the size of a frame, None where the header does not say it or contradicts itself. `implied_rate_hz`
    is the sample rate by the bytes of a second, None where these are no number of whole frames. `appended` is another
    file behind all chunks of this one. `lacking_bytes` is how many bytes were lost, in the sound or at its end.
    `is_plain` tells that the data chunk has a size of its own, and the sizes of 64 bits another: they are for where it
    has none (EBU Tech 3306), but decoders believe them.
    """

    data_bytes: int | None
    present_bytes: int
    time_reference: int | None
    layout: tuple[str, ...] | None
    goes_on: bool = False
    is_wave: bool = False
    frame_bytes: int | None = None
    implied_rate_hz: int | None = None
    appended: Appended | None = None
    lacking_bytes: int = 0
    is_plain: bool = False


def overflow_warning(table: ChunkTable, *, is_read: bool = True) -> str:
    """Return the line for the user where the sound goes on beyond what the header declares."""
    if not table.data_bytes:
        return "the header was never finished; the sound was read to the end of the file"
    done = "the sound was read to the end of the file" if is_read else "what is beyond was not read"
    return f"the header declares {table.data_bytes} bytes of sound but {table.present_bytes} follow; {done}"


def chunk_table(path: Path) -> ChunkTable | None:
    """Return what the header declares, or None where the file is of another kind or its table is broken.

    Raises SoundtrackError where it has sound in more places than one, or does not tell where it begins.
    """
    with path.open("rb") as file:
        form = FORMS.get(file.read(4))
        return None if form is None else _read_table(file, form, path.stat().st_size)


def _read_table(file: BinaryIO, form: Form, file_bytes: int) -> ChunkTable | None:
    kept: dict[bytes, bytes] = {}
    data: tuple[int | None, int] | None = None
    goes_on, appended, sound_end = False, None, None
    place = data_place = form.first
    while (chunk := form.chunk_at(file, place, file_bytes)) is not None:
        name, body, declared = chunk
        size: int | None = declared
        if data is not None and not is_name(name):  # zeros, or crumbs: to take them for chunks would cost minutes
            appended = find_begun(file, [behind_zeros(file, place)], file_bytes)
            break
        if name == form.data_name:
            if data is not None:  # decoders take the last one, or none at all
                where = f"a second {name.decode()} chunk at byte {place}"
                raise SoundtrackError(f"has {where}; expected one, at byte {data_place}")
            data_place = place
            size = _data_size(declared, kept.get(b"ds64"))
            start = body + form.data_preamble
            data = (None if size is None else max(0, size - form.data_preamble), file_bytes - start)
            # of a WAV of size 0 the decoder of films reads what there is
            may_go_on = size is not None and not (size == 0 and form.is_wave)
            goes_on = may_go_on and more_follows(file, body + (size or 0), file_bytes, form)
            sound_end = body + size if size and not goes_on else None
        elif name in (b"ds64", b"fmt ", b"bext", b"COMM", form.layout_name):
            kept[name] = file.read(max(0, min(declared, _MAX_KEPT)))
        if size is None or size < 0 or goes_on or (data is not None and data[0] == 0):
            break
        place = form.after(body, size)
        if data is not None and (appended := find_begun(file, form.places_after(body + size), file_bytes)) is not None:
            break
    if data is None:
        return None
    lacking = 0 if sound_end is None else lacking_bytes(file, form, sound_end, place, kept.get(b"ds64"))
    table = _table(file, form, kept, data, goes_on=goes_on, appended=appended)
    return replace(table, lacking_bytes=lacking)


def _table(
    file: BinaryIO,
    form: Form,
    kept: dict[bytes, bytes],
    data: tuple[int | None, int],
    *,
    goes_on: bool,
    appended: Appended | None,
) -> ChunkTable:
    """Return what was found in the chunks that were kept; `data` is what is declared of the samples, and present."""
    fmt = kept.get(b"fmt ", b"")
    frame_bytes = _frame_bytes(fmt, form)
    if form.data_name == b"SSND" and data[0]:
        body = file.seek(0, os.SEEK_END) - data[1] - form.data_preamble
        offset = _offset(file, body, kept.get(b"COMM", b""), data[0])
        data = (data[0] - offset, data[1] - offset)
        frame_bytes = _counted_frame_bytes(kept.get(b"COMM", b""), data[0] or 0)
    reference, layout = _time_reference(kept.get(b"bext", b""), form), _layout(fmt, form)
    if form.layout_name:
        layout = named_channels(kept.get(form.layout_name, b""), _SPEAKERS)
    return ChunkTable(
        *data,
        reference,
        layout,
        goes_on,
        form.is_wave,
        frame_bytes,
        _implied_rate_hz(fmt, form),
        appended,
        is_plain=data[0] is not None and _long_size(kept.get(b"ds64")) not in (None, data[0]),
    )


def _data_size(size: int, ds64: bytes | None) -> int | None:
    long_size = _long_size(ds64)
    if size == _UNKNOWN_SIZE and long_size is not None:
        return long_size
    return None if size in (_UNKNOWN_SIZE, -1) else size


def _long_size(ds64: bytes | None) -> int | None:
    """Return the size of the samples among the sizes of 64 bits, None without such."""
    return None if ds64 is None or len(ds64) < 16 else int(struct.unpack_from("<Q", ds64, 8)[0])


def _offset(file: BinaryIO, body: int, comm: bytes, data_bytes: int) -> int:
    """Return how many bytes an AIFF leaves free before its samples, to align them with the blocks of a disk.

    Raises SoundtrackError where that leaves no room for the frames that the common chunk counts: sound that is read
    from a wrong place on plays early or is noise.
    """
    file.seek(body)
    offset = int.from_bytes(file.read(4), "big")
    if len(comm) < 8 or not offset or comm[18:22].lower() not in _AIFF_SAMPLES:
        return 0
    channels, frames, bits = struct.unpack_from(">HIH", comm)
    room = data_bytes - frames * channels * (-(-bits // 8))
    if offset > max(0, room):
        counted = f"its {frames} frames of {channels} x {bits} bits"
        raise SoundtrackError(
            f"the header leaves {offset} bytes free before the sound; expected at most {max(0, room)}, for {counted}"
        )
    return offset


def _time_reference(bext: bytes, form: Form) -> int | None:
    """Return the time stamp of a broadcast extension: two numbers of 32 bits, the lower first in either byte order."""
    if len(bext) < 346:
        return None
    low, high = struct.unpack_from(f"{form.byte_order}II", bext, 338)
    return int(high << 32 | low)


def _frame_bytes(fmt: bytes, form: Form) -> int | None:
    """Return the size of a frame where the bytes of a frame and those of a second say the same."""
    if len(fmt) < 16:
        return None
    rate_hz, second, frame = struct.unpack_from(f"{form.byte_order}IIH", fmt, 4)
    return frame if frame and second == frame * rate_hz else None


def _implied_rate_hz(fmt: bytes, form: Form) -> int | None:
    """Return how many frames the bytes of a second are, where the size of a frame is that of its samples."""
    if len(fmt) < 16:
        return None
    channels, _, second, frame, bits = struct.unpack_from(f"{form.byte_order}HIIHH", fmt, 2)
    is_plain = frame and frame == channels * -(-bits // 8) and second % frame == 0
    return second // frame or None if is_plain else None


def _counted_frame_bytes(comm: bytes, data_bytes: int) -> int | None:
    """Return the size of a frame of an AIFF where so many as its common chunk counts fill its sound to the byte."""
    frames = struct.unpack_from(">I", comm, 2)[0] if len(comm) >= 8 else 0
    size, rest = divmod(data_bytes, frames) if frames else (0, 1)
    return size if rest == 0 and 0 < size <= _MAX_FRAME_BYTES else None


def _layout(fmt: bytes, form: Form) -> tuple[str, ...] | None:
    if len(fmt) < 24:
        return None
    tag, channels = struct.unpack_from(f"{form.byte_order}HH", fmt)
    (mask,) = struct.unpack_from(f"{form.byte_order}I", fmt, 20)
    names = tuple(name for bit, name in enumerate(_SPEAKERS) if mask >> bit & 1)
    return names if tag == _EXTENSIBLE and len(names) == channels else None

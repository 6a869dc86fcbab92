"""The chunks of a broadcast WAV around its samples: head, time of day, markers.

    RIFF | RF64 ds64    size of the file; RF64 from 4 GiB on (EBU Tech 3306)
    bext                time reference (EBU Tech 3285, version 1; 602 bytes)
    fmt, data           24-bit PCM, one channel
    cue, LIST adtl      a marker for each event: its sample, its name (labl) and the length of its region (ltxt)

Date and time of day of the making are left empty, so that the same film gives the same file to the bit.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from os import SEEK_END
from pathlib import Path

RIFF_LIMIT = 0xFFFFFFFF
MARKER_LIMIT = 0xFFFFFFFF
ORIGINATOR = b"blastline"
SAMPLE_BYTES = 3
_BEXT_BYTES = 602
_HEAD_BYTES = 1024  # all that stands before the samples, and some of them


@dataclass(frozen=True)
class Cue:
    """A marker in the drive: its sample, its label, and the length of its region (0: a point)."""

    sample: int
    label: str
    length: int = 0


def chunk(name: bytes, body: bytes) -> bytes:
    """Return one chunk, padded to an even length."""
    return struct.pack("<4sI", name, len(body)) + body + bytes(len(body) % 2)


def header(*, frames: int, rate_hz: int, time_reference: int, description: str, tail: int, riff_limit: int) -> bytes:
    """Return everything before the samples; `tail` is the number of bytes that follow them and their padding."""
    data = frames * SAMPLE_BYTES
    block = SAMPLE_BYTES
    middle = chunk(b"bext", _bext(time_reference, description))
    middle += chunk(b"fmt ", struct.pack("<HHIIHH", 1, 1, rate_hz, rate_hz * block, block, 8 * SAMPLE_BYTES))
    total = 4 + len(middle) + 8 + data + data % 2 + tail
    if total <= riff_limit:
        return struct.pack("<4sI4s", b"RIFF", total, b"WAVE") + middle + struct.pack("<4sI", b"data", data)
    ds64_bytes = 28
    ds64 = chunk(b"ds64", struct.pack("<QQQI", total + 8 + ds64_bytes, data, frames, 0))
    head = struct.pack("<4sI4s", b"RF64", RIFF_LIMIT, b"WAVE")
    return head + ds64 + middle + struct.pack("<4sI", b"data", RIFF_LIMIT)


def cue_chunks(cues: Sequence[Cue]) -> bytes:
    """Return the chunks after the samples: the places of the markers, then their names and lengths.

    The format counts samples with 32 bits: a marker beyond, after 12 h 25 min at 96 kHz, has no place in it and is left
    to the timeline.
    """
    cues = [cue for cue in cues if cue.sample <= MARKER_LIMIT]
    if not cues:
        return b""
    places = struct.pack("<I", len(cues))
    notes = b"adtl"
    for number, cue in enumerate(cues, start=1):
        places += struct.pack("<II4sIII", number, cue.sample, b"data", 0, 0, cue.sample)
        notes += chunk(b"labl", struct.pack("<I", number) + cue.label.encode() + b"\0")
        if cue.length:
            notes += chunk(b"ltxt", struct.pack("<II4s4H", number, min(cue.length, MARKER_LIMIT), b"rgn ", 0, 0, 0, 0))
    return chunk(b"cue ", places) + chunk(b"LIST", notes)


def written_cues(path: Path) -> tuple[Cue, ...] | None:
    """Return the markers of a drive that is, but for its samples, as it was written here; None for any other file.

    What another program has saved may have lost some markers, or have more: those of its own user.
    """
    if not path.is_file():  # a pipe would be waited for
        return None
    try:
        with path.open("rb") as file:
            start, file_bytes = file.read(_HEAD_BYTES), file.seek(0, SEEK_END)
            is_long = start.startswith(b"RF64")
            bext = start.index(b"bext") + 8
            fmt, data = (start.index(name, bext + _BEXT_BYTES) + 8 for name in (b"fmt ", b"data"))
            (size,) = struct.unpack_from("<Q", start, 28) if is_long else struct.unpack_from("<I", start, data - 4)
            end = data + size + size % 2
            head = header(
                frames=size // SAMPLE_BYTES,
                rate_hz=struct.unpack_from("<I", start, fmt + 4)[0],
                time_reference=struct.unpack_from("<Q", start, bext + 338)[0],
                description=start[bext : bext + 256].rstrip(b"\0").decode("ascii"),
                tail=file_bytes - end,
                riff_limit=0 if is_long else RIFF_LIMIT,
            )
            if not start.startswith(head) or size // SAMPLE_BYTES > MARKER_LIMIT:
                return None
            file.seek(end)
            tail = file.read()
        cues = _cues_of(tail)
    except (OSError, ValueError, struct.error):
        return None
    return cues if tail == cue_chunks(cues) else None


def _cues_of(tail: bytes) -> tuple[Cue, ...]:
    """Return the markers in what follows the samples, read as `cue_chunks` writes them; ValueError where it did not."""
    count = struct.unpack_from("<I", tail, 8)[0] if tail else 0
    samples = [struct.unpack_from("<I", tail, 16 + 24 * index)[0] for index in range(count)]
    cues, place = [], 12 + 24 * count + 12
    for sample in samples:
        (size,) = struct.unpack_from("<I", tail, place + 4)
        label = tail[place + 12 : place + 8 + size - 1].decode()
        place += 8 + size + size % 2
        length = 0
        if tail[place : place + 4] == b"ltxt":
            (length,) = struct.unpack_from("<I", tail, place + 12)
            place += 28
        cues.append(Cue(sample, label, length))
    return tuple(cues)


def _bext(time_reference: int, description: str) -> bytes:
    return struct.pack(
        "<256s32s32s10s8sQH64s190x",
        description.encode("ascii", "replace"),
        ORIGINATOR,
        b"",
        b"",
        b"",
        time_reference,
        1,
        b"",
    )

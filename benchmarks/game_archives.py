"""The sounds of a free game's package: single files, those in its archives, and the samples of SoundFonts."""

import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from zipfile import ZipFile, is_zipfile

import numpy as np
import soundfile

SOUNDS, ARCHIVES = {".wav", ".ogg", ".flac"}, {".pk3", ".wz", ".zip"}
SF2_SAMPLE = struct.Struct("<20s5I6x")
"""Name, first sample and the one after the last, both ends of the loop, rate in Hz (SoundFont 2.01, 7.10)."""


def sounds_of(folder: Path) -> Iterator[tuple[str, bytes]]:
    """Yield the sounds of an unpacked package, those in its archives too: their paths and what the files hold."""
    for path in sorted(each for each in folder.rglob("*") if each.is_file()):
        name, kind = path.relative_to(folder).as_posix(), path.suffix.lower()
        if kind in SOUNDS:
            yield name, path.read_bytes()
        elif kind in ARCHIVES and is_zipfile(path):
            yield from _in_archive(path)
        elif kind == ".sf2":
            yield from ((f"{name}/{sample}", data) for sample, data in _in_soundfont(path.read_bytes()))


def _in_archive(path: Path) -> Iterator[tuple[str, bytes]]:
    with ZipFile(path) as archive:
        for name in sorted(archive.namelist()):
            if Path(name).suffix.lower() in SOUNDS:
                yield name, archive.read(name)


def _in_soundfont(data: bytes) -> Iterator[tuple[str, bytes]]:
    pool = np.frombuffer(_riff_chunk(data, b"smpl"), "<i2")
    for name, start, end, _, _, rate_hz in SF2_SAMPLE.iter_unpack(_riff_chunk(data, b"shdr")):
        if start < end:
            file = BytesIO()
            soundfile.write(file, pool[start:end], rate_hz, format="WAV", subtype="PCM_16")
            yield name.partition(b"\0")[0].decode("latin-1"), file.getvalue()


def _riff_chunk(data: bytes, kind: bytes) -> bytes:
    start = data.index(kind) + 8
    (size,) = struct.unpack_from("<I", data, start - 4)
    return data[start : start + size]

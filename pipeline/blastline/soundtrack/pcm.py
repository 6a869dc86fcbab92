"""Uncompressed sample files (WAV, RF64, BW64, W64, AIFF, CAF) by libsndfile: any sample can be read again exactly."""

import errno
import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from io import FileIO
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import SoundtrackError
from ..plurals import counted
from ..timecode import clock
from .appended import appended_warning
from .chunks import ChunkTable, overflow_warning
from .tail import PlainWave, Tail
from .track import PIECE, Samples, Stored, TrackFacts, stamp_warnings, time_stamp

_BYTES = {"PCM_S8": 1, "PCM_U8": 1, "PCM_16": 2, "PCM_24": 3, "PCM_32": 4, "FLOAT": 4, "DOUBLE": 8}
_SHORT = frozenset({"PCM_S8", "PCM_U8", "PCM_16"})
_SHORT_STEP = np.float32(1.0 / 32_768.0)
_LONG_STEP = np.float32(2.0**-23)
_LITTLE_ENDIAN = frozenset({"WAV", "WAVEX", "RF64"})
_BIG_ENDIAN = frozenset({"AIFF", "CAF"})


class PcmTrack:
    """The samples of an uncompressed file."""

    def __init__(self, file: Any, table: ChunkTable, start: int, packed: "ShortSamples | PackedSamples | None") -> None:
        """Take over an open `soundfile.SoundFile` and what its header declares.

        `start` is the byte at which the first sample begins; `packed` reads samples of 16 and 24 bits, None others.
        """
        self._file = file
        self._packed = packed
        self._table = table
        frame_bytes = _BYTES[file.subtype] * file.channels
        is_open = table.data_bytes is None or table.goes_on
        declared = file.frames if is_open else (table.data_bytes or 0) // frame_bytes
        # libsndfile takes the chunks that follow in a W64 for sound
        self._frames = min(file.frames, declared)
        stamp = time_stamp(table.time_reference, file.samplerate)
        self.facts = TrackFacts(
            rate_hz=file.samplerate,
            channels=file.channels,
            layout=table.layout if table.layout and len(table.layout) == file.channels else None,
            declared_frames=declared,
            length="stored",
            is_integer=file.subtype.startswith("PCM_"),
            is_pcm=True,
            stored=Stored(start, frame_bytes),
            lacking_bytes=table.lacking_bytes,
            start_timecode=None if stamp.believed is None else clock(stamp.believed, file.samplerate, decimals=6),
            ignored_reference=stamp.ignored,
        )

    def pieces(self) -> Iterator[Samples]:
        """Yield all samples in order, shape (frames, channels)."""
        start = 0
        while (samples := self.read(start, PIECE)).shape[0]:
            yield samples
            start += samples.shape[0]

    def read_approximately(self, start_s: float, frames: int) -> Iterator[Samples]:
        """Yield at least so many samples, if there are, from that time on."""
        start = round(start_s * self.facts.rate_hz)
        for first in range(start, min(start + frames, self._frames), PIECE):
            yield self.read(first, PIECE)

    def read(self, start: int, frames: int) -> Samples:
        """Return up to `frames` frames from `start`, shape (frames, channels)."""
        frames = max(0, min(frames, self._frames - start))
        if self._packed is not None:
            try:
                return self._packed.read(start, frames)
            except OSError as error:
                raise SoundtrackError(f"cannot be read after sample {start}: {error.strerror}") from error
        if frames and self._file.tell() != start:
            self._file.seek(start)
        try:
            if self._file.subtype in _SHORT:
                # sixteen bits fit a float32 exactly, and this is five times faster than libsndfile's own conversion
                short = self._file.read(frames, dtype="int16", always_2d=True)
                return np.asarray(np.multiply(short, _SHORT_STEP, dtype=np.float32))
            samples: Samples = self._file.read(frames, dtype="float32", always_2d=True)
        except RuntimeError as error:
            raise SoundtrackError(f"cannot be read after sample {start}: {error}") from error
        return samples

    def warnings(self) -> list[str]:
        """Return where the header is wrong; there is no decoder that could stumble."""
        warnings = [overflow_warning(self._table)] if self._table.goes_on else []
        if self._table.appended is not None:
            warnings.append(appended_warning(self._table.appended))
        rate_hz, implied_hz = self.facts.rate_hz, self._table.implied_rate_hz
        if implied_hz not in (None, rate_hz):
            said = (
                f"the header says {rate_hz} samples a second, but as many bytes a second as {implied_hz} samples have"
            )
            warnings.append(f"{said}; {rate_hz} were believed: if that is wrong, all times are")
        return warnings + stamp_warnings(self.facts)

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        if self._packed is not None:
            self._packed.file.close()


@dataclass(frozen=True)
class ShortSamples:
    """Little-endian 16-bit samples in an open, unbuffered file: read as they are, faster than by libsndfile."""

    file: FileIO
    start: int
    channels: int

    def read(self, start: int, frames: int) -> Samples:
        """Return `frames` frames from `start`, shape (frames, channels)."""
        short = np.empty((frames, self.channels), "<i2")
        self.file.seek(self.start + start * short.itemsize * self.channels)
        there = self.file.readinto(short.reshape(-1).view(np.uint8).data) // (short.itemsize * self.channels)
        return np.asarray(np.multiply(short[:there], _SHORT_STEP, dtype=np.float32))


@dataclass(frozen=True)
class PackedSamples:
    """Little-endian 24-bit samples in an open file: unpacked here, four times as fast as by libsndfile.

    A muted drive is zeros for most of a film: a hole in the file, or else told by a comparison of memory. The file is
    unbuffered, since a search for holes moves its place.
    """

    file: FileIO
    start: int
    channels: int

    def read(self, start: int, frames: int) -> Samples:
        """Return `frames` frames from `start`, shape (frames, channels)."""
        width = 3 * self.channels
        place = self.start + start * width
        if _next_data(self.file, place) >= place + frames * width:
            return _silence(frames, self.channels)
        self.file.seek(place - 1)  # the last byte of what is before: the header, or another sample
        packed = self.file.read(1 + frames * width)
        there = max(0, len(packed) - 1)
        if packed.endswith(_no_bytes(there)):
            return _silence(there // width, self.channels)
        # three bytes and the one before them, which the shift drops: six times as fast as to copy them by threes
        whole = np.ndarray((there // width * self.channels,), "<i4", packed, strides=(3,)) >> 8
        return np.asarray(np.multiply(whole, _LONG_STEP, dtype=np.float32)).reshape(-1, self.channels)


def _next_data(file: FileIO, place: int) -> int:
    """Return where a file has the next byte that is not in a hole; `place` itself where the system cannot tell."""
    if not hasattr(os, "SEEK_DATA"):
        return place
    try:
        return os.lseek(file.fileno(), place, os.SEEK_DATA)
    except OSError as error:
        if error.errno == errno.ENXIO:  # nothing but a hole until the end
            return os.fstat(file.fileno()).st_size
        if error.errno in (errno.EINVAL, errno.ENOTSUP):
            return place
        raise


@lru_cache(maxsize=2)
def _no_bytes(count: int) -> bytes:
    return bytes(count)


@lru_cache(maxsize=2)
def _silence(frames: int, channels: int) -> Samples:
    """Return zeros that are shared, hence read-only."""
    zeros = np.zeros((frames, channels), np.float32)
    zeros.flags.writeable = False
    return zeros


def open_pcm(path: Path, table: ChunkTable | None) -> PcmTrack | None:
    """Return the track of an uncompressed file, or None where the file is anything else or was never finished.

    Raises SoundtrackError where its header says that samples lie otherwise than they are read.
    """
    if table is None or (table.data_bytes == 0 and not table.goes_on):
        return None
    import soundfile

    try:
        file = soundfile.SoundFile(PlainWave(path) if table.is_plain else path)
    except (soundfile.SoundFileError, TypeError):  # TypeError: a name that ends in .raw
        return None
    if file.subtype not in _BYTES or not (file.frames or table.goes_on):
        file.close()
        return None
    _require_frames(file, table)
    start = path.stat().st_size - table.present_bytes
    packed: ShortSamples | PackedSamples | None = None
    if file.format in _LITTLE_ENDIAN and file.endian in ("FILE", "LITTLE"):
        if file.subtype == "PCM_16":
            packed = ShortSamples(path.open("rb", buffering=0), start, file.channels)
        elif file.subtype == "PCM_24":
            packed = PackedSamples(path.open("rb", buffering=0), start, file.channels)
    return PcmTrack(_whole(file, path, start) if table.goes_on else file, table, start, packed)


def _require_frames(file: Any, table: ChunkTable) -> None:
    """Raise SoundtrackError where a frame is said to have other bytes than its samples: read in a row, they are noise.

    Some programs that write a WAV take the bytes of one sample for those of a frame: what the other numbers say holds.
    """
    width, channels = _BYTES[file.subtype], file.channels
    if table.frame_bytes not in (None, width * channels, width if table.is_wave else None):
        file.close()
        kind = f"{counted(channels, 'channel')} of {8 * width} bits"
        raise SoundtrackError(f"the header says {table.frame_bytes} bytes a frame; expected {width * channels}, {kind}")


def _whole(file: Any, path: Path, start: int) -> Any:
    """Return a file whose header declares too little, opened anew as bare samples from `start` to its end."""
    import soundfile

    endian = file.endian if file.endian != "FILE" else "BIG" if file.format in _BIG_ENDIAN else "LITTLE"
    kind = {"samplerate": file.samplerate, "channels": file.channels, "subtype": file.subtype, "endian": endian}
    file.close()
    return soundfile.SoundFile(Tail(path, start), format="RAW", **kind)

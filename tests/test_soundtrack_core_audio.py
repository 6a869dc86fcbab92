"""What channels a file of Core Audio has: by its layout, its labels or its mask."""

import struct
from pathlib import Path

import av
import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from blastline.soundtrack import open_soundtrack
from blastline.soundtrack.chunks import chunk_table
from blastline.soundtrack.layouts import taken_names

FILM_ORDER = ("FL", "FC", "FR", "SL", "SR", "LFE")
MPEG_5_1_C = struct.pack(">III", 123 << 16 | 6, 0, 0)
BY_MASK = struct.pack(">III", 1 << 16, 0b110_0000_1111, 0)
BY_LABELS = struct.pack(">III", 0, 0, 6) + b"".join(struct.pack(">I16x", label) for label in (1, 3, 2, 5, 6, 4))

LOUDSPEAKERS = {"FL", "FR", "FC", "LFE", "SL", "SR", "BL", "BR", "BC", "FLC", "FRC"}
"""What loudspeakers of cinemas are called."""


def apple(form: str, chunk: bytes, columns: NDArray[np.int16]) -> bytes:
    """Return a CAF or an AIFF of 16 bits at 48 kHz whose channels a layout chunk names."""
    frames, channels = columns.shape
    data = columns.astype(">i2").tobytes()
    if form == "caf":
        description = struct.pack(">d4sIIIII", 48_000.0, b"lpcm", 0, 2 * channels, 1, channels, 16)
        parts = ((b"desc", description), (b"chan", chunk), (b"data", bytes(4) + data))
        return b"caff" + struct.pack(">HH", 1, 0) + b"".join(struct.pack(">4sq", n, len(b)) + b for n, b in parts)
    rate = b"\x40\x0e\xbb\x80" + bytes(6)
    parts = ((b"COMM", struct.pack(">hIh", channels, frames, 16) + rate), (b"CHAN", chunk), (b"SSND", bytes(8) + data))
    body = b"AIFF" + b"".join(struct.pack(">4sI", n, len(b)) + b for n, b in parts)
    return b"FORM" + struct.pack(">I", len(body)) + body


@pytest.mark.parametrize("form", ["caf", "aiff"])
@pytest.mark.parametrize("chunk", [MPEG_5_1_C, BY_LABELS], ids=["tag", "labels"])
@pytest.mark.parametrize("place", range(6))
def test_the_layout_of_core_audio_names_the_channels(tmp_path: Path, form: str, chunk: bytes, place: int) -> None:
    """A sound in one channel is mixed as the same sound in that channel of a WAV in the usual order."""
    usual = ("FL", "FR", "FC", "LFE", "SL", "SR")
    sound = np.random.default_rng(1).integers(-9_000, 9_000, 4_800, dtype=np.int16)
    theirs, ours = (np.zeros((sound.size, 6), np.int16) for _ in range(2))
    theirs[:, place] = ours[:, usual.index(FILM_ORDER[place])] = sound
    path = tmp_path / f"film.{form}"
    path.write_bytes(apple(form, chunk, theirs))
    soundfile.write(tmp_path / "film.wav", ours, 48_000, format="WAV")
    heard = []
    for file in (path, tmp_path / "film.wav"):
        with open_soundtrack(file) as track:
            heard.append(np.concatenate([clip.heard for clip in track.blocks()]))
    np.testing.assert_array_equal(heard[0], heard[1])


@pytest.mark.parametrize("form", ["caf", "aiff"])
def test_a_mask_of_core_audio_is_that_of_a_wav(tmp_path: Path, form: str) -> None:
    path = tmp_path / f"film.{form}"
    path.write_bytes(apple(form, BY_MASK, np.zeros((480, 6), np.int16)))
    table = chunk_table(path)
    assert table is not None
    assert table.layout == ("FL", "FR", "FC", "LFE", "SL", "SR")


@pytest.mark.parametrize(
    "chunk", [b"", bytes(8), struct.pack(">III", 200 << 16 | 6, 0, 0), struct.pack(">III", 0, 0, 9), BY_LABELS[:-4]]
)
def test_a_layout_that_says_nothing_is_none(tmp_path: Path, chunk: bytes) -> None:
    (tmp_path / "film.caf").write_bytes(apple("caf", chunk, np.zeros((480, 6), np.int16)))
    table = chunk_table(tmp_path / "film.caf")
    assert table is not None
    assert table.layout is None


@pytest.mark.parametrize("tag", range(100, 200))
def test_a_tag_names_the_channels_that_it_names_to_ffmpeg(tmp_path: Path, tag: int) -> None:
    """Two channels are left and right in any case, of headphones as well."""
    path = tmp_path / "film.caf"
    for channels in range(1, 10):
        path.write_bytes(
            apple("caf", struct.pack(">III", tag << 16 | channels, 0, 0), np.zeros((48, channels), np.int16))
        )
        with av.open(path) as film:
            (names,) = taken_names(film).values()
        table = chunk_table(path)
        assert table is not None
        if LOUDSPEAKERS.issuperset(names) and names != ("FL", "FR"):
            assert table.layout == names

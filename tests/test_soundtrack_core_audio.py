"""What channels a file of Core Audio has: by its layout, its labels or its mask."""

import struct
from pathlib import Path

import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from blastline.soundtrack import open_soundtrack
from blastline.soundtrack.chunks import chunk_table

FILM_ORDER = ("FL", "FC", "FR", "SL", "SR", "LFE")
MPEG_5_1_C = struct.pack(">III", 123 << 16 | 6, 0, 0)
BY_MASK = struct.pack(">III", 1 << 16, 0b110_0000_1111, 0)
BY_LABELS = struct.pack(">III", 0, 0, 6) + b"".join(struct.pack(">I16x", label) for label in (1, 3, 2, 5, 6, 4))

NAMES = {"L": "FL", "R": "FR", "C": "FC", "LFE": "LFE", "Ls": "SL", "Rs": "SR", "Cs": "BC"}
NAMES |= {"Rls": "BL", "Rrs": "BR", "Lc": "FLC", "Rc": "FRC"}
ORDERS = {
    100: "C",
    101: "L R",
    108: "L R Ls Rs",
    109: "L R Ls Rs C",
    110: "L R Ls Rs C Cs",
    113: "L R C",
    114: "C L R",
    115: "L R C Cs",
    116: "C L R Cs",
    117: "L R C Ls Rs",
    118: "L R Ls Rs C",
    119: "L C R Ls Rs",
    120: "C L R Ls Rs",
    121: "L R C LFE Ls Rs",
    122: "L R Ls Rs C LFE",
    123: "L C R Ls Rs LFE",
    124: "C L R Ls Rs LFE",
    125: "L R C LFE Ls Rs Cs",
    126: "L R C LFE Ls Rs Lc Rc",
    127: "C Lc Rc L R Ls Rs LFE",
    128: "L R C LFE Ls Rs Rls Rrs",
    129: "L R Ls Rs C LFE Lc Rc",
    131: "L R Cs",
    132: "L R Ls Rs",
    133: "L R LFE",
    134: "L R LFE Cs",
    135: "L R LFE Ls Rs",
    136: "L R C LFE",
    137: "L R C LFE Cs",
    138: "L R Ls Rs LFE",
    139: "L R Ls Rs C Cs",
    140: "L R Ls Rs C Rls Rrs",
    141: "C L R Ls Rs Cs",
    142: "C L R Ls Rs Cs LFE",
    143: "C L R Ls Rs Rls Rrs",
    148: "L R Ls Rs C Lc Rc",
}
"""The order that CoreAudioBaseTypes.h gives of each layout tag, in the letters that it uses."""


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


@pytest.mark.parametrize(("tag", "order"), ORDERS.items())
def test_every_tag_names_its_channels_in_the_order_of_apples_header(tmp_path: Path, tag: int, order: str) -> None:
    names = tuple(NAMES[name] for name in order.split())
    chunk = struct.pack(">III", tag << 16 | len(names), 0, 0)
    path = tmp_path / "film.caf"
    path.write_bytes(apple("caf", chunk, np.zeros((480, len(names)), np.int16)))
    table = chunk_table(path)
    assert table is not None
    assert table.layout == names

"""Sample files that lost some bytes: told, however many and wherever they were; healthy ones say nothing."""

import struct
import time
from pathlib import Path

import numpy as np
import pytest
import soundfile

from blastline.errors import SoundtrackError
from sound_files import FORMATS, FRAMES, RATE_HZ, noise, read

TRAILERS = {
    "WAV": b"LIST" + struct.pack("<I", 26) + b"INFOISFT" + struct.pack("<I", 14) + b"Lavf62.12.101\0",
    "W64": b"mine" + bytes(12) + struct.pack("<q", 40 + 24) + b"\3" * 40,
    "AIFF": b"NAME" + struct.pack(">I", 40) + b"\3" * 40,
}
TRAILERS |= {"WAVEX": TRAILERS["WAV"], "RF64": TRAILERS["WAV"]}
SIZES = {"WAV": (4, "<I"), "WAVEX": (4, "<I"), "RF64": (20, "<Q"), "W64": (16, "<q"), "AIFF": (4, ">I")}
"""Where the size of the whole file stands, and how."""


def write(path: Path, container: str, subtype: str, *, frames: int = FRAMES, trailer: bytes = b"") -> int:
    """Write noise of two channels, and chunks behind it that the size of the whole counts; return where it ends."""
    soundfile.write(path, noise(frames, 2), RATE_HZ, format=container, subtype=subtype)
    data = bytearray(path.read_bytes())
    if container in ("WAVEX", "WAV", "RF64", "W64", "AIFF"):
        place, number = SIZES[container]
        data += bytes(-len(data) % (8 if container == "W64" else 2)) if trailer else b""
        (size,) = struct.unpack_from(number, data, place)
        struct.pack_into(number, data, place, size + len(trailer))
    path.write_bytes(data + trailer)
    return len(data)


def told(path: Path) -> list[str]:
    """Return the warnings about a file, or why it was refused: floats of which some bytes are lost may be none."""
    try:
        return list(read(path)[1].warnings)
    except SoundtrackError as error:
        return [str(error)]


@pytest.mark.parametrize(("container", "subtype"), FORMATS)
@pytest.mark.parametrize("followed", [False, True])
def test_bytes_that_the_sound_has_lost_are_told(
    tmp_path: Path, container: str, subtype: str, *, followed: bool
) -> None:
    if followed and container not in TRAILERS:
        pytest.skip("the header does not say how long the whole is")
    path = tmp_path / "film.sound"
    end = write(path, container, subtype, trailer=TRAILERS[container] if followed else b"")
    whole = path.read_bytes()
    rng = np.random.default_rng(FORMATS.index((container, subtype)))
    for lost in (1, 2, 3, 8, 12, int(rng.integers(1, 400)), 4_096):
        start = int(rng.integers(4_096, end - lost - 10_000))
        path.write_bytes(whole[:start] + whole[start + lost :])
        number = "1 byte is" if lost == 1 else f"{lost} bytes"
        lines = [line for line in told(path) if "the loss may be noise or play early" in line or "are NaN" in line]
        assert [f" {number}" in line or "are NaN" in line for line in lines] == [True]


@pytest.mark.parametrize(("container", "subtype"), FORMATS)
@pytest.mark.parametrize("frames", [20_000, 20_001])
@pytest.mark.parametrize("followed", [False, True])
def test_a_healthy_file_says_nothing(
    tmp_path: Path, container: str, subtype: str, frames: int, *, followed: bool
) -> None:
    path = tmp_path / "film.sound"
    trailer = TRAILERS.get(container, b"") if followed else b""
    write(path, container, subtype, frames=frames, trailer=trailer)
    assert read(path)[1].warnings == ()


@pytest.mark.parametrize(("container", "subtype"), [("WAV", "PCM_24"), ("RF64", "PCM_16"), ("AIFF", "PCM_24")])
@pytest.mark.parametrize("followed", [False, True])
def test_a_size_of_the_whole_that_is_a_little_wrong_is_no_loss(
    tmp_path: Path, container: str, subtype: str, *, followed: bool
) -> None:
    """Programs write that of the whole file, never write one, or forget what they added; nobody reads by it."""
    path = tmp_path / "film.sound"
    write(path, container, subtype, frames=20_001, trailer=TRAILERS[container] if followed else b"")
    data = bytearray(path.read_bytes())
    place, number = SIZES[container]
    (size,) = struct.unpack_from(number, data, place)
    for wrong in (0, 0xFFFFFFFF, size + 1, size + 8, size - 34, 36):
        struct.pack_into(number, data, place, wrong)
        path.write_bytes(data)
        assert read(path)[1].warnings == ()


@pytest.mark.parametrize("wrong", [0, 36, 0xFFFFFFFF])
def test_a_size_of_the_whole_that_was_never_written_hides_no_loss(tmp_path: Path, wrong: int) -> None:
    path = tmp_path / "film.wav"
    write(path, "WAV", "PCM_24")
    data = bytearray(path.read_bytes())
    struct.pack_into("<I", data, 4, wrong)
    path.write_bytes(data[:100_000] + data[100_001:])
    (line,) = read(path)[1].warnings
    assert line.startswith("by its header 1 byte is missing in the file")


def test_a_data_size_that_counts_its_head_is_no_loss_where_the_whole_is_there(tmp_path: Path) -> None:
    path = tmp_path / "film.wav"
    write(path, "WAV", "PCM_16", frames=20_000)
    data = bytearray(path.read_bytes())
    struct.pack_into("<I", data, data.index(b"data") + 4, 80_008)
    path.write_bytes(data)
    assert read(path)[1].warnings == ()


@pytest.mark.parametrize("container", ["WAV", "W64", "CAF", "AIFF"])
def test_zeros_behind_the_sound_cost_nothing_and_hide_no_other_file(tmp_path: Path, container: str) -> None:
    path = tmp_path / "film.sound"
    write(path, container, "PCM_16", frames=20_000)
    whole, zeros = path.read_bytes(), 64 << 20
    with path.open("r+b") as file:
        file.truncate(len(whole) + zeros)
    begun_s = time.process_time()
    assert read(path)[1].warnings == ()
    assert time.process_time() - begun_s < 3.0  # walked eight bytes at a time they took 11 s
    with path.open("ab") as file:
        file.write(whole)
    (line,) = read(path)[1].warnings
    assert line.startswith(f"another file begins at byte {len(whole) + zeros}, behind the sound")

"""Files that declare more or less sound than they hold: all of it read, what is missing told."""

import re
import struct
from pathlib import Path

import numpy as np
import pytest
import soundfile

from blastline.errors import SoundtrackError
from blastline.model import Span
from blastline.soundtrack import open_soundtrack
from sound_files import FRAMES, RATE_HZ, noise, read, wav


@pytest.mark.parametrize("container", ["WAV", "RF64", "W64", "AIFF", "CAF"])
def test_a_missing_end_is_noticed(tmp_path: Path, container: str) -> None:
    path = tmp_path / "film.sound"
    soundfile.write(path, noise(10 * RATE_HZ), RATE_HZ, format=container, subtype="PCM_16")
    whole = read(path)[0]
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 6 // 10])
    found, source = read(path)
    assert 0.5 * len(whole) < len(found) < 0.61 * len(whole)
    np.testing.assert_array_equal(found, whole[: len(found)])
    (warning,) = source.warnings
    told = "by its header" if container == "CAF" else "the file declares 10.000 s of sound but only"
    assert warning.startswith(told)
    assert re.search(r"\d+ bytes( are missing in the file|, or as many before it)", warning)


@pytest.mark.parametrize(("size", "warned"), [(0, True), (0xFFFFFFFF, False)])
def test_a_header_that_was_never_finished_hides_nothing(tmp_path: Path, size: int, warned: bool) -> None:
    path = wav(tmp_path / "film.wav", noise())
    expected = read(path)[0]
    data = bytearray(path.read_bytes())
    place = data.index(b"data") + 4
    data[place : place + 4] = struct.pack("<I", size)
    path.write_bytes(data)
    found, source = read(path)
    np.testing.assert_array_equal(found, expected)
    assert any("never finished" in warning for warning in source.warnings) == warned


def long_wave(form: bytes, data: bytes, declared: int) -> bytes:
    """Return 16-bit stereo with sizes of 64 bits, as RF64 (EBU Tech 3306) and BW64 (ITU-R BS.2088) have them."""
    ds64 = struct.pack("<4sIQQQI", b"ds64", 28, len(data), declared, declared // 4, 0)
    fmt = struct.pack("<4sIHHIIHH", b"fmt ", 16, 1, 2, RATE_HZ, 4 * RATE_HZ, 4, 16)
    unknown = struct.pack("<I", 0xFFFFFFFF)
    return form + unknown + b"WAVE" + ds64 + fmt + b"data" + unknown + data


@pytest.mark.parametrize("form", [b"RF64", b"BW64"])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 1.0])
def test_a_long_wave_is_read_whole_whatever_it_declares(tmp_path: Path, form: bytes, share: float) -> None:
    plain = wav(tmp_path / "plain.wav", noise(channels=2))
    expected, _ = read(plain)
    data = soundfile.read(plain, dtype="int16")[0].astype("<i2").tobytes()
    path = tmp_path / "film.wav"
    path.write_bytes(long_wave(form, data, int(share * FRAMES) * 4))
    found, source = read(path)
    np.testing.assert_array_equal(found, expected)
    assert [warning.endswith("read to the end of the file") for warning in source.warnings] == [True] * (share < 1.0)
    path.write_bytes(2 * long_wave(form, data, len(data)))  # another film behind it is none of its sound
    np.testing.assert_array_equal(read(path)[0], expected)


def plainly_sized(form: bytes, plain: bytes, *, long_size: int, riff: int = 0xFFFFFFFF) -> bytes:
    """Return a WAV with sizes of 64 bits, of which the samples' is wrong; its data chunk keeps a size of its own."""
    ds64 = struct.pack("<4sIQQQI", b"ds64", 28, 0, long_size, 0, 0)
    return form + struct.pack("<I", riff) + b"WAVE" + ds64 + plain[12:]


@pytest.mark.parametrize("form", [b"RF64", b"BW64"])
@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24", "FLOAT"])
@pytest.mark.parametrize("long_size", [0, 1_000, 10**12])
def test_a_size_of_the_data_chunk_holds_whatever_those_of_64_bits_say(
    tmp_path: Path, form: bytes, subtype: str, long_size: int
) -> None:
    """EBU Tech 3306 has them for chunks of size 0xFFFFFFFF alone; some recorders write 0 until they need them."""
    path = wav(tmp_path / "plain.wav", noise(channels=2), subtype=subtype)
    expected, _ = read(path)
    plain = path.read_bytes() + struct.pack("<4sI100x", b"LIST", 100)
    long = tmp_path / "film.wav"
    for riff in (0xFFFFFFFF, len(plain) + 28):
        long.write_bytes(plainly_sized(form, plain, long_size=long_size, riff=riff))
        found, source = read(long)
        np.testing.assert_array_equal(found, expected)
        assert source.warnings == ()
        with open_soundtrack(long) as track:
            for block in list(track.blocks()):
                np.testing.assert_array_equal(track.read(block.span).samples, block.samples)
    half = plainly_sized(form, path.read_bytes(), long_size=long_size)
    long.write_bytes(half[: len(half) // 2])
    found, source = read(long)
    np.testing.assert_array_equal(found, expected[: len(found)])
    assert 0.49 * FRAMES < len(found) < 0.5 * FRAMES
    [warning] = source.warnings
    assert ": the end is missing, " in warning


@pytest.mark.parametrize("form", [b"RF64", b"BW64"])
@pytest.mark.parametrize(
    ("place", "damage"),
    [
        (12, b"xmf "),
        (20, struct.pack("<H", 0x1234)),
        (28, struct.pack("<IH", 4 * RATE_HZ, 4)),
        (22, struct.pack("<H", 0)),
    ],
    ids=["no format", "an unknown format", "frames too long", "no channels"],
)
def test_a_damaged_long_wave_is_refused_in_one_line(tmp_path: Path, form: bytes, place: int, damage: bytes) -> None:
    plain = bytearray(wav(tmp_path / "plain.wav", noise()).read_bytes())
    plain[place : place + len(damage)] = damage
    path = tmp_path / "film.wav"
    path.write_bytes(plainly_sized(form, bytes(plain), long_size=0))
    with pytest.raises(SoundtrackError, match=r"film\.wav: ") as error:
        read(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("container", "marker", "size", "empty"),
    [
        ("W64", b"data", "<12xq", 0),
        ("W64", b"data", "<12xq", -1),
        ("W64", b"data", "<12xq", 24),
        ("AIFF", b"SSND", ">I", 8),
        ("CAF", b"data", ">q", 4),
    ],
)
def test_sample_files_that_were_never_finished_are_read_to_their_end(
    tmp_path: Path, container: str, marker: bytes, size: str, empty: int
) -> None:
    path = tmp_path / "film.sound"
    soundfile.write(path, noise(), RATE_HZ, format=container, subtype="PCM_16")
    expected, _ = read(path)
    data = bytearray(path.read_bytes())
    # the sixteen bytes of a W64 chunk's name go on behind what reads as its name
    place = data.rindex(marker, 0, 5_000) + 4
    kept = data[place : place + 12]
    struct.pack_into(size, data, place, empty)
    if container == "W64":
        data[place : place + 12] = kept
    path.write_bytes(data)
    found, source = read(path)
    np.testing.assert_array_equal(found, expected)
    assert source.warnings == ("the header was never finished; the sound was read to the end of the file",)


def declaring(path: Path, data_bytes: int) -> Path:
    """Have a WAV declare another size of its samples."""
    data = bytearray(path.read_bytes())
    place = data.index(b"data") + 4
    data[place : place + 4] = struct.pack("<I", data_bytes)
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("subtype", ["PCM_U8", "PCM_16", "PCM_24", "PCM_32", "FLOAT", "DOUBLE", "MS_ADPCM", "ULAW"])
@pytest.mark.parametrize("declared", [1, 1_001, 4_096])
def test_sound_beyond_the_declared_size_is_read_and_told(tmp_path: Path, subtype: str, declared: int) -> None:
    path = wav(tmp_path / "film.wav", noise(channels=2), subtype=subtype)
    expected, intact = read(path)
    assert intact.warnings == ()
    found, source = read(declaring(path, declared))
    np.testing.assert_array_equal(found[: len(expected)], expected)
    (warning,) = source.warnings
    assert warning.startswith(f"the header declares {declared} bytes of sound but ")
    assert warning.endswith(" follow; the sound was read to the end of the file")
    if subtype in ("PCM_24", "FLOAT"):
        assert len(found) == len(expected)
        with open_soundtrack(path) as track:
            assert track.expected_frames == FRAMES
            assert sum(len(block.span) for block in track.blocks()) == FRAMES
            np.testing.assert_array_equal(track.read(Span(5, FRAMES)).samples, found[5:].astype(np.float64))


def declaring_in(container: str, path: Path, data_bytes: int) -> Path:
    """Have an AIFF, W64 or CAF declare another size of its samples."""
    name, kind, further, gap = {
        "AIFF": (b"SSND", ">I", 8, 4),
        "W64": (b"data", "<q", 24, 16),
        "CAF": (b"data", ">q", 4, 4),
    }[container]
    data = bytearray(path.read_bytes())
    struct.pack_into(kind, data, data.index(name) + gap, data_bytes + further)
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("declared", [1_002, 4_096])
@pytest.mark.parametrize("endian", ["FILE", "LITTLE"])
@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24", "FLOAT"])
@pytest.mark.parametrize("container", ["AIFF", "W64", "CAF"])
def test_other_containers_that_declare_too_little_are_read_too(
    tmp_path: Path, container: str, subtype: str, endian: str, declared: int, seed: int
) -> None:
    if (container, subtype, endian) == ("AIFF", "FLOAT", "LITTLE"):
        pytest.skip("there is no such AIFF")
    path = tmp_path / "film.sound"
    soundfile.write(path, noise(20_000, 2, seed), RATE_HZ, format=container, subtype=subtype, endian=endian)
    expected, intact = read(path)
    assert intact.warnings == ()
    found, source = read(declaring_in(container, path, declared))
    np.testing.assert_array_equal(found, expected)
    (warning,) = source.warnings
    assert warning.startswith(f"the header declares {declared} bytes of sound but ")
    assert warning.endswith(" follow; the sound was read to the end of the file")


def test_packed_sound_beyond_the_declared_size_is_told(tmp_path: Path) -> None:
    path = tmp_path / "film.aiff"
    soundfile.write(path, noise(20_000, 2), RATE_HZ, format="AIFF", subtype="ULAW")
    found, source = read(declaring_in("AIFF", path, 4_096))
    assert len(found) == 2_048
    assert "the header declares 4096 bytes of sound but 40000 follow; what is beyond was not read" in source.warnings


@pytest.mark.parametrize(
    ("container", "trailer"),
    [
        ("AIFF", b"COMT" + struct.pack(">I", 5_000) + bytes(range(1, 101)) * 50),
        ("AIFF", b"odd1" + struct.pack(">I", 5_001) + b"\3" * 5_001 + b"\0"),
        ("CAF", b"info" + struct.pack(">q", 5_000) + bytes(range(1, 101)) * 50),
        ("CAF", b"mine" + struct.pack(">q", 5_001) + b"\3" * 5_001),
        ("W64", b"mine" + bytes(12) + struct.pack("<q", 5_001 + 24) + b"\3" * 5_001 + bytes(7)),
        ("W64", bytes(100_000)),
        ("AIFF", b"own1" + struct.pack(">I", 10) + b"\3" * 10 + bytes(9_000)),
        ("CAF", b"mine" + struct.pack(">q", 11) + b"\3" * 11 + bytes(9_000)),
        ("W64", b"mine" + bytes(12) + struct.pack("<q", 8 + 24) + b"\3" * 8 + bytes(9_000)),
    ],
)
def test_what_properly_follows_the_sound_of_other_containers_is_no_sound(
    tmp_path: Path, container: str, trailer: bytes
) -> None:
    path = tmp_path / "film.sound"
    soundfile.write(path, noise(20_000, 2), RATE_HZ, format=container, subtype="PCM_16")
    with path.open("ab") as file:
        file.write(trailer)
    found, source = read(path)
    assert (len(found), source.warnings) == (20_000, ())


def test_a_size_that_started_again_beyond_4_gib_is_seen(tmp_path: Path) -> None:
    path = wav(tmp_path / "film.wav", noise(RATE_HZ, 2))
    start, frames = path.read_bytes().index(b"data") + 8, (2**32 + 40_000) // 4
    with declaring(path, 40_000).open("r+b") as file:
        file.truncate(start + 4 * frames)  # a hole, which takes no room
    with open_soundtrack(path) as track:
        assert track.expected_frames == frames


@pytest.mark.parametrize("frames", [FRAMES, FRAMES + 1])
@pytest.mark.parametrize(
    "trailer",
    [
        b"LIST" + struct.pack("<I", 5_000) + b"INFO" + bytes(range(1, 101)) * 50,
        b"bext" + struct.pack("<I", 5_000) + b"\0" * 5_000 + b"iXML\2\0\0\0ab",
        b"id3 " + struct.pack("<I", 6_000) + b"ID3" + b"\7" * 5_997,
        b"ID3\4" + b"\7" * 6_000,
        b"odd1" + struct.pack("<I", 5_001) + b"\3" * 5_001 + b"\0",
        b"even" + struct.pack("<I", 5_000) + b"\3" * 5_000 + b"more" + struct.pack("<I", 10) + b"\3" * 10,
        b"own1" + struct.pack("<I", 10) + b"\3" * 10 + b"own2" + struct.pack("<I", 501) + b"\3" * 501 + bytes(9_001),
        b"own1" + struct.pack("<I", 10) + b"\3" * 10 + b"ID3\4" + b"\7" * 6_000,
        b"own1" + struct.pack("<I", 6_001) + b"\3" * 6_001 + b"\0TAG" + b"\7" * 125,
        b"own1" + struct.pack("<I", 10) + b"\3" * 10 + b"LIST" + struct.pack("<I", 5_000) + b"INFO" * 1_250 + bytes(99),
        b"LIST" + struct.pack("<I", 50_000) + b"cut off" * 1_000,
        bytes(100_000),
        b"crumbs" * 500,
    ],
)
def test_what_properly_follows_the_sound_is_no_sound(tmp_path: Path, trailer: bytes, frames: int) -> None:
    path = wav(tmp_path / "film.wav", noise(frames, 1), subtype="PCM_24")
    body = path.read_bytes()[: 44 + 3 * frames]
    for padding in {b"", b"\0" * (frames % 2)}:
        path.write_bytes(body + padding + trailer)
        found, source = read(path)
        assert (len(found), source.warnings) == (frames, ())

"""Headers that are damaged or unusual: the sound behind them exact, or one clear line."""

import struct
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import soundfile

from blastline.errors import SoundtrackError
from blastline.soundtrack import open_soundtrack
from sound_files import FORMATS, FRAMES, RATE_HZ, noise, read, wav


def test_a_chunk_of_odd_length_does_not_hide_the_missing_end(tmp_path: Path) -> None:
    data = noise(RATE_HZ)
    path = wav(tmp_path / "film.wav", data)
    whole = path.read_bytes()
    place = whole.index(b"data")
    path.write_bytes(whole[:place] + b"note\x03\0\0\0abc\0" + whole[place:-RATE_HZ])
    found, source = read(path)
    assert len(found) == RATE_HZ // 2
    (line,) = source.warnings
    assert line.startswith(
        "the file declares 1.000 s of sound but only 0.500 s could be read: the end is missing, 48000 b"
    )


@pytest.mark.parametrize("offset", [4, 512, 4_096])
@pytest.mark.parametrize("lost", [0, 2_000])
def test_the_offset_of_an_aiff_is_no_sound(tmp_path: Path, offset: int, lost: int) -> None:
    """Samples may be aligned to the blocks of a disk: the sound is the same, and so is what is told about it."""
    plain, aligned = tmp_path / "plain.aiff", tmp_path / "aligned.aiff"
    soundfile.write(plain, noise(), RATE_HZ, subtype="PCM_16")
    whole = plain.read_bytes()
    place = whole.index(b"SSND")
    (size,) = struct.unpack_from(">I", whole, place + 4)
    moved = whole[: place + 4] + struct.pack(">III", size + offset, offset, 0) + bytes(offset) + whole[place + 16 :]
    for path, data in ((plain, whole), (aligned, moved)):
        path.write_bytes(data[: len(data) - lost])
    expected, told = read(plain)
    found, source = read(aligned)
    np.testing.assert_array_equal(found, expected)
    assert source.warnings == told.warnings
    assert len(source.warnings) == bool(lost)


@pytest.mark.parametrize("offset", [1, 2, 480, 39_000, 2**31])
def test_an_offset_of_an_aiff_that_its_sound_has_no_room_for_is_refused(tmp_path: Path, offset: int) -> None:
    """Some byte or two before or after the sound's first, each sample is noise or early."""
    path = tmp_path / "film.aiff"
    soundfile.write(path, noise(), RATE_HZ, subtype="PCM_16")
    data = bytearray(path.read_bytes())
    struct.pack_into(">I", data, data.index(b"SSND") + 8, offset)
    path.write_bytes(data)
    with pytest.raises(SoundtrackError) as caught:
        open_soundtrack(path)
    assert str(caught.value) == (
        f"{path}: the header leaves {offset} bytes free before the sound; expected at most 0, "
        f"for its {FRAMES} frames of 1 x 16 bits"
    )


@pytest.mark.parametrize(("channels", "bits", "frame"), [(1, 16, 4), (2, 24, 8), (6, 24, 24), (2, 32, 16)])
@pytest.mark.parametrize("order", ["<", ">"])
def test_samples_in_wider_boxes_are_not_read_as_noise(
    tmp_path: Path, channels: int, bits: int, frame: int, order: str
) -> None:
    """Some headers say how many bits are used and not how many are stored; the bytes of a frame and a second tell."""
    path = tmp_path / "film.wav"
    used = channels * bits // 8
    for frame_bytes, second_bytes, is_read in (
        (used, used * RATE_HZ, True),
        (frame, used * RATE_HZ, True),  # one wrong number is no witness, and nothing depends on it
        (bits // 8, bits // 8 * RATE_HZ, True),
        (frame, frame * RATE_HZ, False),
    ):
        fmt = struct.pack(f"{order}HHIIHH", 1, channels, RATE_HZ, second_bytes, frame_bytes, bits)
        chunks = ((b"fmt ", fmt), (b"data", bytes(24 * 480)))
        body = b"WAVE" + b"".join(name + struct.pack(f"{order}I", len(chunk)) + chunk for name, chunk in chunks)
        path.write_bytes((b"RIFF" if order == "<" else b"RIFX") + struct.pack(f"{order}I", len(body)) + body)
        if is_read:
            assert read(path)[1].frames == 24 * 480 // used
            continue
        with pytest.raises(SoundtrackError) as caught:
            open_soundtrack(path)
        expected = f"{used}, {channels} channel{'s' if channels > 1 else ''} of {bits} bits"
        assert str(caught.value) == f"{path}: the header says {frame} bytes a frame; expected {expected}"


@pytest.mark.parametrize("container", ["WAV", "RF64", "W64", "AIFF"])
@pytest.mark.parametrize(("channels", "bits"), [(3, 16), (5, 16), (2, 24), (6, 24)])
def test_a_damaged_number_of_channels_or_bits_makes_no_noise(
    tmp_path: Path, container: str, channels: int, bits: int
) -> None:
    """The other numbers of the header still tell how long a frame is: sound that is read in other frames is noise."""
    path = tmp_path / "film.sound"
    soundfile.write(path, noise(480, 2), RATE_HZ, subtype="PCM_16", format=container)
    data = bytearray(path.read_bytes())
    if container == "AIFF":
        places, order = (data.index(b"COMM") + 8, data.index(b"COMM") + 14), ">"
    else:
        fmt = data.index(b"fmt ") + (24 if container == "W64" else 8)
        places, order = (fmt + 2, fmt + 14), "<"
    for place, value in zip(places, (channels, bits), strict=True):
        struct.pack_into(f"{order}H", data, place, value)
    path.write_bytes(data)
    with pytest.raises(SoundtrackError) as caught:
        open_soundtrack(path)
    expected = f"{channels * bits // 8}, {channels} channels of {bits} bits"
    assert str(caught.value) == f"{path}: the header says 4 bytes a frame; expected {expected}"


@pytest.mark.parametrize("container", ["WAV", "RF64", "W64"])
@pytest.mark.parametrize("said_hz", [44_100, 47_952, 48_001, 96_000])
def test_a_sample_rate_that_the_bytes_of_a_second_contradict_is_told(
    tmp_path: Path, container: str, said_hz: int
) -> None:
    """By a wrong rate every time of a film is wrong; a rate of 0 bytes a second says nothing of it."""
    path = tmp_path / "film.sound"
    soundfile.write(path, noise(480, 2), RATE_HZ, subtype="PCM_24", format=container)
    data = bytearray(path.read_bytes())
    assert read(path)[1].warnings == ()
    place = data.index(b"fmt ") + (28 if container == "W64" else 12)
    for second, warned in ((6 * RATE_HZ, True), (6 * said_hz, False), (0, False)):
        struct.pack_into("<II", data, place, said_hz, second)
        path.write_bytes(data)
        source = read(path)[1]
        assert source.sample_rate_hz == said_hz
        assert [f"says {said_hz} samples a second, but" in line for line in source.warnings] == [True] * warned
        assert all(f"as {RATE_HZ} samples have" in line for line in source.warnings)


@pytest.mark.parametrize("count", [0, 1, FRAMES + 1, 0xFFFFFFFF])
def test_frames_of_an_aiff_that_were_never_counted_are_read(tmp_path: Path, count: int) -> None:
    path = tmp_path / "film.aiff"
    soundfile.write(path, noise(), RATE_HZ, subtype="PCM_16")
    data = bytearray(path.read_bytes())
    expected = read(path)[0]
    struct.pack_into(">I", data, data.index(b"COMM") + 10, count)
    path.write_bytes(data)
    np.testing.assert_array_equal(read(path)[0], expected)


@pytest.mark.parametrize("second", [0, 100, 4_800])
@pytest.mark.parametrize(("container", "name"), [("WAV", "data"), ("AIFF", "SSND"), ("CAF", "data")])
def test_sound_in_two_places_is_refused(tmp_path: Path, container: str, name: str, second: int) -> None:
    """No format allows it, and decoders silently take the last chunk for the whole."""
    path = tmp_path / "film.sound"
    soundfile.write(path, noise(4_800), RATE_HZ, subtype="PCM_16", format=container)
    whole = path.read_bytes()
    place = whole.index(name.encode())
    head = struct.pack(">q" if container == "CAF" else ">I" if container == "AIFF" else "<I", 8 + 2 * second)
    path.write_bytes(whole + name.encode() + head + bytes(8 + 2 * second))
    with pytest.raises(SoundtrackError) as caught:
        open_soundtrack(path)
    assert str(caught.value) == (
        f"{path}: has a second {name} chunk at byte {len(whole)}; expected one, at byte {place}"
    )


@pytest.mark.parametrize(("container", "subtype"), FORMATS)
def test_a_damaged_header_ends_in_one_line_or_in_sound(tmp_path: Path, container: str, subtype: str) -> None:
    path = tmp_path / "film.sound"
    soundfile.write(path, noise(500, 2), RATE_HZ, format=container, subtype=subtype)
    whole = path.read_bytes()
    random = np.random.default_rng(FORMATS.index((container, subtype)))
    for _ in range(60):
        damaged = bytearray(whole)
        for place in random.integers(0, 200, random.integers(1, 5)):
            damaged[place] = random.choice([0, 1, 8, 0x7F, 0xFF, int(random.integers(256))])
        path.write_bytes(damaged)
        with suppress(SoundtrackError):
            found, source = read(path)
            assert np.isfinite(found).all()
            assert 0 < len(found) * source.channels <= len(whole)  # no sample takes less than a byte


@pytest.mark.parametrize("bytes_kept", [3, 11, 30, 43, 44])
def test_a_wav_cut_inside_its_header_is_refused(tmp_path: Path, bytes_kept: int) -> None:
    path = wav(tmp_path / "film.wav", noise())
    path.write_bytes(path.read_bytes()[:bytes_kept])
    with pytest.raises(SoundtrackError, match=r"film\.wav: (is not a sound file|no sound)"):
        open_soundtrack(path)


def test_a_wav_of_no_channels_counts_each_packet_once(tmp_path: Path) -> None:
    path = wav(tmp_path / "film.wav", noise(300_000))
    data = bytearray(path.read_bytes())
    data[22:24] = b"\0\0"
    path.write_bytes(data)
    with pytest.raises(SoundtrackError, match=r"film\.wav: (\d+) of \1 packets of sound cannot be decoded"):
        read(path)

"""Uncompressed files: every sample exact, block and cut the same, and one clear line for what cannot be read."""

import os
import struct
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from blastline.errors import SoundtrackError
from blastline.model import Clip, Source, Span
from blastline.soundtrack import Cue, Soundtrack, open_soundtrack, write_drive
from blastline.soundtrack.chunks import chunk_table
from blastline.soundtrack.recent import Recent
from blastline.timecode import clock, timecode_at

RATE_HZ = 48_000
FRAMES = 70_000
FORMATS = [
    ("WAV", "PCM_U8"),
    ("WAV", "PCM_16"),
    ("WAV", "PCM_24"),
    ("WAV", "PCM_32"),
    ("WAV", "FLOAT"),
    ("WAV", "DOUBLE"),
    ("WAVEX", "PCM_24"),
    ("RF64", "PCM_16"),
    ("W64", "PCM_24"),
    ("AIFF", "PCM_16"),
    ("AIFF", "PCM_S8"),
    ("CAF", "PCM_24"),
]


def noise(frames: int = FRAMES, channels: int = 1, seed: int = 0) -> NDArray[np.float64]:
    return np.random.default_rng(seed).uniform(-0.9, 0.9, (frames, channels))


def wav(path: Path, samples: NDArray[np.floating], *, rate_hz: int = RATE_HZ, subtype: str = "PCM_16") -> Path:
    soundfile.write(path, samples, rate_hz, subtype=subtype, format="WAV")
    return path


def read(path: Path, *, mix: str = "mains", frames: int = 65_536) -> tuple[NDArray[np.float32], Source]:
    with open_soundtrack(path, mix=mix) as track:
        blocks = list(track.blocks(frames))
        assert [block.start for block in blocks] == [frames * index for index in range(len(blocks))]
        assert all(block.samples.dtype == np.float32 for block in blocks)
        return np.concatenate([block.samples for block in blocks]), track.source()


@pytest.mark.parametrize(("container", "subtype"), FORMATS)
@pytest.mark.parametrize("channels", [1, 2, 6])
def test_every_sample_is_what_libsndfile_reads(tmp_path: Path, container: str, subtype: str, channels: int) -> None:
    path = tmp_path / "film.sound"  # the name does not matter
    soundfile.write(path, noise(channels=channels), RATE_HZ, format=container, subtype=subtype)
    expected = soundfile.read(path, dtype="float32", always_2d=True)[0]
    for channel in {0, channels - 1}:
        with open_soundtrack(path, mix=str(channel)) as track:
            assert (track.rate_hz, track.channels, track.columns) == (RATE_HZ, channels, 1)
            assert track.expected_frames == FRAMES
            samples = np.concatenate([block.samples for block in track.blocks(9999)])
            np.testing.assert_array_equal(samples[:, 0], expected[:, channel])
            cut = track.read(Span(123, 66_000))
            assert cut.start == 123
            assert cut.samples.dtype == np.float64
            np.testing.assert_array_equal(cut.samples, samples[123:66_000].astype(np.float64))
            assert track.source().warnings == ()
            assert track.source().frames == FRAMES


@pytest.mark.parametrize("subtype", ["PCM_16", "FLOAT"])
@pytest.mark.parametrize("mix", ["mains", "all", "lfe", "1,4"])
def test_the_size_of_the_blocks_changes_no_bit(tmp_path: Path, subtype: str, mix: str) -> None:
    path = wav(tmp_path / "film.wav", noise(channels=6), subtype=subtype)
    whole, source = read(path, mix=mix, frames=FRAMES)
    for frames in (7, 4096, 65_536, 65_537, 10 * FRAMES):
        np.testing.assert_array_equal(read(path, mix=mix, frames=frames)[0], whole)
    short = wav(tmp_path / "short.wav", noise(300, 6), subtype=subtype)
    np.testing.assert_array_equal(read(short, mix=mix, frames=1)[0], read(short, mix=mix)[0])
    with open_soundtrack(path, mix=mix) as track:
        assert track.columns == whole.shape[1] == (2 if mix in ("all", "lfe") else 1)
        assert sum(len(block.span) for block in track.blocks()) == source.frames == FRAMES
        for span in (Span(0, FRAMES), Span(5, 6), Span(65_530, 65_540), Span(FRAMES, FRAMES)):
            np.testing.assert_array_equal(track.read(span).samples, whole[span.start : span.stop])


def test_mono_is_stereo_with_equal_channels(tmp_path: Path) -> None:
    mono = noise()
    one, _ = read(wav(tmp_path / "mono.wav", mono))
    two, _ = read(wav(tmp_path / "stereo.wav", np.repeat(mono, 2, axis=1)))
    np.testing.assert_array_equal(one, two)


def test_the_channel_mask_names_the_channels(tmp_path: Path) -> None:
    samples = noise(100, 3)
    path = tmp_path / "film.wav"
    data = samples.astype("<f4").tobytes()
    mask_fl_fr_lfe = 0b1011
    guid = struct.pack("<HHIQ", 3, 0, 0x00100000, 0x719B3800AA000080)
    fmt = struct.pack("<HHIIHHHHI", 0xFFFE, 3, RATE_HZ, 12 * RATE_HZ, 12, 32, 22, 32, mask_fl_fr_lfe) + guid
    body = b"WAVEfmt " + struct.pack("<I", len(fmt)) + fmt + b"data" + struct.pack("<I", len(data)) + data
    path.write_bytes(b"RIFF" + struct.pack("<I", len(body)) + body)
    np.testing.assert_allclose(read(path)[0][:, 0], samples[:, :2].mean(axis=1), atol=1e-6)
    assert read(path, mix="lfe")[0].shape == (100, 2)


@pytest.mark.parametrize(("form", "order"), [(b"RIFF", "<"), (b"RIFX", ">")])
def test_the_channel_mask_is_read_in_its_byte_order(tmp_path: Path, form: bytes, order: str) -> None:
    """Left, right, centre and a single surround, not the two pairs that four channels without names are taken for."""
    kind = struct.pack(f"{order}IHH", 1, 0, 16) + b"\x80\x00\x00\xaa\x00\x38\x9b\x71"
    fmt = struct.pack(f"{order}HHIIHHHHI", 0xFFFE, 4, RATE_HZ, 8 * RATE_HZ, 8, 16, 22, 16, 0x107) + kind
    samples = np.zeros((480, 4), f"{order}i2")
    samples[:, 2] = 16_384
    body = b"WAVE" + b"".join(
        name + struct.pack(f"{order}I", len(chunk)) + chunk
        for name, chunk in ((b"fmt ", fmt), (b"data", samples.tobytes()))
    )
    path = tmp_path / "film.wav"
    path.write_bytes(form + struct.pack(f"{order}I", len(body)) + body)
    for mix in ("mains", "center"):
        np.testing.assert_array_equal(read(path, mix=mix)[0], np.full((480, 1), 0.5, np.float32))


def test_samples_that_are_no_sound_are_set_to_zero_and_counted(tmp_path: Path) -> None:
    samples = noise(channels=2)
    samples[1234:1236, 0] = np.nan, np.inf
    samples[65_540, 1] = -np.inf
    path = wav(tmp_path / "film.wav", samples, subtype="FLOAT")
    found, source = read(path, mix="0")
    assert source.warnings == ("3 samples were NaN, infinite or beyond 1e9, and were set to 0, first at sample 1234",)
    np.testing.assert_array_equal(found[1234:1236], 0.0)
    np.testing.assert_array_equal(found[1236:], samples[1236:, :1].astype(np.float32))
    with open_soundtrack(path) as track:
        mixed = np.concatenate([block.samples for block in track.blocks(999)])
        np.testing.assert_array_equal(track.read(Span(1000, 66_000)).samples, mixed[1000:66_000])
        assert np.isfinite(mixed).all()
        assert len(track.source().warnings) == 1


@pytest.mark.parametrize("absurd", [np.nan, np.inf, -np.inf, 3e38, -3e38, 2e9, -2e9])
def test_one_absurd_sample_anywhere_is_found(tmp_path: Path, absurd: float) -> None:
    samples = noise(200_000)
    samples[150_000] = absurd
    found, source = read(wav(tmp_path / "film.wav", samples, subtype="FLOAT"))
    samples[150_000] = 0.0
    np.testing.assert_array_equal(found, samples.astype(np.float32))
    assert source.warnings == ("1 sample was NaN, infinite or beyond 1e9, and was set to 0, first at sample 150000",)


@pytest.mark.parametrize(("scale", "warned"), [(1.0, False), (10.0, False), (2.0**15, True), (2.0**31 / 10.0, True)])
@pytest.mark.parametrize("at", [10, 70_000])
def test_sound_of_another_scale_is_told(tmp_path: Path, scale: float, warned: bool, at: int) -> None:
    """Programs that store whole numbers as they are in a file of floats make a film 90 dB too loud."""
    samples = np.zeros((80_000, 2))
    samples[at:, 1] = 0.5 * scale
    path = wav(tmp_path / "film.wav", samples, subtype="FLOAT")
    found, source = read(path, mix="1")
    np.testing.assert_array_equal(found[:, 0], samples[:, 1].astype(np.float32))
    above_db = 20.0 * np.log10(0.5 * scale)
    told = f"samples reach {0.5 * scale:.6g}, {above_db:.0f} dB above full scale; expected -1 to 1"
    assert [line.split(":")[0] for line in source.warnings] == ([told] if warned else [])
    assert all(line.endswith(f"first at sample {at}") for line in source.warnings)


def test_a_chunk_of_odd_length_does_not_hide_the_missing_end(tmp_path: Path) -> None:
    data = noise(RATE_HZ)
    path = wav(tmp_path / "film.wav", data)
    whole = path.read_bytes()
    place = whole.index(b"data")
    path.write_bytes(whole[:place] + b"note\x03\0\0\0abc\0" + whole[place:-RATE_HZ])
    found, source = read(path)
    assert len(found) == RATE_HZ // 2
    assert source.warnings == ("the file declares 1.000 s of sound but only 0.500 s could be read: the end is missing",)


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
    assert "the end is missing" in warning
    if container != "CAF":
        assert warning.startswith("the file declares 10.000 s of sound but only")


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


def test_the_time_of_day_goes_through_reader_and_writer(tmp_path: Path) -> None:
    path = tmp_path / "film.wav"
    blast = Clip(np.full((10, 1), 0.5), RATE_HZ, 100)
    write_drive(path, [blast], rate_hz=RATE_HZ, frames=FRAMES, time_reference=172_800_480, cues=[Cue(100, "shot", 10)])
    with open_soundtrack(path) as track:
        assert track.time_reference == 172_800_480
        samples = np.concatenate([block.samples for block in track.blocks()])
        source = track.source()
    assert samples.shape == (FRAMES, 1)
    assert np.flatnonzero(samples).tolist() == list(range(100, 110))
    assert (source.start_timecode, source.frame_rate) == ("01:00:00.010000", None)
    assert timecode_at(source, 48) == "01:00:00.011"


def test_source_names_the_file_and_its_digest(tmp_path: Path) -> None:
    source = read(wav(tmp_path / "film.wav", np.zeros((480, 1))))[1]
    assert (source.name, source.channels, source.stream, source.mix) == ("film.wav", 1, 0, "mains")
    assert source.sha256 == read(wav(tmp_path / "copy.wav", np.zeros((480, 1))))[1].sha256
    assert source.sha256 != read(wav(tmp_path / "other.wav", np.ones((480, 1))))[1].sha256


def _grow(path: Path) -> None:
    with path.open("ab") as file:
        file.write(bytes(1000))


def _shrink(path: Path) -> None:
    os.truncate(path, path.stat().st_size // 2)


def _replace(path: Path) -> None:
    other = path.with_name("other")
    other.write_bytes(path.read_bytes()[::-1])
    other.replace(path)


def _read_on(track: Soundtrack, path: Path, change: Callable[[Path], None]) -> None:
    blocks = track.blocks()
    next(blocks)
    change(path)
    list(blocks)
    track.source()


@pytest.mark.parametrize("suffix", [".wav", ".flac"])
@pytest.mark.parametrize("change", [_grow, _shrink, _replace, Path.unlink])
def test_a_file_that_changes_while_it_is_read_is_refused(
    tmp_path: Path, suffix: str, change: Callable[[Path], None]
) -> None:
    """Else its digest would be that of another sound than was heard, and its length that of neither."""
    path = tmp_path / f"film{suffix}"
    soundfile.write(path, noise(400_000), RATE_HZ, subtype="PCM_16")
    with open_soundtrack(path) as track, pytest.raises(SoundtrackError, match=f"film{suffix}: "):
        _read_on(track, path, change)


@pytest.mark.parametrize("change", [_grow, _shrink, _replace, Path.unlink])
def test_a_file_that_changes_before_it_is_read_again_is_refused(tmp_path: Path, change: Callable[[Path], None]) -> None:
    path = wav(tmp_path / "film.wav", noise())
    with open_soundtrack(path) as track:
        list(track.blocks())
        change(path)
        with pytest.raises(SoundtrackError, match=r"film\.wav: (was changed|is gone) while it is read"):
            track.read(Span(0, 10))


@pytest.mark.parametrize("share", [0.05, 0.2, 1.0])
def test_a_film_that_is_mostly_no_number_is_refused(tmp_path: Path, share: float) -> None:
    samples = noise()
    samples[: round(share * FRAMES)] = np.nan
    path = wav(tmp_path / "film.wav", samples, subtype="FLOAT")
    if share < 0.1:
        assert "NaN" in read(path)[1].warnings[0]
        return
    with pytest.raises(SoundtrackError, match=r"film\.wav: \d+ of 70000 samples are NaN"):
        read(path)


def test_a_film_that_is_silent_throughout_is_told(tmp_path: Path) -> None:
    still = np.zeros((70_000, 2))
    assert read(wav(tmp_path / "still.wav", still))[1].warnings == ("sound stream 0 is silent from beginning to end",)
    still[-1, 1] = 1e-4
    assert not read(wav(tmp_path / "last.wav", still))[1].warnings


def test_a_silent_channel_that_drives_is_told_though_what_is_heard_is_not(tmp_path: Path) -> None:
    sounding = np.random.default_rng(1).uniform(-0.3, 0.3, (4_800, 6))
    sounding[:, 3] = 0
    path = wav(tmp_path / "film.wav", sounding)
    assert any("mix lfe is silent" in line for line in read(path, mix="lfe")[1].warnings)
    assert not read(path, mix="all")[1].warnings


@pytest.mark.parametrize(("other", "warned"), [(-1.0, True), (-0.999, False), (0.0, False)])
def test_a_mix_that_is_silent_though_the_film_is_not_is_told(tmp_path: Path, other: float, warned: bool) -> None:
    """Since its channels cancel, or since the one that is asked for does not sound."""
    path = wav(tmp_path / "film.wav", noise() @ [[1.0, other]], subtype="FLOAT")
    assert any("mix mains is silent" in line for line in read(path)[1].warnings) == warned
    assert any("mix 1 is silent" in line for line in read(path, mix="1")[1].warnings) == (other == 0.0)


def test_the_order_of_use_is_kept(tmp_path: Path) -> None:
    with open_soundtrack(wav(tmp_path / "film.wav", noise())) as track:
        with pytest.raises(ValueError, match="at least 1 frame"):
            next(track.blocks(0))
        with pytest.raises(ValueError, match="not inside"):
            track.read(Span(0, 1))
        with pytest.raises(ValueError, match="once all blocks"):
            track.source()
        list(track.blocks())
        with pytest.raises(ValueError, match="decoded already"):
            next(track.blocks())
        with pytest.raises(ValueError, match="not inside"):
            track.read(Span(0, FRAMES + 1))


def test_what_is_no_file_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "empty.wav").touch()
    for name, message in ((".", "is a folder"), ("nowhere.wav", "no such file"), ("empty.wav", "is empty")):
        with pytest.raises(SoundtrackError, match=message) as caught:
            open_soundtrack(tmp_path / name)
        assert str(caught.value).startswith(str(tmp_path / name))
        assert "\n" not in str(caught.value)
    with pytest.raises(SoundtrackError, match="cannot be read: File name too long"):
        open_soundtrack(tmp_path / ("x" * 5000))


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="the administrator may read everything")
def test_a_file_without_permission_is_one_line(tmp_path: Path) -> None:
    path = wav(tmp_path / "film.wav", noise(10))
    path.chmod(0)
    with pytest.raises(SoundtrackError, match="cannot be read: Permission denied"):
        open_soundtrack(path)


@pytest.mark.parametrize("bytes_kept", [3, 11, 30, 43, 44])
def test_a_wav_cut_inside_its_header_is_refused(tmp_path: Path, bytes_kept: int) -> None:
    path = wav(tmp_path / "film.wav", noise())
    path.write_bytes(path.read_bytes()[:bytes_kept])
    with pytest.raises(SoundtrackError, match=r"film\.wav: (is not a sound file|no sound)"):
        open_soundtrack(path)


@pytest.mark.parametrize("head", [b"", b"RIFF", b"RF64", b"riff", b"FORM", b"caff", b"fLaC", b"ffconcat version 1.0\n"])
def test_garbage_is_refused(tmp_path: Path, head: bytes) -> None:
    path = tmp_path / "film.wav"
    for seed in range(5):
        path.write_bytes(head + np.random.default_rng(seed).bytes(5000))
        with pytest.raises(SoundtrackError, match=r"film\.wav: "):
            open_soundtrack(path)


def test_a_track_without_samples_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SoundtrackError, match="no sound"):
        open_soundtrack(wav(tmp_path / "film.wav", noise(0)))


def test_a_wav_of_no_channels_counts_each_packet_once(tmp_path: Path) -> None:
    path = wav(tmp_path / "film.wav", noise(300_000))
    data = bytearray(path.read_bytes())
    data[22:24] = b"\0\0"
    path.write_bytes(data)
    with pytest.raises(SoundtrackError, match=r"film\.wav: (\d+) of \1 packets of sound cannot be decoded"):
        read(path)


@pytest.mark.parametrize("rate_hz", [4_000, 500_000])
def test_a_sample_rate_beyond_reason_is_refused(tmp_path: Path, rate_hz: int) -> None:
    with pytest.raises(SoundtrackError, match=f"sample rate is {rate_hz} Hz; expected 8000 to 384000 Hz"):
        open_soundtrack(wav(tmp_path / "film.wav", noise(10), rate_hz=rate_hz))


def test_streams_and_channels_that_are_not_there_are_refused(tmp_path: Path) -> None:
    path = wav(tmp_path / "film.wav", noise(10, 2))
    with pytest.raises(SoundtrackError, match=r"film\.wav: has no sound stream 1; it has 0 \(2 channels\)"):
        open_soundtrack(path, stream=1)
    with pytest.raises(SoundtrackError, match=r"film\.wav: mix '2': there is no channel 2; the sound has 2"):
        open_soundtrack(path, mix="2")
    many = wav(tmp_path / "many.wav", noise(10, 12))
    with pytest.raises(SoundtrackError, match="does not say what its 12 channels are"):
        open_soundtrack(many)
    assert read(many, mix="11")[0].shape == (10, 1)


def test_a_name_that_is_no_text_is_refused() -> None:
    with pytest.raises(SoundtrackError, match="the name is not valid UTF-8; rename the file"):
        open_soundtrack(Path("bad\udcff.wav"))


@pytest.mark.parametrize("size", [1, 7, 100, 350])
def test_what_was_decoded_last_can_be_read_again(size: int) -> None:
    samples = np.random.default_rng(size).uniform(-1.0, 1.0, (1000, 3)).astype(np.float32)
    recent = Recent(300)
    for start in range(0, 1000, size):
        recent.append(samples[start : start + size])
        stop = min(start + size, 1000)
        span = Span(max(0, stop - 300), stop)
        there = recent.read(span)
        assert there is not None
        np.testing.assert_allclose(there, samples[span.start : span.stop], rtol=2.0**-7)
        assert recent.read(Span(stop - 1, stop + 1)) is None
    assert recent.read(Span(699, 900)) is None
    assert recent.read(Span(700, 701)) is not None


FILM_ORDER = ("FL", "FC", "FR", "SL", "SR", "LFE")
MPEG_5_1_C = struct.pack(">III", 123 << 16 | 6, 0, 0)
BY_MASK = struct.pack(">III", 1 << 16, 0b110_0000_1111, 0)
BY_LABELS = struct.pack(">III", 0, 0, 6) + b"".join(struct.pack(">I16x", label) for label in (1, 3, 2, 5, 6, 4))


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


@pytest.mark.parametrize(("form", "order"), [(b"RIFF", "<"), (b"RIFX", ">")])
@pytest.mark.parametrize("reference", [0, 48_000 * 3_600, 2**33 + 5, 2**64 - 1])
def test_a_time_stamp_is_read_in_its_byte_order_and_none_is_a_week_late(
    tmp_path: Path, form: bytes, order: str, reference: int
) -> None:
    bext = bytes(338) + struct.pack(f"{order}Q", reference) + bytes(256)
    fmt = struct.pack(f"{order}HHIIHH", 1, 1, 48_000, 96_000, 2, 16)
    data = np.arange(4_800, dtype=f"{order}i2").tobytes()
    body = b"WAVE" + b"".join(
        name + struct.pack(f"{order}I", len(chunk)) + chunk
        for name, chunk in ((b"bext", bext), (b"fmt ", fmt), (b"data", data))
    )
    path = tmp_path / "film.wav"
    path.write_bytes(form + struct.pack(f"{order}I", len(body)) + body)
    with open_soundtrack(path) as track:
        assert sum(len(clip.span) for clip in track.blocks()) == 4_800
        source = track.source()
    if reference > 7 * 86_400 * 48_000:
        assert source.start_timecode is None
        assert any("after midnight; it was ignored" in warning for warning in source.warnings)
    else:
        assert source.start_timecode == clock(reference, 48_000, decimals=6)
        assert source.warnings == ()

"""Films that hold less or more sound than they declare: told by how exactly their kind can declare it."""

import re
import struct
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from blastline.soundtrack import open_soundtrack
from blastline.soundtrack.lengths import length_warnings
from blastline.soundtrack.track import Length, TrackFacts
from coded_films import FILM_RATE, LONG, LONG_SHOTS, read
from media import RATE_HZ, impulses, require_encoder, write_media

SOUND = [impulses(LONG, LONG_SHOTS, channels=2)]
MXF_SOUND = bytes.fromhex("060e2b34010201010d01030116")
"""With this the key of each element of sound in an MXF begins."""


def mxf(path: Path) -> tuple[bytes, list[int]]:
    """Write a film and return its bytes, and where its elements of sound begin."""
    write_media(path, SOUND, codec="pcm_s24le", picture_rate=Fraction(25), picture_codec="mpeg2video")
    data = path.read_bytes()
    return data, [found.start() for found in re.finditer(re.escape(MXF_SOUND), data)]


@pytest.mark.parametrize("lost_bytes", [4_096, 20_000, 65_536])
@pytest.mark.parametrize("element", [10, 90, 200])
def test_bytes_that_an_mxf_has_lost_are_told(tmp_path: Path, lost_bytes: int, element: int) -> None:
    """The elements close up, and all that follows plays early."""
    path = tmp_path / "film.mxf"
    data, elements = mxf(path)
    assert read(path)[1].warnings == ()
    start = elements[element] + 100
    path.write_bytes(data[:start] + data[start + lost_bytes :])
    samples, source = read(path)
    assert len(samples) < LONG
    assert any("or a part before it, and what follows plays early" in line for line in source.warnings)


@pytest.mark.parametrize("bit", [0x10, 0x20, 0x40, 0x80])
def test_pictures_that_are_read_as_sound_are_told(tmp_path: Path, bit: int) -> None:
    path = tmp_path / "film.mxf"
    data, elements = mxf(path)
    damaged = bytearray(data)
    damaged[elements[90] + 17] ^= bit  # an element that is longer than it was
    path.write_bytes(damaged)
    samples, source = read(path)
    if len(samples) > LONG:
        assert any(" s were read: some may be there twice" in line for line in source.warnings)
    assert source.warnings


@pytest.mark.parametrize("codec", ["libmp3lame", "pcm_s16le"])
def test_a_block_of_an_avi_that_is_there_twice_is_told(tmp_path: Path, codec: str) -> None:
    path = tmp_path / "film.avi"
    write_media(path, SOUND, codec=codec, picture_rate=FILM_RATE)
    data = path.read_bytes()
    block = 65_536 if codec == "pcm_s16le" else 8_192
    start = len(data) // 2
    path.write_bytes(data[:start] + data[start - block : start] + data[start:])
    assert any("and what follows plays late" in line for line in read(path)[1].warnings)


KINDS: list[tuple[Length, float, float]] = [
    ("stored", 0.005, 0.05),
    ("counted", 0.005, 0.05),
    ("packets", 0.1, 0.1),
    ("rounded", 0.5, 0.1),
    ("shared", 0.5, 1.0),
]


@pytest.mark.parametrize(("length", "less_s", "more_s"), KINDS)
@pytest.mark.parametrize("unsure", [0, 12 * RATE_HZ])
def test_a_length_is_believed_as_exactly_as_it_is_declared(
    length: Length, less_s: float, more_s: float, unsure: int
) -> None:
    declared = 100 * RATE_HZ
    facts = TrackFacts(RATE_HZ, 2, None, declared, length, unsure_frames=unsure)
    least, most = declared - unsure - round(less_s * RATE_HZ), declared + round(more_s * RATE_HZ)
    for frames, told in ((least - 1, "missing"), (least, ""), (declared, ""), (most, ""), (most + 1, "plays late")):
        lines = list(length_warnings(facts, frames))
        assert [told in line for line in lines] == [True] * bool(told)
    assert not list(length_warnings(replace(facts, declared_frames=None), most + 1))


HEALTHY = [
    ("aac", "mp4", 48_000, {}),
    ("aac", "mp4", 8_000, {}),
    ("aac", "mkv", 48_000, {}),
    ("aac", "flv", 44_100, {}),
    ("aac", "mp4", 48_000, {"movflags": "frag_keyframe+empty_moov+skip_trailer", "frag_duration": "500000"}),
    ("pcm_s24le", "mov", 48_000, {"movflags": "frag_keyframe+empty_moov", "frag_duration": "500000"}),
    ("pcm_s24le", "mov", 48_000, {}),
    ("pcm_s16le", "nut", 48_000, {}),
    ("libopus", "mp4", 48_000, {}),
    ("libopus", "webm", 48_000, {}),
    ("libmp3lame", "mp4", 16_000, {}),
    ("libmp3lame", "avi", 8_000, {}),
    ("libmp3lame", "mkv", 8_000, {}),
    ("libmp3lame", "mp3", 8_000, {}),
    ("flac", "mkv", 48_000, {}),
    ("alac", "m4a", 48_000, {}),
    ("wmav2", "wma", 44_100, {}),
]


@pytest.mark.parametrize(("codec", "extension", "rate_hz", "options"), HEALTHY)
@pytest.mark.parametrize("frames", [LONG, LONG - 1_001])
def test_a_healthy_film_says_nothing(
    tmp_path: Path, codec: str, extension: str, rate_hz: int, options: dict[str, str], frames: int
) -> None:
    path = tmp_path / f"film.{extension}"
    container = {"wma": "asf", "m4a": "ipod"}.get(extension)
    samples = [impulses(frames, LONG_SHOTS)]
    try:
        write_media(path, samples, codec=codec, rate_hz=rate_hz, container_format=container, container_options=options)
    except av.error.FFmpegError as error:
        pytest.skip(f"cannot be written: {error}")
    assert read(path)[1].warnings == ()


def varying_mp3(path: Path, *, counted: bool = True) -> bytes:
    """Write an MP3 whose first half takes few bytes, and return it; `counted` says whether it tells its length."""
    require_encoder("libmp3lame")
    samples = np.random.default_rng(0).uniform(-0.3, 0.3, (LONG, 2)).astype(np.float32)
    samples[: LONG // 2] *= 1e-4
    with av.open(str(path), "w", options={"write_xing": str(int(counted))}) as container:
        stream = container.add_stream("libmp3lame", rate=RATE_HZ, layout="stereo")
        stream.codec_context.global_quality = 118 * 6
        stream.codec_context.qscale = True
        for start in range(0, LONG, 1_152):
            block = np.ascontiguousarray(samples[start : start + 1_152]).reshape(1, -1)
            frame = av.AudioFrame.from_ndarray(block, format="flt", layout="stereo")
            frame.sample_rate, frame.pts = RATE_HZ, start
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path.read_bytes()


@pytest.mark.parametrize("counted", [True, False])
def test_an_mp3_of_varying_rate_lacks_no_end(tmp_path: Path, *, counted: bool) -> None:
    """Where it does not say how long it is, FFmpeg takes the rate of its first frames for that of the whole."""
    path = tmp_path / "film.mp3"
    whole = varying_mp3(path, counted=counted)
    tag = b"ID3\3\0\0\0\0\x4e\x10" + bytes(10_000)  # as players write it before a file
    for written in (whole, tag + whole):
        path.write_bytes(written)
        with open_soundtrack(path) as track:
            assert (track.expected_frames == LONG) == counted
        assert read(path)[1].warnings == ()


@pytest.mark.parametrize("name", [b"APETAGEX", b"LYRICSBEGIN"])
def test_an_mp3_lacks_no_end_where_a_tag_with_a_picture_follows(tmp_path: Path, name: bytes) -> None:
    """Longer by more than a sixteenth than it says: FFmpeg takes the bytes of the tag for sound, and guesses."""
    path = tmp_path / "film.mp3"
    whole = varying_mp3(path)
    for share, is_counted in ((1 / 20, True), (1 / 10, False), (3.0, False)):
        path.write_bytes(whole + name + b"\1" * round(share * len(whole)))
        with open_soundtrack(path) as track:
            assert (track.expected_frames is not None) == is_counted
        assert not [line for line in read(path)[1].warnings if "declares" in line]


def test_mp3s_that_are_joined_end_to_end_are_not_told_to_be_too_short_or_too_long(tmp_path: Path) -> None:
    path = tmp_path / "film.mp3"
    whole = varying_mp3(path)
    path.write_bytes(whole + whole)
    samples, source = read(path)
    assert len(samples) == pytest.approx(2 * LONG, abs=4 * 1_152)
    assert not [line for line in source.warnings if "declares" in line]


@pytest.mark.parametrize("counted", [0, 2])
def test_an_mp3_whose_first_frame_counts_no_frames_lacks_no_end(tmp_path: Path, counted: int) -> None:
    """It may hold the name and other numbers alone."""
    path = tmp_path / "film.mp3"
    data = bytearray(varying_mp3(path))
    place = max(data.find(b"Xing", 0, 2_000), data.find(b"Info", 0, 2_000))
    struct.pack_into(">I", data, place + 4, counted)
    path.write_bytes(data)
    assert not [line for line in read(path)[1].warnings if "declares" in line]


@pytest.mark.parametrize("plays_s", [5.0, 9.5, 10.0])
def test_an_mp4_whose_sound_begins_late_and_is_trimmed_lacks_no_end(tmp_path: Path, plays_s: float) -> None:
    path = tmp_path / "film.mp4"
    write_media(path, SOUND, codec="aac", audio_delay_s=1.0)
    data = bytearray(path.read_bytes())
    place = data.index(b"elst") + 8
    assert struct.unpack_from(">IIi", data, place)[::2] == (2, -1)  # two edits, of which the first is empty
    (units_a_second,) = struct.unpack_from(">I", data, data.index(b"mvhd") + 16)
    struct.pack_into(">I", data, place + 16, round(plays_s * units_a_second))
    path.write_bytes(data)
    samples, source = read(path)
    assert len(samples) == pytest.approx(plays_s * RATE_HZ, abs=2_048)
    assert source.warnings == ()


@pytest.mark.parametrize(("extension", "codec", "picture"), [("flv", "aac", "flv"), ("nut", "aac", "mpeg4")])
@pytest.mark.parametrize(("picture_s", "sound_s"), [(5.0, 0.0), (0.0, 5.0)])
def test_what_begins_later_in_a_film_that_gives_one_length_lacks_no_end(
    tmp_path: Path, extension: str, codec: str, picture: str, picture_s: float, sound_s: float
) -> None:
    path = tmp_path / f"film.{extension}"
    write_media(
        path,
        SOUND,
        codec=codec,
        picture_rate=Fraction(25),
        picture_codec=picture,
        picture_delay_s=picture_s,
        audio_delay_s=sound_s,
    )
    assert read(path)[1].warnings == ()

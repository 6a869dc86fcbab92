"""Films and compressed sound: the right delay, nothing lost or shifted, and damage that is told."""

import errno
import re
import socket
import tempfile
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from blastline.errors import OutputError, SoundtrackError
from blastline.model import Source, Span
from blastline.soundtrack import open_soundtrack
from blastline.timebase import parse_timebase
from blastline.timecode import timecode_at
from media import RATE_HZ, impulses, onsets, write_media

SHOTS = [5_000, 47_000, 119_000]
FRAMES = 120_000
LONG_SHOTS = [5_000, 247_000, 399_000]
LONG = 480_000
FILM_RATE = Fraction(24_000, 1001)
BROKEN_OFF = "the file stops or breaks before its own end: the end of the sound is missing"

LOSSLESS = [
    ("flac", "flac", 8),
    ("flac", "mkv", 6),
    ("flac", "mp4", 2),
    ("alac", "m4a", 6),
    ("pcm_s16le", "mov", 8),
    ("pcm_s24le", "mkv", 8),
    ("pcm_s16be", "mov", 1),
    ("pcm_f32le", "mkv", 6),
]
LOSSY = [
    ("aac", "mp4", 8),  # planar 7.1
    ("aac", "mov", 1),
    ("aac", "mkv", 6),
    ("aac", "ts", 2),
    ("ac3", "mp4", 2),
    ("ac3", "mkv", 6),
    ("ac3", "ts", 6),
    ("eac3", "mkv", 6),
    ("eac3", "mp4", 1),
    ("libopus", "mkv", 8),
    ("libopus", "ogg", 2),
    ("libmp3lame", "mp3", 2),
    ("pcm_mulaw", "wav", 1),
    ("adpcm_ms", "wav", 2),
]
WITH_PICTURE = ("mkv", "mp4", "mov", "ts")


def read(path: Path, **options: Any) -> tuple[NDArray[np.float32], Source]:
    """Return all samples and the source, and require that a cut is what the pass gave."""
    with open_soundtrack(path, **options) as track:
        samples = np.concatenate([block.samples for block in track.blocks(10_007)])
        half = Span(len(samples) // 3, len(samples))
        np.testing.assert_array_equal(track.read(half).samples, samples[half.start :].astype(np.float64))
        assert track.read(half).samples.dtype == np.float64
        source = track.source()
        assert source.frames == len(samples)
        return samples, source


def shots_in_film(samples: NDArray[np.float32], source: Source) -> list[float]:
    """Return the shots' times against the picture, in samples."""
    return [shot + source.start_offset_s * source.sample_rate_hz for shot in onsets(samples[:, 0])]


@pytest.mark.parametrize(("codec", "extension", "channels"), LOSSLESS)
def test_lossless_sound_is_exact(tmp_path: Path, codec: str, extension: str, channels: int) -> None:
    written = impulses(FRAMES, SHOTS, channels=channels)
    written[:, -1] *= -1.0
    path = write_media(tmp_path / f"film.{extension}", [written], codec=codec)
    for channel in {0, channels - 1}:
        samples, source = read(path, mix=str(channel))
        np.testing.assert_array_equal(samples[:, 0], written[:, channel])
        assert (source.channels, source.sample_rate_hz, source.warnings) == (channels, RATE_HZ, ())


@pytest.mark.parametrize(("codec", "extension", "channels"), LOSSY)
def test_lossy_sound_keeps_its_delay_within_a_millisecond(
    tmp_path: Path, codec: str, extension: str, channels: int
) -> None:
    written = impulses(FRAMES, SHOTS, channels=channels)
    rate = FILM_RATE if extension in WITH_PICTURE else None
    path = write_media(tmp_path / f"film.{extension}", [written], codec=codec, picture_rate=rate)
    samples, source = read(path, mix="0")
    np.testing.assert_allclose(shots_in_film(samples, source), SHOTS, atol=48)
    assert FRAMES <= len(samples) < FRAMES + 2_400
    assert (source.channels, source.warnings) == (channels, ())
    assert source.frame_rate == (str(FILM_RATE) if rate else None)


@pytest.mark.parametrize("rate_hz", [44_100, 96_000])
def test_the_sample_rate_is_never_changed(tmp_path: Path, rate_hz: int) -> None:
    for codec, extension in (("flac", "mkv"), ("aac", "mp4")):
        written = impulses(FRAMES, SHOTS)
        path = write_media(tmp_path / f"film.{extension}", [written], codec=codec, rate_hz=rate_hz)
        samples, source = read(path)
        assert source.sample_rate_hz == rate_hz
        np.testing.assert_allclose(onsets(samples[:, 0]), SHOTS, atol=rate_hz // 1000)


def test_the_layout_of_the_container_is_used(tmp_path: Path) -> None:
    written = np.zeros((9_000, 6), np.float32)
    for channel in range(6):
        written[1000 * (channel + 1) : 1000 * (channel + 1) + 10, channel] = 0.5
    path = write_media(tmp_path / "film.mkv", [written], codec="flac")
    peaks = read(path)[0][1000:7000, 0].reshape(6, 1000).max(axis=1)
    np.testing.assert_allclose(peaks, [0.35355, 0.35355, 0.5, 0.0, 0.25, 0.25], atol=1e-4)
    low = read(path, mix="lfe")[0]
    assert low[4000, 0] == 0.0
    assert low[4000, 1] == pytest.approx(0.5 * 10**0.5)


@pytest.mark.parametrize("frames", [1, 7, 4096, 10**6])
def test_the_size_of_the_blocks_changes_no_bit(tmp_path: Path, frames: int) -> None:
    path = write_media(tmp_path / "film.mkv", [impulses(9_000, [100], channels=6)], codec="ac3")
    expected, _ = read(path, mix="all")
    with open_soundtrack(path, mix="all") as track:
        blocks = list(track.blocks(frames))
    assert all(len(block.span) == frames for block in blocks[:-1])
    np.testing.assert_array_equal(np.concatenate([block.samples for block in blocks]), expected)


@pytest.mark.parametrize(
    ("codec", "extension"),
    [
        ("aac", "mkv"),
        ("ac3", "mkv"),
        ("aac", "mp4"),
        ("ac3", "mp4"),
        ("pcm_s16le", "mov"),
        ("aac", "ts"),
        ("ac3", "ts"),
    ],
)
@pytest.mark.parametrize("delay_s", [0.0, 1 / 24, 0.5])
def test_sound_that_starts_after_the_picture(tmp_path: Path, codec: str, extension: str, delay_s: float) -> None:
    path = write_media(
        tmp_path / f"film.{extension}",
        [impulses(FRAMES, SHOTS)],
        codec=codec,
        picture_rate=Fraction(24),
        audio_delay_s=delay_s,
    )
    samples, source = read(path)
    expected = [shot + delay_s * RATE_HZ for shot in SHOTS]
    np.testing.assert_allclose(shots_in_film(samples, source), expected, atol=48)
    assert not source.warnings


@pytest.mark.parametrize("rate", [None, Fraction(15)])
def test_a_timecode_whose_frames_nothing_counts_keeps_its_hours(tmp_path: Path, rate: Fraction | None) -> None:
    path = write_media(
        tmp_path / "stem.mkv",
        [impulses(FRAMES, SHOTS)],
        codec="pcm_s16le",
        picture_rate=rate,
        timecode="01:00:00:05",
    )
    with open_soundtrack(path) as track:
        assert track.time_reference == 3600 * RATE_HZ
    with open_soundtrack(path, timebase=parse_timebase(None, "25")) as track:
        assert track.time_reference == 3600 * RATE_HZ + RATE_HZ // 5
        assert sum(len(clip.span) for clip in track.blocks()) == FRAMES
        assert track.source().warnings == ()
    _, source = read(path)
    [warning] = source.warnings
    assert "01:00:00:05" in warning
    assert "--frame-rate" in warning
    assert timecode_at(source, RATE_HZ) == "01:00:01.000"


@pytest.mark.parametrize(
    ("rate", "timecode", "reference"),
    [
        (Fraction(24), "01:00:00:00", 172_800_000),
        (Fraction(24_000, 1001), "01:00:00:00", 172_972_800),
        (Fraction(30_000, 1001), "00:59:59;28", 172_799_827 - 3203),
        (Fraction(25), "10:00:00:00", 1_728_000_000),
        (Fraction(120), "01:00:00:119", 172_847_600),
    ],
)
@pytest.mark.parametrize("extension", ["mov", "mp4", "mkv"])
def test_the_start_timecode(tmp_path: Path, extension: str, rate: Fraction, timecode: str, reference: int) -> None:
    path = write_media(
        tmp_path / f"film.{extension}",
        [impulses(FRAMES, SHOTS)],
        codec="pcm_s16le" if extension == "mov" else "aac",
        picture_rate=rate,
        timecode=timecode,
    )
    with open_soundtrack(path) as track:
        assert track.time_reference == pytest.approx(reference, abs=1)
    _, source = read(path)
    assert (source.start_timecode, source.frame_rate) == (timecode, str(rate))
    assert timecode_at(source, 0) == timecode
    if ";" in timecode:
        assert timecode_at(source, 3204) == "01:00:00;00"


@pytest.mark.parametrize("said", ["172800000", "9" * 19, "9" * 25, "9" * 5_000, "\u0661", "-5", ""])
def test_a_time_stamp_among_the_tags_is_believed_only_up_to_a_week(tmp_path: Path, said: str) -> None:
    path = write_media(
        tmp_path / "film.mov",
        [impulses(FRAMES, SHOTS)],
        codec="pcm_s16le",
        tags={"time_reference": said},
        container_options={"movflags": "use_metadata_tags"},
    )
    with open_soundtrack(path) as track:
        assert track.time_reference == (172_800_000 if said == "172800000" else 0)
        start = track.describe().start_timecode
    assert start == ("01:00:00.000000" if said == "172800000" else None)
    lines = [f"the time stamp says {said} samples, 2.41e+09 days, after midnight; it was ignored"]
    assert list(read(path)[1].warnings) == (lines if len(said) == 19 else [])


@pytest.mark.parametrize("extension", ["wav", "mkv", "flac", "mov"])
def test_a_time_stamp_survives_a_change_of_container(tmp_path: Path, extension: str) -> None:
    """FFmpeg writes that of a broadcast WAV among the tags of the file that it makes of it."""
    path = write_media(
        tmp_path / f"stem.{extension}",
        [impulses(FRAMES, SHOTS)],
        codec="flac" if extension in ("mkv", "flac") else "pcm_s16le",
        tags={"time_reference": "172800000"},
        container_options={"wav": {"write_bext": "1"}, "mov": {"movflags": "use_metadata_tags"}}.get(extension),
    )
    with open_soundtrack(path) as track:
        assert track.time_reference == 172_800_000
        assert track.describe().start_timecode == "01:00:00.000000"


@pytest.mark.parametrize(
    ("rate", "delay_s", "said", "reference"),
    [
        (Fraction(24_000, 1001), 0.0, None, 172_972_800),
        (Fraction(25), 0.5, None, 172_824_000),
        (None, 0.0, "25", 172_800_000 + 5 * RATE_HZ // 25),
        (None, 0.0, None, 172_800_000),
    ],
)
def test_a_timecode_goes_before_a_time_stamp(
    tmp_path: Path, rate: Fraction | None, delay_s: float, said: str | None, reference: int
) -> None:
    """The drive's own stamp is where the timeline's events say that the sound begins."""
    path = write_media(
        tmp_path / "film.mkv",
        [impulses(FRAMES, SHOTS)],
        codec="flac",
        picture_rate=rate,
        timecode="01:00:00:00" if rate else "01:00:00:05",
        audio_delay_s=delay_s,
        tags={"time_reference": "999999"},
    )
    with open_soundtrack(path, timebase=parse_timebase(None, said)) as track:
        assert track.time_reference == reference


@pytest.mark.parametrize("delay_s", [0.0, 0.5, 2.0])
def test_a_film_with_a_time_stamp_begins_where_its_events_do(tmp_path: Path, delay_s: float) -> None:
    """The stamp is the time of day of the picture's start; sound that begins later does so in drive and timeline."""
    path = write_media(
        tmp_path / "film.mkv",
        [impulses(FRAMES, SHOTS)],
        codec="flac",
        picture_rate=Fraction(25),
        audio_delay_s=delay_s,
        tags={"time_reference": str(3600 * RATE_HZ)},
    )
    with open_soundtrack(path) as track:
        assert track.time_reference == (3600 + delay_s) * RATE_HZ
        assert timecode_at(track.describe(), 0) == f"01:00:{int(delay_s):02}:{round(delay_s % 1 * 25 + 0.1):02}"


@pytest.mark.parametrize("rate_hz", [8_000, 44_100, 48_000, 96_000, 384_000])
def test_a_time_stamp_is_kept_to_the_sample(tmp_path: Path, rate_hz: int) -> None:
    for reference in (1, 12_345_677, 24 * 3600 * rate_hz - 1, 7 * 86_400 * rate_hz):
        path = write_media(
            tmp_path / "stem.wav",
            [impulses(480, [100])],
            codec="pcm_s16le",
            rate_hz=rate_hz,
            tags={"time_reference": str(reference)},
            container_options={"write_bext": "1"},
        )
        with open_soundtrack(path) as track:
            assert track.time_reference == reference


def test_a_rounded_frame_rate_is_the_one_it_is_meant_to_be(tmp_path: Path) -> None:
    for rate, meant in ((Fraction(23_976, 1000), "24000/1001"), (Fraction(27, 2), "27/2")):
        path = write_media(tmp_path / "film.mov", [impulses(FRAMES, SHOTS)], codec="pcm_s16le", picture_rate=rate)
        assert read(path)[1].frame_rate == meant


def test_a_film_in_fragments_keeps_its_frame_rate(tmp_path: Path) -> None:
    """Its average counts a picture too few in each: 450000/15047 for 30000/1001."""
    path = write_media(
        tmp_path / "film.mp4",
        [impulses(10 * RATE_HZ, SHOTS)],
        codec="aac",
        picture_rate=Fraction(30_000, 1001),
        container_options={"movflags": "frag_keyframe+empty_moov"},
    )
    assert read(path)[1].frame_rate == "30000/1001"


def test_a_list_of_films_is_no_film(tmp_path: Path) -> None:
    """Its digest would be that of the list, whatever becomes of the sound."""
    write_media(tmp_path / "part.flac", [impulses(FRAMES, SHOTS)], codec="flac")
    (tmp_path / "film.mkv").write_text("ffconcat version 1.0\nfile part.flac\n")
    with pytest.raises(SoundtrackError, match=r"film\.mkv: is a list of other files"):
        open_soundtrack(tmp_path / "film.mkv")


def test_the_default_track_is_taken_and_any_other_on_request(tmp_path: Path) -> None:
    main, comment = impulses(FRAMES, SHOTS), impulses(FRAMES, [60_000])
    path = write_media(
        tmp_path / "film.mkv", [comment, main], codec="flac", default_track=1, titles=["Comment", "Main"]
    )
    for stream, expected in ((None, SHOTS), (0, [60_000]), (1, SHOTS)):
        samples, source = read(path, stream=stream)
        assert onsets(samples[:, 0]) == expected
        assert source.stream == (1 if stream is None else stream)
    for stream in (2, -1):
        with pytest.raises(SoundtrackError, match=r"no sound stream .*0 \(flac, 1 channel, Comment\); 1 \(flac,"):
            open_soundtrack(path, stream=stream)


def test_a_title_that_is_no_text_is_told_as_far_as_it_is(tmp_path: Path) -> None:
    """PyAV up to 18 would refuse the film, and from 19 on gives letters that no file takes."""
    silent, loud = np.zeros((FRAMES, 2), np.float32), impulses(FRAMES, SHOTS, channels=2)
    path = write_media(tmp_path / "film.mkv", [silent, loud], codec="flac", titles=["first", "caf__ bar"])
    path.write_bytes(path.read_bytes().replace(b"caf__ bar", b"caf\xe9\xe8 bar"))
    source = read(path, stream=0)[1]
    assert source.warnings[0].endswith(
        "--stream chooses another: 1 (flac, 2 channels, caf\N{REPLACEMENT CHARACTER}\N{REPLACEMENT CHARACTER} bar)"
    )
    source.warnings[0].encode()


def test_channels_in_streams_of_their_own_are_told_unless_one_is_chosen(tmp_path: Path) -> None:
    """Masters keep 5.1 in six streams of one channel: who is not told takes the left one for the film."""
    channels = [impulses(FRAMES, SHOTS, seed=seed) for seed in range(3)]
    path = write_media(tmp_path / "film.mov", channels, codec="pcm_s16le")
    [warning] = read(path)[1].warnings
    assert warning.startswith("only sound stream 0 of 3 with one channel each is heard: --stream 0-1 joins 2 as stereo")
    assert not read(path, stream=1)[1].warnings
    pair = write_media(tmp_path / "pair.mov", [impulses(FRAMES, SHOTS, channels=2)] * 2, codec="pcm_s16le")
    assert not read(pair)[1].warnings


def test_a_film_without_sound_is_refused(tmp_path: Path) -> None:
    path = write_media(tmp_path / "film.mp4", [], codec="aac", picture_rate=Fraction(24), silent_s=1.0)
    with pytest.raises(SoundtrackError, match=r"film\.mp4: has no sound stream"):
        open_soundtrack(path)


@pytest.mark.parametrize(("codec", "kind"), [("ac3", 0xBD), ("aac", 0xC0)])
@pytest.mark.parametrize("stamp", [2**33 - 480, 5 * 90_000])
def test_a_wild_first_time_stamp_moves_nothing(tmp_path: Path, codec: str, kind: int, stamp: int) -> None:
    path = tmp_path / "film.ts"
    write_media(path, [impulses(LONG, LONG_SHOTS)], codec=codec, picture_rate=FILM_RATE, audio_delay_s=0.5)
    data = bytearray(path.read_bytes())
    place = data.index(bytes([0, 0, 1, kind])) + 9
    parts = stamp >> 30 << 33 | (stamp >> 15 & 0x7FFF) << 17 | (stamp & 0x7FFF) << 1
    data[place : place + 5] = (0x21_0001_0001 | parts).to_bytes(5, "big")  # with the marks between the parts
    path.write_bytes(data)
    with open_soundtrack(path) as track:
        assert len(track.read_approximately(5.0, 1.0)) >= RATE_HZ
    samples, source = read(path)
    expected = [shot + 0.5 * RATE_HZ for shot in LONG_SHOTS]
    np.testing.assert_allclose(shots_in_film(samples, source), expected, atol=48)
    (warning,) = source.warnings
    assert warning.endswith(" s off those that follow; these were believed")


@pytest.mark.parametrize(("codec", "extension"), [("flac", "flac"), ("flac", "mkv"), ("flac", "mp4"), ("alac", "m4a")])
def test_damage_does_not_shift_what_follows(tmp_path: Path, codec: str, extension: str) -> None:
    written = impulses(LONG, LONG_SHOTS, channels=2)
    path = write_media(tmp_path / f"film.{extension}", [written], codec=codec)
    data = bytearray(path.read_bytes())
    place = len(data) * 3 // 10
    data[place : place + 100] = np.random.default_rng(5).bytes(100)
    path.write_bytes(data)
    samples, source = read(path, mix="0")
    assert len(samples) == LONG
    np.testing.assert_array_equal(samples[200_000:, 0], written[200_000:, 0])
    changed = np.flatnonzero(samples[:, 0] != written[:, 0])
    assert changed.size
    assert changed[-1] - changed[0] < 10_000
    if codec == "flac":
        assert any("filled with silence" in warning for warning in source.warnings)


def test_a_damaged_beginning_does_not_shift_what_follows(tmp_path: Path) -> None:
    written = impulses(LONG, LONG_SHOTS)
    path = write_media(tmp_path / "film.mp4", [written], codec="flac")
    data = bytearray(path.read_bytes())
    place = data.index(b"mdat") + 4
    data[place : place + 100] = np.random.default_rng(5).bytes(100)
    path.write_bytes(data)
    samples, source = read(path)
    assert len(samples) == LONG
    assert not samples[:4_000].any()
    np.testing.assert_array_equal(samples[5_000:], written[5_000:])
    assert len(source.warnings) == 2


@pytest.mark.parametrize(
    ("codec", "extension"), [("flac", "mkv"), ("aac", "mkv"), ("ac3", "mkv"), ("aac", "mp4"), ("ac3", "ts")]
)
def test_lost_packets_do_not_shift_what_follows(tmp_path: Path, codec: str, extension: str) -> None:
    written = impulses(LONG, LONG_SHOTS, channels=2)
    path = tmp_path / f"film.{extension}"
    whole, _ = read(write_media(path, [written], codec=codec, picture_rate=FILM_RATE))
    lost = [(2.0, 2.3), (2.35, 2.4), (6.0, 6.05)]
    samples, source = read(write_media(path, [written], codec=codec, picture_rate=FILM_RATE, lost_s=lost))
    assert len(samples) == len(whole)
    np.testing.assert_allclose(shots_in_film(samples, source), LONG_SHOTS, atol=48)
    assert any("filled with silence" in warning for warning in source.warnings)
    assert not samples[int(2.1 * RATE_HZ) : int(2.2 * RATE_HZ)].any()


@pytest.mark.parametrize(
    ("codec", "extension", "options"),
    [("aac", "mkv", {}), ("flac", "mkv", {}), ("flac", "flac", {}), ("aac", "mp4", {"movflags": "faststart"})],
)
def test_a_missing_end_is_noticed(tmp_path: Path, codec: str, extension: str, options: dict[str, str]) -> None:
    path = tmp_path / f"film.{extension}"
    write_media(path, [impulses(LONG, LONG_SHOTS)], codec=codec, container_options=options)
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 6 // 10])
    samples, source = read(path)
    assert onsets(samples[:, 0])[:2] == pytest.approx(LONG_SHOTS[:2], abs=48)
    assert any(
        warning.startswith("the file declares 10.0") and "the end is missing, or a part before it" in warning
        for warning in source.warnings
    )


@pytest.mark.parametrize("picture_rate", [None, FILM_RATE])
@pytest.mark.parametrize("codec", ["pcm_s16le", "ac3", "libmp3lame"])
def test_a_missing_end_of_an_avi_is_noticed(tmp_path: Path, codec: str, picture_rate: Fraction | None) -> None:
    path = tmp_path / "film.avi"
    write_media(path, [impulses(LONG, LONG_SHOTS, channels=2)], codec=codec, picture_rate=picture_rate)
    data = path.read_bytes()
    assert read(path)[1].warnings == ()
    path.write_bytes(data + bytes(5_000))
    assert read(path)[1].warnings == ()
    path.write_bytes(data[: data.rindex(b"idx1")])  # only the index is missing
    assert read(path)[1].warnings == ()
    path.write_bytes(data[: len(data) * 6 // 10])
    warning = read(path)[1].warnings[-1]
    assert warning.startswith("the file declares 10.0")
    assert "the end is missing" in warning
    place = data.index(b"auds") + 32
    path.write_bytes((data[:place] + bytes(4) + data[place + 4 :])[: len(data) * 6 // 10])
    assert BROKEN_OFF in read(path)[1].warnings


def test_samples_that_an_avi_counts_and_does_not_have_are_told(tmp_path: Path) -> None:
    path = tmp_path / "film.avi"
    write_media(path, [impulses(LONG, LONG_SHOTS, channels=2)], codec="pcm_s16le", picture_rate=FILM_RATE)
    data = bytearray(path.read_bytes())
    place = data.index(b"01wb", len(data) // 3)
    data[place : place + 9_000] = bytes(9_000)
    path.write_bytes(data)
    samples, source = read(path)
    assert len(samples) < LONG
    assert any("or a part before it, and what follows plays early" in warning for warning in source.warnings)


@pytest.mark.parametrize("codec", ["libopus", "flac", "vorbis"])
def test_a_missing_end_of_an_ogg_is_noticed(tmp_path: Path, codec: str) -> None:
    path = tmp_path / "film.ogg"
    written = impulses(LONG, LONG_SHOTS, channels=2)
    if codec == "vorbis":
        with soundfile.SoundFile(path, "w", RATE_HZ, 2, format="OGG", subtype="VORBIS") as file:
            for start in range(0, LONG, 4_096):
                file.write(written[start : start + 4_096])
    else:
        write_media(path, [written], codec=codec, container_format="ogg")
    assert read(path)[1].warnings == ()
    data = path.read_bytes()
    for trailer in (b"TAG" + bytes(125), b"OggS"):
        path.write_bytes(data + trailer)
        assert read(path)[1].warnings == ()
    pages = [found.start() for found in re.finditer(rb"OggS\0", data)]
    spoilt = data[:-20] + bytes(20)  # FFmpeg drops a page whose checksum is wrong, and with it how long the sound is
    cuts = [data[:kept] for kept in (len(data) // 2, pages[len(pages) // 2], pages[-1], len(data) - 1)]
    for damaged in (spoilt, *cuts):
        path.write_bytes(damaged)
        assert BROKEN_OFF in read(path)[1].warnings


@pytest.mark.parametrize("flags", ["frag_keyframe+empty_moov", "frag_keyframe", "dash"])
def test_an_mp4_in_fragments_that_breaks_off_is_noticed(tmp_path: Path, flags: str) -> None:
    """Such a film declares no length, and after a damaged fragment nothing leads to the next one: half may be gone."""
    path = tmp_path / "film.mp4"
    options = {"movflags": flags, "frag_duration": "500000"}
    write_media(path, [impulses(LONG, LONG_SHOTS)], codec="aac", picture_rate=FILM_RATE, container_options=options)
    data = path.read_bytes()
    for padding in (b"", bytes(5_000)):
        path.write_bytes(data + padding)
        assert read(path)[1].warnings == ()
    places = [found.start() - 4 for found in re.finditer(b"moof", data)]
    middle = places[len(places) // 2]
    lost = bytearray(data)
    lost[middle : middle + 2_000] = bytes(2_000)
    for damaged in (bytes(lost), data[: middle + 2_000], data[:middle] + data[middle + 1_000 :]):
        path.write_bytes(damaged)
        samples, source = read(path)
        assert len(samples) < 0.7 * LONG
        assert BROKEN_OFF in source.warnings


@pytest.mark.parametrize("codec", ["aac", "ac3", "eac3"])
def test_what_damage_displaces_in_a_file_without_time_stamps_is_told(tmp_path: Path, codec: str) -> None:
    """Nothing says how much was lost: at what was one frame, half a second may be."""
    path = tmp_path / f"film.{codec}"
    write_media(path, [impulses(LONG, LONG_SHOTS)], codec=codec, container_format="adts" if codec == "aac" else codec)
    data = path.read_bytes()
    whole = read(path)[0]
    start, length = len(data) * 7 // 10, len(data) // 20
    path.write_bytes(data[:start] + bytes(length) + data[start + length :])
    samples, source = read(path)
    displaced = onsets(whole[:, 0])[-1] - onsets(samples[:, 0])[-1]
    assert displaced > 0.3 * RATE_HZ
    assert any("if more is missing there, what follows plays early" in line for line in source.warnings)
    path.write_bytes(data[:start])  # nothing follows
    assert not any("plays early" in line for line in read(path)[1].warnings)


def test_a_film_cut_before_its_index_is_refused(tmp_path: Path) -> None:
    path = write_media(tmp_path / "film.mp4", [impulses(FRAMES, SHOTS)], codec="aac")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(SoundtrackError, match="is not a sound file or film that can be read"):
        open_soundtrack(path)


@pytest.mark.parametrize("every", [1, 3])
def test_sound_that_is_mostly_damaged_is_refused(tmp_path: Path, every: int) -> None:
    path = write_media(tmp_path / "film.mp4", [impulses(LONG, LONG_SHOTS)], codec="flac")
    data = path.read_bytes()
    start, rng = data.index(b"mdat") + 4, np.random.default_rng(0)
    stop = data.index(b"moov") - 4
    size = (stop - start) // 100
    damaged = bytearray(data)
    for place in range(start, stop - size, every * size):
        damaged[place : place + size] = rng.bytes(size)
    path.write_bytes(damaged)
    with pytest.raises(SoundtrackError, match=r"film\.mp4: (\d+ of \d+ packets of sound cannot|no sound could)"):
        read(path)


def damaged(path: Path, places: Sequence[float]) -> tuple[bytes, float]:
    """Return a file with one byte flipped in the packets at these parts of it, and when the first of them plays."""
    with av.open(str(path)) as container:
        demuxed = [packet for packet in container.demux(audio=0) if packet.size]
        packets = [(bytes(packet), float((packet.pts or 0) * packet.time_base)) for packet in demuxed]
    data, searched = bytearray(path.read_bytes()), 0
    wanted = [round(place * (len(packets) - 1)) for place in places]
    for index, (packet, _) in enumerate(packets):
        searched = data.index(packet, searched)
        if index in wanted:
            data[searched + len(packet) // 2] ^= 0x55
        searched += len(packet)
    return bytes(data), packets[wanted[0]][1] - packets[0][1]


@pytest.mark.parametrize(
    ("codec", "extension"),
    [
        ("ac3", "ac3"),
        ("ac3", "mkv"),
        ("ac3", "mp4"),
        ("eac3", "eac3"),
        ("eac3", "mkv"),
        ("flac", "mkv"),
        ("flac", "mp4"),
        ("tta", "mkv"),
        ("wavpack", "wv"),
    ],
)
def test_frames_with_a_wrong_checksum_are_lost_and_told(tmp_path: Path, codec: str, extension: str) -> None:
    frames = 40 * RATE_HZ if codec == "tta" else LONG  # its packets last a second
    path = write_media(tmp_path / f"film.{extension}", [impulses(frames, LONG_SHOTS, channels=2)], codec=codec)
    whole, intact = read(path, mix="0")
    assert intact.warnings == ()
    one, place_s = damaged(path, [0.35])
    every, _ = damaged(path, np.linspace(0.0, 1.0, 1_000).tolist())
    path.write_bytes(one)
    samples, source = read(path, mix="0")
    assert len(samples) == len(whole)
    assert onsets(samples[:, 0]) == onsets(whole[:, 0])
    failed, filled = source.warnings
    assert re.match(r"1 of \d+ packets of sound could not be decoded .*, first at \d+\.\d+ s$", failed)
    assert float(failed.split()[-2]) == pytest.approx(place_s, abs=0.006)  # the delay of AC-3 is cut off
    assert filled.startswith("1 gap was filled with silence")
    path.write_bytes(every)
    with pytest.raises(SoundtrackError, match=r"(\d\d+) of \1 packets of sound cannot be decoded"):
        read(path)


def test_sound_that_changes_its_channels_is_refused(tmp_path: Path) -> None:
    parts = []
    for channels in (2, 6):
        part = write_media(tmp_path / "part.ac3", [impulses(FRAMES, SHOTS, channels=channels)], codec="ac3")
        parts.append(part.read_bytes())
    path = tmp_path / "film.ac3"
    path.write_bytes(b"".join(parts))
    with pytest.raises(
        SoundtrackError, match=r"film\.ac3: the sound changes from 2 channels at 48000 Hz to 6 channels"
    ):
        read(path)


def test_a_playlist_fetches_nothing(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(0.2)
        address = f"http://127.0.0.1:{server.getsockname()[1]}/film.ts"
        path = tmp_path / "film.m3u8"
        path.write_text(f"#EXTM3U\n#EXT-X-TARGETDURATION:5\n#EXTINF:5,\n{address}\n#EXT-X-ENDLIST\n")
        with pytest.raises(SoundtrackError, match=r"film\.m3u8: "):
            open_soundtrack(path)
        with pytest.raises(TimeoutError):
            server.accept()


def test_the_name_of_the_file_means_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written = impulses(FRAMES, SHOTS)
    path = write_media(tmp_path / "concat:film %d.txt", [written], codec="flac", container_format="flac")
    monkeypatch.chdir(tmp_path)
    np.testing.assert_array_equal(read(Path(path.name))[0], written)


def test_a_full_disk_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_media(tmp_path / "film.flac", [impulses(FRAMES, SHOTS)], codec="flac")

    class Full:
        def write(self, data: object) -> int:
            raise OSError(errno.ENOSPC, "No space left on device")

        def close(self) -> None:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(tempfile, "TemporaryFile", lambda **_: Full())
    with open_soundtrack(path, spool_folder=tmp_path) as track:
        with pytest.raises(OutputError, match="cannot keep the decoded sound here: No space left") as caught:
            list(track.blocks())
        assert str(caught.value).startswith(str(tmp_path))
    monkeypatch.undo()
    with pytest.raises(OutputError, match="nowhere: cannot keep the decoded sound here"):
        open_soundtrack(path, spool_folder=tmp_path / "nowhere")


def test_nothing_stays_in_the_spool_folder(tmp_path: Path) -> None:
    spool = tmp_path / "spool"
    spool.mkdir()
    path = write_media(tmp_path / "film.flac", [impulses(FRAMES, SHOTS)], codec="flac")
    with open_soundtrack(path, spool_folder=spool) as track:
        next(track.blocks())  # and leave in the middle
    assert not list(spool.iterdir())


@pytest.mark.parametrize(("codec", "extension"), [("flac", "mkv"), ("aac", "mp4"), ("pcm_s16le", "mov")])
@pytest.mark.parametrize("picture_rate", [None, Fraction(25)])
def test_a_container_tells_whether_it_holds_a_picture(
    tmp_path: Path, codec: str, extension: str, picture_rate: Fraction | None
) -> None:
    path = write_media(tmp_path / f"it.{extension}", [impulses(9_000, [100])], codec=codec, picture_rate=picture_rate)
    with open_soundtrack(path) as track:
        assert track.describe().has_picture == (picture_rate is not None)

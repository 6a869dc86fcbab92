"""When a film's sound begins: offsets, timecodes, time stamps, frame rates."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from blastline.soundtrack import open_soundtrack
from blastline.timebase import parse_timebase
from blastline.timecode import timecode_at
from coded_films import FRAMES, SHOTS, read, shots_in_film
from media import RATE_HZ, impulses, write_media


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

"""Streams that begin beyond what FFmpeg's probe reads of a file: where they start, and how long they are."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from blastline.soundtrack import open_soundtrack, probe
from media import impulses, onsets, write_media

RATE_HZ = 96_000
"""With 8 channels of 64 bits, 6 MB a second: the probe, of 5 MB, ends before what begins a second later."""
FRAMES = 3 * RATE_HZ // 2
SHOT = RATE_HZ // 2
PICTURE_RATE = Fraction(24)
FIRST_PICTURE = "01:00:00:00"


def write_late_picture(path: Path, *, delay_s: float, channels: int = 8, frames: int = FRAMES) -> Path:
    """Write a film whose picture begins so much later than its sound."""
    return write_media(
        path,
        [impulses(frames, [SHOT], channels=channels)],
        codec="pcm_f64le",
        rate_hz=RATE_HZ,
        picture_rate=PICTURE_RATE,
        picture_delay_s=delay_s,
        timecode=FIRST_PICTURE,
    )


def write_late_sound(path: Path, *, delay_s: float) -> Path:
    """Write a film of 11 MB a second whose sound begins so much later than its picture."""
    return write_media(
        path,
        [impulses(FRAMES, [SHOT])],
        codec="pcm_s16le",
        rate_hz=RATE_HZ,
        picture_rate=PICTURE_RATE,
        picture_codec="rawvideo",
        picture_size=(640, 480),
        audio_delay_s=delay_s,
    )


def told_starts(path: Path) -> list[int | None]:
    """Return where PyAV says that the streams of a file start, its picture first."""
    with av.open(str(path)) as container:
        return [stream.start_time for stream in container.streams]


@pytest.mark.parametrize("extension", ["mkv", "nut", "mov"])
def test_a_late_picture_begins_with_its_first_packet(tmp_path: Path, extension: str) -> None:
    path = write_late_picture(tmp_path / f"film.{extension}", delay_s=1.0)
    assert extension == "mov" or told_starts(path)[0] == 0  # where the probe did not reach
    with open_soundtrack(path) as track:
        samples = np.concatenate([clip.samples for clip in track.blocks()])
        source = track.source()
        if extension != "nut":  # which keeps no timecode
            assert track.time_reference == 3599 * RATE_HZ
    assert (source.start_offset_s, source.warnings) == (-1.0, ())
    assert (len(samples), onsets(samples[:, 0])) == (FRAMES, [SHOT])


@pytest.mark.parametrize("extension", ["ts", "vob", "mpg"])
@pytest.mark.parametrize("delay_s", [2, 12])
def test_a_late_picture_of_a_transport_or_program_stream_begins_with_its_first_packet(
    tmp_path: Path, extension: str, delay_s: int
) -> None:
    """By its first packet, which the probe, of 5 MB or 5 s, does not see in the second case; nor does it see a rate."""
    rate_hz, late = 48_000, SHOT + 14 * 48_000
    path = write_media(
        tmp_path / f"film.{extension}",
        [impulses(20 * rate_hz, [late], channels=2)],
        codec="ac3",
        rate_hz=rate_hz,
        picture_rate=Fraction(25),
        picture_codec="mpeg2video",
        picture_delay_s=delay_s,
    )
    with open_soundtrack(path) as track:
        assert sum(len(clip.span) for clip in track.blocks()) > 0
        source = track.source()
    assert source.start_offset_s == pytest.approx(-delay_s, abs=0.1)
    assert source.frame_rate == (None if delay_s == 12 else "25")


def test_a_film_that_does_not_say_its_length_says_as_much_of_its_picture(tmp_path: Path) -> None:
    sound = impulses(FRAMES, [SHOT], channels=8)
    options: dict[str, Any] = {"codec": "pcm_f64le", "rate_hz": RATE_HZ, "picture_rate": PICTURE_RATE}
    path = write_media(tmp_path / "live.mkv", [sound], picture_delay_s=1.25, container_options={"live": "1"}, **options)
    assert told_starts(path)[0] is None
    with open_soundtrack(path) as track:
        assert track.describe().start_offset_s == -1.25


def test_a_picture_is_not_sought_for_ever(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_late_picture(tmp_path / "film.mkv", delay_s=1.2)
    monkeypatch.setattr(probe, "_SOUGHT_S", 1)
    with open_soundtrack(path) as track:
        assert sum(len(clip.span) for clip in track.blocks()) == FRAMES
        source = track.source()
    [warning] = source.warnings
    assert warning.startswith("its picture has no frame in the first")
    assert (source.start_offset_s, source.has_picture) == (0.0, True)


@pytest.mark.parametrize("begins_s", [0.0, 3.0])
def test_for_how_long_a_picture_is_sought_counts_from_where_the_film_begins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, begins_s: float
) -> None:
    sound = impulses(FRAMES, [SHOT], channels=8)
    options: dict[str, Any] = {"codec": "pcm_f64le", "rate_hz": RATE_HZ, "picture_rate": PICTURE_RATE}
    options |= {"audio_delay_s": begins_s, "picture_delay_s": begins_s + 1.0}
    path = write_media(tmp_path / "film.mkv", [sound], **options)
    monkeypatch.setattr(probe, "_SOUGHT_S", 4)
    with open_soundtrack(path) as track:
        assert track.describe().start_offset_s == -1.0


def test_a_track_without_pictures_is_told(tmp_path: Path) -> None:
    path = write_late_picture(tmp_path / "film.mkv", delay_s=60.0, channels=1)  # later than the film lasts
    with open_soundtrack(path) as track:
        assert sum(len(clip.span) for clip in track.blocks()) == FRAMES
        [warning] = track.source().warnings
    assert warning.startswith("its picture has no frame")


@pytest.mark.parametrize(("extension", "delay_s"), [("mkv", 0.0), ("mkv", 0.5), ("mov", 1.0)])
def test_a_film_whose_picture_the_probe_saw_is_opened_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, extension: str, delay_s: float
) -> None:
    path = write_late_picture(tmp_path / f"film.{extension}", delay_s=delay_s)
    monkeypatch.setattr(probe, "_sought_start", lambda stream: pytest.fail("the film was opened again"))
    with open_soundtrack(path) as track:
        assert track.describe().start_offset_s == -delay_s


def test_late_sound_that_is_whole_lacks_no_end(tmp_path: Path) -> None:
    path = write_late_sound(tmp_path / "film.mkv", delay_s=0.75)
    assert told_starts(path)[1] == 0  # where the probe did not reach
    with open_soundtrack(path) as track:
        assert track.expected_frames == FRAMES
        assert sum(len(clip.span) for clip in track.blocks()) == FRAMES
        source = track.source()
    assert (source.start_offset_s, source.warnings) == (0.75, ())


def test_late_sound_that_is_cut_lacks_its_end(tmp_path: Path) -> None:
    path = write_late_sound(tmp_path / "film.mkv", delay_s=0.75)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 8 // 10])
    with open_soundtrack(path) as track:
        assert sum(len(clip.span) for clip in track.blocks()) < FRAMES
        [warning] = track.source().warnings
    assert warning.startswith("the file declares 1.500 s of sound")


def test_a_rough_look_counts_from_where_late_sound_begins(tmp_path: Path) -> None:
    path = write_late_sound(tmp_path / "film.mkv", delay_s=0.75)
    with open_soundtrack(path, rereadable=False) as track:
        [onset] = onsets(track.read_approximately(0.25, 1.0)[:, 0])
    packet = 4_096
    assert SHOT - RATE_HZ // 4 - packet <= onset <= SHOT - RATE_HZ // 4

"""Streams of one channel each, joined: the same film as one stream with all channels, to the bit."""

from collections.abc import Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path

import msgspec
import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from blastline.errors import RuleError, SoundtrackError
from blastline.model import Timeline
from blastline.soundtrack import open_soundtrack
from blastline.soundtrack.singles import joining_hint, layout_of
from blastline.streams import parse_streams, streams_text
from blastline.synth import Scene, render_scene
from commands import blastline
from media import RATE_HZ, impulses, write_media
from single_films import FRAMES, SIX, Single, apart, different, heard, write_singles

SCENE = {
    "schema": 1,
    "rate_hz": RATE_HZ,
    "duration_s": 2.5,
    "seed": 15,
    "layout": "5.1",
    "beds": [{"kind": "ambience", "level_dbfs": -60.0}],
    "shots": [
        {"at_s": at_s, "weapon": weapon, "environment": "street", "distance_m": 12.0, "snr_db": 34.0}
        for at_s, weapon in ((0.5, "rifle"), (1.6, "pistol"))
    ],
}


def test_six_streams_are_the_film_of_one_stream_to_the_bit(tmp_path: Path) -> None:
    scene = render_scene(msgspec.convert(SCENE, Scene))
    samples = scene.read(0, scene.frames)
    film = (np.rint(samples * (0.5 / np.abs(samples).max()) * 32_768) / 32_768).astype(np.float32)
    write = partial(write_media, codec="pcm_s16le", picture_rate=Fraction(25), timecode="01:00:00:00")
    whole, split = write(tmp_path / "whole.mov", [film]), write(tmp_path / "split.mov", apart(film))
    timelines: list[Timeline] = []
    common = ("--quality", "draft", "--no-report", "--quiet")
    for path, stream in ((whole, "0"), (split, "0-5")):
        done = blastline("render", path, "-o", tmp_path / path.stem, "--stream", stream, *common)
        assert (done.code, done.err) == (0, "")
        timelines.append(msgspec.json.decode((tmp_path / path.stem / "timeline.json").read_bytes(), type=Timeline))
    one, six = timelines
    assert len(one.events) >= 2
    assert any(event.azimuth_deg is not None for event in one.events)
    assert (six.events, six.rejections, six.checks) == (one.events, one.rejections, one.checks)
    for key in ("sample_rate_hz", "frames", "channels", "start_timecode", "frame_rate", "start_offset_s", "mix"):
        assert getattr(six.source, key) == getattr(one.source, key)
    assert (one.source.stream, six.source.stream) == (0, SIX)
    drive = drive_of(tmp_path / "split")
    assert np.any(drive)
    assert np.array_equal(drive, drive_of(tmp_path / "whole"))
    # what was made of it later on finds the same sound
    assert blastline("check", tmp_path / "split", "--quiet").code == 0
    edited = tmp_path / "split" / "timeline.csv"
    line = blastline("render", split, "-o", tmp_path / "again", "--timeline", edited, *common).complaint
    assert line.endswith("is of sound stream 0-5 of split.mov, not 0; give --stream 0-5")
    options = ("--timeline", edited, "--stream", "0,1,2,3,4,5")
    assert blastline("render", split, "-o", tmp_path / "again", *options, *common).code == 0
    assert np.array_equal(drive_of(tmp_path / "again"), drive)


def drive_of(folder: Path) -> NDArray[np.int32]:
    return np.asarray(soundfile.read(folder / "drive.wav", dtype="int32")[0])


@pytest.mark.parametrize(
    ("codec", "extension"), [("pcm_s16le", "mov"), ("pcm_s24le", "mkv"), ("pcm_s16le", "avi"), ("alac", "mp4")]
)
def test_joined_samples_are_those_of_one_stream_whatever_the_block(tmp_path: Path, codec: str, extension: str) -> None:
    film = different()
    split = write_media(tmp_path / f"split.{extension}", apart(film), codec=codec)
    whole = write_media(tmp_path / "whole.mkv", [film], codec="pcm_s16le")
    expected, _ = heard(whole, stream=None)
    for frames in (65_536, 7_001):
        found, source = heard(split, stream=SIX, frames=frames)
        assert np.array_equal(found, expected)
    assert (source.channels, source.warnings) == (6, ())
    for channel in (0, 3, 5):
        alone, _ = heard(split, stream=SIX, mix=str(channel))
        assert np.array_equal(alone[:, 0], film[:, channel])


def test_the_order_that_is_given_is_that_of_the_channels(tmp_path: Path) -> None:
    film = different()
    shuffled = write_media(tmp_path / "film.mov", apart(film[:, [0, 2, 1, 4, 5, 3]]), codec="pcm_s16le")
    ordered = write_media(tmp_path / "ordered.mov", apart(film), codec="pcm_s16le")
    assert np.array_equal(heard(shuffled, stream=(0, 2, 1, 5, 3, 4))[0], heard(ordered, stream=SIX)[0])


def test_a_rough_look_at_joined_streams_is_at_the_same_moment_of_each(tmp_path: Path) -> None:
    film = np.repeat(different(channels=1), 2, axis=1)
    path = write_media(tmp_path / "film.mov", apart(film), codec="pcm_s16le")
    with open_soundtrack(path, stream=(0, 1), mix="mains", rereadable=False) as track:
        both = track.read_approximately(1.0, 0.5, sides=True)
    assert both.shape[0] >= 0.5 * RATE_HZ
    assert np.any(both[:, 0])
    assert not np.any(both[:, 1])  # two equal channels have nothing beside their middle


def test_streams_that_are_not_channels_of_one_sound_are_refused(tmp_path: Path) -> None:
    def complaint(path: Path, *streams: int) -> str:
        with pytest.raises(SoundtrackError) as error:
            open_soundtrack(path, stream=streams)
        return str(error.value).removeprefix(f"{path}: ")

    one, two = impulses(20_000, [100]), impulses(20_000, [100], channels=2)
    mixed = write_media(tmp_path / "mixed.mov", [one, two, one], codec="pcm_s16le")
    assert complaint(mixed, 0, 1) == ("sound stream 1 has 2 channels; expected one in each stream that is joined")
    assert complaint(mixed, 0, 3).startswith("has no sound stream 3; it has 0 (pcm_s16le, 1 channel")
    late = write_singles(tmp_path / "late.mkv", Single(one), Single(one, start_s=0.5))
    assert complaint(late, 0, 1) == (
        "sound stream 1 begins +0.500000 s off stream 0, with which it is joined; expected the same start"
    )
    rates = write_singles(tmp_path / "rates.mkv", Single(one), Single(one, rate_hz=44_100))
    assert "has 44100 Hz; expected 48000 Hz" in complaint(rates, 0, 1)
    wave = write_media(tmp_path / "film.wav", [two], codec="pcm_s16le")
    assert complaint(wave, 0, 1) == "has no sound stream 0-1; it has 0 (2 channels)"


@pytest.mark.parametrize("start_s", [0.0, 0.5])
def test_streams_that_begin_late_together_are_joined_where_they_begin(tmp_path: Path, start_s: float) -> None:
    one, two = impulses(20_000, [100]), impulses(20_000, [7_000])
    path = write_singles(tmp_path / "late.mkv", Single(one, start_s=start_s), Single(two, start_s=start_s))
    alone, joined = heard(path, stream=0), heard(path, stream=(0, 1))
    assert (joined[1].start_offset_s, joined[1].frames) == (alone[1].start_offset_s, alone[1].frames)


def test_a_stream_that_ends_early_is_told_and_silent_from_there_on(tmp_path: Path) -> None:
    film = different(channels=2)
    path = write_media(tmp_path / "film.mov", [film[:, :1], film[:48_000, 1:]], codec="pcm_s16le")
    found, source = heard(path, stream=(0, 1), mix="1")
    assert np.array_equal(found[:48_000, 0], film[:48_000, 1])
    assert found.shape[0] == FRAMES
    assert not np.any(found[48_000:])
    assert source.warnings == ("sound stream 1: ends at 1.000 s, others at 2.083 s: silence was put in its place",)


def test_damage_is_told_with_its_stream_and_moves_no_channel(tmp_path: Path) -> None:
    film = different(channels=2)
    whole, damaged = apart(film)
    path = write_singles(tmp_path / "film.mkv", Single(whole), Single(damaged, lost_s=(0.5, 1.0)))
    found, source = heard(path, stream=(0, 1), mix="1")
    [warning] = source.warnings
    assert warning.startswith("sound stream 1: 1 gap was filled with silence")
    assert found.shape[0] == FRAMES
    kept = found[:, 0] == film[:, 1]
    assert kept[: RATE_HZ // 2].all()
    assert kept[RATE_HZ + 4_096 :].all()


@pytest.mark.parametrize(
    ("singles", "told"),
    [
        ((0, 1), "--stream 0-1 joins 2 as stereo"),
        ((0, 1, 2, 3), "--stream 0-1 joins 2 as stereo"),
        (SIX, "--stream 0-5 joins 6 as 5.1"),
        ((1, 2, 3, 4, 5, 6), "--stream 1-6 joins 6 as 5.1"),
        (tuple(range(8)), "--stream 0-5 joins 6 as 5.1, --stream 0-7 joins 8 as 7.1"),
        (tuple(range(16)), "--stream 0-5 joins 6 as 5.1, --stream 0-7 joins 8 as 7.1"),
    ],
)
def test_the_warning_says_what_to_type(singles: Sequence[int], told: str) -> None:
    line = joining_hint(singles[0], singles)
    assert f"only sound stream {singles[0]} of {len(singles)} with one channel each is heard: {told}; " in line


def test_a_file_that_names_its_channels_is_believed_and_others_are_in_the_usual_order() -> None:
    named = (("FC",), ("FL",), ("FR",))
    assert layout_of(named) == ("FC", "FL", "FR")
    mono = ("FC",)
    assert layout_of([mono] * 6) == ("FL", "FR", "FC", "LFE", "SL", "SR")
    assert layout_of([None] * 8) == ("FL", "FR", "FC", "LFE", "SL", "SR", "BL", "BR")
    assert layout_of([mono] * 2) == ("FL", "FR")
    assert layout_of([mono] * 5) == ()
    assert layout_of([("FL",), ("FR",), *[mono] * 4]) == ("FL", "FR", "FC", "LFE", "SL", "SR")
    film = [(name,) for name in ("FL", "FR", "FC", "LFE", "SL", "SR")]
    assert layout_of([*film, ("FL",), ("FR",)]) == ()  # a stereo mix is no rear pair
    assert layout_of([mono, ("FL",), ("FR",), mono, mono, mono]) == ()


@pytest.mark.parametrize("streams", [(0, 1, 2), (0, 1, 2, 3), (0, 1, 2, 3, 4)])
def test_some_streams_of_a_master_are_no_mains_unless_the_file_names_them(
    tmp_path: Path, streams: tuple[int, ...]
) -> None:
    """The fourth of six is the low-frequency channel, the fourth of four may be a surround: neither is guessed."""
    film = different()
    unnamed = write_media(tmp_path / "unnamed.mov", apart(film), codec="pcm_s16le")
    for mix in ("mains", "all", "lfe", "center"):
        with pytest.raises(SoundtrackError, match=f"does not say what its {len(streams)} channels are; choose"):
            open_soundtrack(unnamed, stream=streams, mix=mix)
    mean, _ = heard(unnamed, stream=streams, mix=",".join(map(str, streams)))
    np.testing.assert_allclose(mean[:, 0], film[:, : len(streams)].mean(axis=1), atol=1e-6)
    names = ("FL", "FR", "FC", "LFE", "SL", "SR")
    parts = zip(apart(film), names, strict=True)
    named = write_singles(tmp_path / "named.mov", *(Single(samples, channel=name) for samples, name in parts))
    silent = film * np.isin(np.arange(6), [each for each in streams if names[each] != "LFE"])
    expected, _ = heard(write_media(tmp_path / "whole.mkv", [silent], codec="pcm_s16le"), stream=None)
    assert np.array_equal(heard(named, stream=streams)[0], expected)


@pytest.mark.parametrize(
    ("text", "streams", "again"),
    [
        ("3", 3, "3"),
        ("0-5", SIX, "0-5"),
        ("0,1,2,3,4,5", SIX, "0-5"),
        ("0-2, 5,3-4", (0, 1, 2, 5, 3, 4), "0-2,5,3-4"),
        ("1-1", 1, "1"),
    ],
)
def test_streams_are_read_as_they_are_written(text: str, streams: int | tuple[int, ...], again: str) -> None:
    assert parse_streams(text) == streams
    assert streams_text(streams) == again


@pytest.mark.parametrize("text", ["", "x", "-1", "5-0", "0-", "0,,1", "0 1", "1.5", "٣", "0-99999"])
def test_what_is_no_stream_is_refused(text: str) -> None:
    with pytest.raises(RuleError, match="expected the number of a sound stream, from 0, or those of streams"):
        parse_streams(text)
    with pytest.raises(RuleError, match="names sound stream 1 twice"):
        parse_streams("0-2,1")

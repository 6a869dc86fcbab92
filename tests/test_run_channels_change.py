"""Shots that were heard beside the middle, where the middle has them now: moved there, or in a film mixed anew."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
import soundfile

from blastline import run
from blastline.export import read_timeline
from blastline.model import Event, encode
from blastline.run import RenderOptions
from media import write_media
from sides_films import RATE_HZ, Samples, three_shots, written


@pytest.fixture(scope="module")
def scene() -> Samples:
    return three_shots()


@pytest.fixture(scope="module")
def old(scene: Samples, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a film in 5.1: its shots come from the left, the first under a voice in the middle."""
    folder = tmp_path_factory.mktemp("old")
    write(folder / "film.wav", left=0.3 * scene, centre=voice(scene))
    run.render(folder / "film.wav", folder / "out", RenderOptions(report=False))
    return folder


def fading(scene: Samples) -> Samples:
    """Return a gain that falls to nothing after the first shot, over half a second."""
    return np.asarray(np.clip((4.0 - np.arange(scene.size) / RATE_HZ) / 0.5, 0.0, 1.0))


def voice(scene: Samples) -> Samples:
    """Return what is as loud as the first shot and over before the next."""
    return 0.2 * np.random.default_rng(2).standard_normal(scene.size).clip(-3.0, 3.0) * fading(scene)


def write(path: Path, *, left: Samples, centre: Samples) -> Path:
    none = np.zeros_like(left)
    return written(path, [left, none, centre, none, none, none])


def events_of(folder: Path) -> tuple[Event, ...]:
    return read_timeline(folder / "timeline.json").events


def conformed(old: Path, new: Path, folder: Path) -> tuple[Event, ...]:
    run.conform(old / "out", folder, old=old / "film.wav", new=new)
    return events_of(folder)


def test_what_the_old_film_has(old: Path) -> None:
    events = events_of(old / "out")
    assert [event.heard_in for event in events] == ["sides", "mains", "mains"]
    assert all(event.azimuth_deg == pytest.approx(-30.0, abs=5.0) for event in events)


def test_a_shot_that_is_moved_from_the_sides_to_the_middle_is_measured_there(
    old: Path, scene: Samples, tmp_path: Path
) -> None:
    """As one that is added there: the sides are silent, and of silence there is no blast and no decay."""
    early = fading(scene)
    film = write(tmp_path / "film.wav", left=0.3 * scene * early, centre=voice(scene) + scene * (1.0 - early))
    run.render(film, tmp_path / "out", RenderOptions(report=False))
    timeline = read_timeline(tmp_path / "out" / "timeline.json")
    moved, there, last = timeline.events
    assert (moved.heard_in, there.heard_in) == ("sides", "mains")
    edited = msgspec.structs.replace(timeline, events=(_at(moved, there.onset_sample), last))
    (tmp_path / "edited.json").write_bytes(encode(edited))
    options = RenderOptions(report=False, timeline=tmp_path / "edited.json", original=tmp_path / "out")
    run.render(film, tmp_path / "final", options)
    now = events_of(tmp_path / "final")[0]
    assert (now.id, now.origin, now.heard_in) == (moved.id, "moved", "mains")
    assert now.peak_dbfs == pytest.approx(there.peak_dbfs, abs=0.1)
    assert now.snr_db == pytest.approx(there.snr_db, abs=0.5)
    assert (now.blast, now.window) == (there.blast, there.window)


def _at(event: Event, onset: int) -> Event:
    return msgspec.structs.replace(event, onset_sample=onset, onset_s=onset / RATE_HZ)


def test_in_a_mono_film_nothing_is_beside_the_middle_and_nothing_has_a_direction(
    old: Path, scene: Samples, tmp_path: Path
) -> None:
    mono = 0.15 * scene + 0.5 * voice(scene)
    soundfile.write(tmp_path / "mono.wav", mono, RATE_HZ, subtype="PCM_24")
    events = conformed(old, tmp_path / "mono.wav", tmp_path / "new")
    before = {event.id: event for event in events_of(old / "out")}
    assert len(events) == len(before)
    for event in events:
        assert (event.heard_in, event.azimuth_deg, event.azimuth_focus) == ("mains", None, None)
    attack = mono[events[0].onset_sample :][: RATE_HZ // 50]
    assert events[0].peak_dbfs == pytest.approx(20.0 * np.log10(np.abs(attack).max()), abs=0.1)


def test_shots_come_from_where_the_new_film_plays_them(old: Path, tmp_path: Path) -> None:
    samples, _ = soundfile.read(old / "film.wav")
    soundfile.write(tmp_path / "turned.wav", samples[:, [1, 0, 2, 3, 4, 5]], RATE_HZ, subtype="PCM_24")
    events = conformed(old, tmp_path / "turned.wav", tmp_path / "new")
    for now, was in zip(events, events_of(old / "out"), strict=True):
        assert now.heard_in == was.heard_in
        assert now.azimuth_focus == was.azimuth_focus
        assert now.azimuth_deg == (None if was.azimuth_deg is None else -was.azimuth_deg)


@pytest.mark.parametrize(("steps", "is_same"), [(0, True), (1024, True), (-1024, True), (1025, False), (-1025, False)])
def test_a_shot_keeps_its_direction_where_each_sample_is_the_same_as_in_a_copy_of_16_bits(
    old: Path, tmp_path: Path, steps: int, *, is_same: bool
) -> None:
    """2^-13 apart, in steps of 24 bits, in one sample of one channel; a direction that nobody measured shows it."""
    timeline = read_timeline(old / "out" / "timeline.json")
    said = [msgspec.structs.replace(event, azimuth_deg=77.0) for event in timeline.events]
    (tmp_path / "timeline.json").write_bytes(encode(msgspec.structs.replace(timeline, events=tuple(said))))
    samples, _ = soundfile.read(old / "film.wav", dtype="int32")
    samples[said[1].onset_sample + 10, 0] += steps * 256
    soundfile.write(tmp_path / "new.wav", samples, RATE_HZ, subtype="PCM_24")
    run.conform(tmp_path / "timeline.json", tmp_path / "out", old=old / "film.wav", new=tmp_path / "new.wav")
    now = events_of(tmp_path / "out")
    assert [event.azimuth_deg == 77.0 for event in now] == [True, is_same, True]
    assert is_same or now[1].azimuth_deg == pytest.approx(-30.0, abs=5.0)


def test_a_voice_that_begins_with_a_shot_in_the_sides_of_the_new_film_does_not_pull_it_to_the_middle(
    old: Path, scene: Samples, tmp_path: Path
) -> None:
    was = events_of(old / "out")[0]
    before = slice(was.onset_sample - RATE_HZ, was.onset_sample)
    centre = voice(scene)
    centre[before] *= 0.2
    now = conformed(old, write(tmp_path / "film.wav", left=0.3 * scene, centre=centre), tmp_path / "new")[0]
    assert (now.id, now.heard_in) == (was.id, "sides")
    assert now.azimuth_deg == pytest.approx(-30.0, abs=5.0)


def test_where_channels_cannot_be_read_again_the_old_ones_tell_if_they_are_laid_out_alike(
    old: Path, tmp_path: Path
) -> None:
    samples, _ = soundfile.read(old / "film.wav")
    write_media(tmp_path / "alike.mkv", [samples.astype(np.float32)], codec="flac")
    kept = conformed(old, tmp_path / "alike.mkv", tmp_path / "alike")
    assert [e.azimuth_deg for e in kept] == [e.azimuth_deg for e in events_of(old / "out")]
    mono = samples.mean(axis=1, keepdims=True).astype(np.float32)
    write_media(tmp_path / "mono.mkv", [mono], codec="flac")
    assert [e.azimuth_deg for e in conformed(old, tmp_path / "mono.mkv", tmp_path / "mono")] == [None, None, None]

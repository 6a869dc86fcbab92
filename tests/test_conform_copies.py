"""What is conformed to its own film, or to a copy of the same samples, stays as it is."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
import soundfile
import soxr

from blastline.conform import Placed, find_courses, place
from blastline.export import read_timeline
from blastline.model import Timeline
from blastline.ruleset import load_conform
from commands import blastline
from conform_films import RATE_HZ as FILM_HZ
from conform_films import film, heard
from media import write_media
from sides_films import RATE_HZ, Samples, three_shots, written

LATE = 7_777


@pytest.fixture(scope="module")
def shots() -> Samples:
    return np.round(three_shots() * 32_768.0) / 32_768.0


def voiced(shots: Samples) -> list[Samples]:
    """Return six channels: shots on the left behind, under a voice in the centre that begins with each of them."""
    rng, time_s = np.random.default_rng(5), np.arange(len(shots)) / RATE_HZ
    begun_s = np.min([np.where(time_s < at_s, 1.0, time_s - at_s) for at_s in (2.0, 5.5, 9.0)], axis=0)
    channels = [1e-4 * rng.standard_normal(len(shots)) for _ in range(6)]
    channels[2] += np.where(begun_s < 1.0, 0.35 * np.sin(2 * np.pi * 180 * time_s) * np.minimum(1, begun_s / 0.004), 0)
    channels[4] += shots
    return channels


def panned(shots: Samples) -> list[Samples]:
    """Return a pair with the shots a little on the right, over a bed of its own on either side."""
    rng = np.random.default_rng(6)
    return [gain * shots + 1e-4 * rng.standard_normal(len(shots)) for gain in (0.5, 1.0)]


MIXES = {"mono": lambda shots: [shots], "pair": panned, "surround": voiced}


def conformed(tmp_path: Path, old: Path, new: Path) -> tuple[Timeline, Timeline]:
    """Return the timeline of a film as it was found, and as it was conformed to another one."""
    assert blastline("detect", old, "-o", tmp_path / "old.json", "-q").code == 0
    assert blastline("conform", tmp_path / "old.json", "--from", old, "--to", new, "-o", tmp_path / "new").code == 0
    return read_timeline(tmp_path / "old.json"), read_timeline(tmp_path / "new" / "timeline.json")


@pytest.mark.parametrize("mix", MIXES)
@pytest.mark.parametrize("rate_hz", [44_100, RATE_HZ, 192_000])
def test_a_film_conformed_to_itself_keeps_all_that_was_told(
    tmp_path: Path, shots: Samples, mix: str, rate_hz: int
) -> None:
    columns = soxr.resample(np.stack(MIXES[mix](shots), axis=1), RATE_HZ, rate_hz)
    film = tmp_path / "film.wav"
    soundfile.write(film, columns, rate_hz, subtype="PCM_24")
    old, new = conformed(tmp_path, film, film)
    assert len(old.events) == 3
    assert new == old


@pytest.mark.parametrize("mix", MIXES)
@pytest.mark.parametrize("kind", ["flac", "mkv", "16 bits", "later"])
def test_a_copy_of_the_same_samples_keeps_what_they_tell(tmp_path: Path, shots: Samples, mix: str, kind: str) -> None:
    channels = MIXES[mix](shots)
    film = written(tmp_path / "film.wav", channels)
    copy, late = tmp_path / f"copy.{kind if kind in ('flac', 'mkv') else 'wav'}", LATE if kind == "later" else 0
    columns = np.concatenate([np.zeros((late, len(channels))), np.stack(channels, axis=1)])
    if kind == "mkv":
        write_media(copy, [columns.astype(np.float32)], codec="pcm_s24le")
    else:
        soundfile.write(copy, columns, RATE_HZ, subtype="PCM_16" if kind == "16 bits" else "PCM_24")
    old, new = conformed(tmp_path, film, copy)
    assert [each.onset_sample - late for each in new.events] == [each.onset_sample for each in old.events]
    for was, now in zip(old.events, new.events, strict=True):
        assert (now.heard_in, now.azimuth_deg, now.azimuth_focus) == (was.heard_in, was.azimuth_deg, was.azimuth_focus)
        assert now.decisions == was.decisions
        assert [each.delay_ms for each in now.reflections] == [each.delay_ms for each in was.reflections]
        spans = [(each.blast.start, each.blast.stop, each.window.start, each.window.stop) for each in (was, now)]
        assert [at - late for at in spans[1]] == list(spans[0])
        assert now.peak_dbfs == pytest.approx(was.peak_dbfs, abs=0.01)
    turned_down = [msgspec.structs.replace(each, at_sample=each.at_sample - late) for each in new.rejections]
    assert turned_down == list(old.rejections)


def against(shots: Samples) -> list[Samples]:
    """Return a pair that plays the second of three shots against each other, over a bed in the middle."""
    bed = film(len(shots) / RATE_HZ, [], seed=8, rate_hz=RATE_HZ) * 0.05
    second = np.zeros(len(shots))
    second[5 * RATE_HZ : 8 * RATE_HZ] = shots[5 * RATE_HZ : 8 * RATE_HZ]
    return [bed + shots, bed + shots - 2.0 * second]


@pytest.mark.parametrize("channel", [0, 1])
def test_a_shot_beside_the_middle_is_found_in_one_channel_alone(tmp_path: Path, shots: Samples, channel: int) -> None:
    pair = against(shots)
    old, new = conformed(tmp_path, written(tmp_path / "pair.wav", pair), written(tmp_path / "one.wav", [pair[channel]]))
    assert [each.heard_in for each in old.events] == ["mains", "sides", "mains"]
    assert [each.onset_sample for each in new.events] == [each.onset_sample for each in old.events]
    assert {each.heard_in for each in new.events} == {"mains"}
    assert new.events[1].peak_dbfs == pytest.approx(old.events[1].peak_dbfs, abs=0.5)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("late", [0, 1, LATE])
def test_a_copy_runs_at_exactly_the_speed_of_its_film(seed: int, late: int) -> None:
    """Whole samples late, to the last bit; shots anywhere, in a burst too, are where it leads and wholly alike."""
    onsets_s = [at / RATE_HZ for at in (960_001, 1_440_333, 1_445_933, 1_450_501, 2_370_007)]
    samples = film(60.0, onsets_s, seed=seed, rate_hz=RATE_HZ)
    old, new = heard(samples, RATE_HZ), heard(np.concatenate([np.zeros(late), samples]), RATE_HZ)
    [course] = find_courses(old, new)
    segment = course.segment
    assert (segment.line.scale, segment.line.offset_s, segment.start_s) == (1.0, late / RATE_HZ, 0.0)
    assert segment.stop_s == pytest.approx(60.0, abs=1e-9)
    for onset_s, found in zip(onsets_s, place(onsets_s, [course], old, new, load_conform()), strict=True):
        assert isinstance(found, Placed)
        assert found.residual_ms == 0.0
        assert found.new_s == pytest.approx(onset_s + late / RATE_HZ, abs=1e-9)
        assert found.likeness == pytest.approx(1.0, abs=1e-9)


def at_samples(samples: Samples, places: Samples) -> Samples:
    """Return samples as they are between their places, by the sum of sinc functions of a long window."""
    up = soxr.resample(samples, FILM_HZ, 16 * FILM_HZ, quality="VHQ")
    return np.asarray(np.interp(places * 16, np.arange(len(up)), up))


@pytest.mark.parametrize(("ppm", "late"), [(10.0, 0.0), (2.0, 0.0), (0.5, 0.0), (0.0, 0.4), (0.0, 0.2)])
def test_a_film_that_drifts_or_lies_between_samples_is_no_plain_copy(ppm: float, late: float) -> None:
    old = film(60.0, [12.0, 31.0, 47.0], seed=3)
    scale = 1.0 + ppm * 1e-6
    new = at_samples(old, (np.arange(len(old), dtype=np.float64) - late) / scale)
    [course] = find_courses(heard(old), heard(new))
    assert course.segment.line.scale == pytest.approx(scale, abs=0.2e-6)
    assert course.segment.line.at(30.0) == pytest.approx(30.0 * scale + late / FILM_HZ, abs=12e-6)

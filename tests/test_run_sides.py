"""From a film whose channels play against each other to its drive: what the mix cancels is found, felt and checked."""

from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from blastline import run
from blastline.detect import find_shots, load_verifier
from blastline.model import Clip, Shot, Span, Timeline, encode
from blastline.render import mix_that_drives
from blastline.ruleset import load_rules, rules_path
from blastline.run import RenderOptions
from blastline.synth import Scene, render_scene
from media import write_media

RATE_HZ = 48_000
RULES = load_rules("standard")
SCENE = {
    "schema": 1,
    "rate_hz": RATE_HZ,
    "duration_s": 12.0,
    "seed": 11,
    "layout": "mono",
    "beds": [{"kind": "ambience", "level_dbfs": -60.0}],
    "shots": [
        {"at_s": at_s, "weapon": weapon, "environment": "street", "distance_m": 12.0, "snr_db": 34.0}
        for at_s, weapon in ((2.0, "rifle"), (5.5, "pistol"), (9.0, "shotgun"))
    ],
}

Samples = NDArray[np.float64]


@pytest.fixture(scope="module")
def shots() -> Samples:
    audio = render_scene(msgspec.convert(SCENE, Scene))
    samples = np.asarray(audio.read(0, audio.frames)[:, 0], np.float64)
    return np.asarray(samples * (0.4 / np.abs(samples).max()))


@pytest.fixture(scope="module")
def beyond(shots: Samples, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a film whose channels play the shots against each other, rendered, over what both play."""
    folder = tmp_path_factory.mktemp("against")
    middle = 0.002 * np.random.default_rng(1).standard_normal(len(shots))
    written(folder / "film.wav", [middle + shots, middle - shots])
    run.render(folder / "film.wav", folder / "out", RenderOptions(report=False))
    return folder


def written(path: Path, channels: Sequence[Samples]) -> Path:
    soundfile.write(path, np.stack(channels, axis=1), RATE_HZ, subtype="PCM_24")
    return path


def timeline_of(folder: Path) -> Timeline:
    return msgspec.json.decode((folder / "timeline.json").read_bytes(), type=Timeline)


def drive_of(folder: Path) -> Samples:
    return np.asarray(soundfile.read(folder / "drive.wav")[0], np.float64)


def test_shots_that_cancel_in_the_mix_drive_as_they_do_by_themselves(
    beyond: Path, shots: Samples, tmp_path: Path
) -> None:
    alone = run.render(written(tmp_path / "alone.wav", [shots]), tmp_path / "out", RenderOptions(report=False))
    here = timeline_of(beyond / "out")
    assert len(here.events) == 3
    assert [event.onset_sample for event in here.events] == [event.onset_sample for event in alone.events]
    assert [event.peak_dbfs for event in here.events] == pytest.approx([e.peak_dbfs for e in alone.events], abs=1e-4)
    for event in here.events:
        assert event.heard_in == "sides"
        assert event.drive is not None
        assert event.drive.made_of == "sides"
    assert all(check.passed for check in here.checks)
    np.testing.assert_allclose(drive_of(beyond / "out"), drive_of(tmp_path / "out"), atol=2e-5)


def test_the_checks_hold_the_drive_to_the_mix_that_it_is_made_of(beyond: Path) -> None:
    out = beyond / "out"
    found = timeline_of(out)
    events = [
        msgspec.structs.replace(e, drive=msgspec.structs.replace(e.drive, made_of="mains")) if e.drive else e
        for e in found.events
    ]
    claimed = out / "claimed.json"
    claimed.write_bytes(encode(msgspec.structs.replace(found, events=tuple(events))))
    again = run.check(out, audio=beyond / "film.wav")
    wrong = run.check(claimed, audio=beyond / "film.wav", drive=out / "drive.wav")
    assert all(check.passed for check in again.checks)
    assert not all(check.passed for check in wrong.checks)


def test_a_film_that_is_decoded_once_is_driven_like_a_file_of_samples(beyond: Path, tmp_path: Path) -> None:
    samples = np.round(soundfile.read(beyond / "film.wav")[0] * 32_768.0) / 32_768.0
    soundfile.write(tmp_path / "film.wav", samples, RATE_HZ, subtype="PCM_16")
    coded = write_media(tmp_path / "film.mkv", [samples.astype(np.float32)], codec="flac")
    for path in (tmp_path / "film.wav", coded):
        run.render(path, tmp_path / path.suffix[1:], RenderOptions(report=False))
    np.testing.assert_array_equal(drive_of(tmp_path / "mkv"), drive_of(tmp_path / "wav"))
    assert {event.heard_in for event in timeline_of(tmp_path / "mkv").events} == {"sides"}
    assert all(check.passed for check in run.check(tmp_path / "mkv", audio=coded).checks)


@pytest.mark.parametrize("quality", ["draft", "standard"])
def test_a_shot_that_is_moved_by_hand_stays_in_the_sides(beyond: Path, tmp_path: Path, quality: str) -> None:
    found = timeline_of(beyond / "out")
    plain = msgspec.to_builtins(found)
    plain["events"][1]["onset_sample"] += 96
    plain["events"][1]["onset_s"] += 0.002
    edited = tmp_path / "edited.json"
    edited.write_bytes(msgspec.json.encode(plain))
    options = RenderOptions(report=False, timeline=edited, original=beyond / "out" / "timeline.json", quality=quality)  # type: ignore[arg-type]
    made = run.render(beyond / "film.wav", tmp_path / "out", options)
    assert [event.origin for event in made.events] == ["found", "moved", "found"]
    assert {event.heard_in for event in made.events} == {"sides"}
    moved = made.events[1].window
    assert np.abs(drive_of(tmp_path / "out")[moved.start : moved.stop]).max() > 0.1
    assert made.events[1].peak_dbfs == pytest.approx(found.events[1].peak_dbfs, abs=1.0)


def test_who_names_the_low_channel_gets_the_low_channel(shots: Samples, tmp_path: Path) -> None:
    voice = 0.2 * np.random.default_rng(2).standard_normal(len(shots)).clip(-3.0, 3.0)
    none = np.zeros_like(shots)
    path = written(tmp_path / "film.wav", [shots, none, voice, 0.1 * shots, none, none])
    made = run.render(path, tmp_path / "out", RenderOptions(report=False, mix="lfe"))
    assert "sides" in {event.heard_in for event in made.events}
    assert {event.drive.made_of for event in made.events if event.drive} == {"mains"}


def test_what_is_left_beside_the_middle_far_under_it_changes_nothing(shots: Samples) -> None:
    """A mixer's balance that is off by 0.1 dB leaves a copy at -45 dB in the sides."""
    verifier = load_verifier(rules_path(f"verifier/{RULES.tier.verify.model}"), networks=RULES.tier.verify.networks)
    heard = shots.astype(np.float32)[:, None]
    for sides in (np.zeros_like(heard), np.float32(0.006) * heard):
        clip = Clip(heard, RATE_HZ, sides=sides[:, 0])
        beside = find_shots([clip], rate_hz=RATE_HZ, tier=RULES.tier, verifier=verifier)
        assert beside == find_shots([Clip(heard, RATE_HZ)], rate_hz=RATE_HZ, tier=RULES.tier, verifier=verifier)
        assert beside.shots


def _shot(onset: int, heard_in: str) -> Shot:
    span = Span(onset, onset + 100)
    return Shot(onset, 0.99, -6.0, 20.0, span, (), span, heard_in=heard_in)  # type: ignore[arg-type]


def test_a_window_is_made_of_the_sides_where_all_its_shots_are_and_sound_there() -> None:
    loud, soft = np.full((4_000, 1), 0.5, np.float32), np.full(4_000, 0.05, np.float32)
    beside = [_shot(1_000, "sides"), _shot(2_500, "sides")]
    clear = Clip(loud, RATE_HZ, 500, sides=loud[:, 0])
    assert mix_that_drives(clear, beside) == "sides"
    assert mix_that_drives(clear, [*beside, _shot(3_000, "mains")]) == "mains"
    assert mix_that_drives(Clip(loud, RATE_HZ, 500, sides=soft), beside) == "mains"
    assert mix_that_drives(Clip(loud, RATE_HZ, 500), beside) == "mains"
    assert mix_that_drives(Clip(np.repeat(loud, 2, axis=1), RATE_HZ, 500, sides=loud[:, 0]), beside) == "mains"

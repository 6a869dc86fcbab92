"""The main job from end to end: what must hold whatever the film, to the bit where it can."""

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from blastline import run
from blastline.errors import RuleError, TimelineError
from blastline.model import SceneEvidence, Timeline
from blastline.progress import no_progress
from blastline.ruleset import load_rules
from blastline.ruleset.tables import LARGEST_LEVEL_DB
from blastline.run import listening
from blastline.run.driving import open_drive
from blastline.run.options import set_up
from blastline.scene import choose
from blastline.synth import Scene, render_scene, synthesise
from checked_films import seat

RATE_HZ = 48_000
FIXTURES = Path(__file__).parents[1] / "fixtures"
SCENE = {
    "schema": 1,
    "rate_hz": RATE_HZ,
    "duration_s": 12.0,
    "seed": 5,
    "beds": [{"kind": "dialogue", "level_dbfs": -40.0}],
    "shots": [
        {"at_s": 1.5, "weapon": "rifle", "environment": "field", "distance_m": 15.0, "peak_dbfs": -3.0},
        {
            "at_s": 5.0,
            "weapon": "smg",
            "environment": "field",
            "distance_m": 10.0,
            "peak_dbfs": -5.0,
            "burst": {"shots": 4, "rpm": 650.0},
        },
        {"at_s": 9.5, "weapon": "pistol", "environment": "street", "distance_m": 6.0, "peak_dbfs": -8.0},
    ],
}


def write(path: Path, samples: NDArray[np.float64]) -> Path:
    soundfile.write(path, samples, RATE_HZ, subtype="PCM_16")
    return path


def drive_of(folder: Path) -> NDArray[np.int32]:
    samples: NDArray[np.int32] = soundfile.read(folder / "drive.wav", dtype="int32")[0]
    return samples


def rendered(film: Path, folder: Path, **options: Any) -> tuple[Timeline, NDArray[np.int32]]:
    timeline = run.render(film, folder, run.RenderOptions(report=False, **options))
    return timeline, drive_of(folder)


@pytest.fixture(scope="module")
def samples() -> NDArray[np.float64]:
    audio = render_scene(msgspec.convert(SCENE, Scene))
    return np.round(audio.read(0, audio.frames)[:, 0] * 32767.0) / 32768.0


@pytest.fixture(scope="module")
def film(samples: NDArray[np.float64], tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("film") / "film.wav", samples)


@pytest.fixture(scope="module")
def result(film: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Timeline, NDArray[np.int32]]:
    return rendered(film, tmp_path_factory.mktemp("result") / "out")


def test_a_right_file_passes_every_check(result: tuple[Timeline, NDArray[np.int32]]) -> None:
    timeline, drive = result
    assert len(timeline.events) >= 4
    assert [check for check in timeline.checks if not check.passed] == []
    assert drive.size == timeline.source.frames == 12 * RATE_HZ


@pytest.mark.parametrize(
    ("resonance_hz", "q", "options"),
    [
        (40.0, 10.0, {}),
        (60.0, 30.0, {}),
        (60.0, 3.0, {"level_db": 12.0}),
        (120.0, 30.0, {"phase": "zero", "level_db": 6.0}),
    ],
)
def test_a_right_drive_of_a_seat_that_rings_on_passes_every_check(
    film: Path, tmp_path: Path, resonance_hz: float, q: float, options: dict[str, Any]
) -> None:
    """What rings on from before a window, or from the shot before the last, is no fault of a drive."""
    actuator = seat(tmp_path / "seat.toml", resonance_hz, q)
    timeline, _ = rendered(film, tmp_path / "out", actuator=actuator, drive="constrained", **options)
    assert [check for check in timeline.checks if not check.passed] == []
    early = [check.measured for check in timeline.checks if check.name == "pre_echo" and check.measured is not None]
    assert len(early) >= 4
    assert max(early) < -70.0


@pytest.mark.parametrize(("resonance_hz", "q", "up_to_hz"), [(58.0, 10.0, 80.0), (58.0, 3.0, 100.0)])
def test_a_right_drive_of_a_seat_that_is_felt_at_low_frequencies_alone_passes_every_check(
    tmp_path: Path, resonance_hz: float, q: float, up_to_hz: float
) -> None:
    """The slower the highest frequency that is felt swings, the further the actuator's limit bends a lag."""
    synthesise(FIXTURES / "street.toml", tmp_path)
    actuator = seat(tmp_path / "seat.toml", resonance_hz, q, up_to_hz)
    timeline, _ = rendered(tmp_path / "street.wav", tmp_path / "out", actuator=actuator, quality="draft")
    assert [check for check in timeline.checks if not check.passed] == []


def test_every_choice_follows_from_its_evidence(result: tuple[Timeline, NDArray[np.int32]]) -> None:
    timeline, _ = result
    rules = load_rules("standard")
    assert timeline.events
    for event in timeline.events:
        assert event.drive is not None
        assert choose(SceneEvidence(**event.drive.evidence), rules.scenes, "auto") == (
            event.drive.model,
            event.drive.reason,
        )
        verifier, reflections, window = event.decisions
        assert (verifier.about, reflections.about, window.about) == ("verifier", "reflections", "window")
        assert verifier.evidence["confidence"] == event.confidence
        assert verifier.evidence["screen"] >= rules.tier.verify.look_from
        assert all(echo.level_db <= reflections.evidence["echo_room_db"] + 1e-6 for echo in event.reflections)
        decay = round(window.evidence["decay_ms"] * RATE_HZ / 1000.0)
        assert event.onset_sample + decay <= event.window.stop - event.window.fade_out_samples


def test_outside_the_windows_a_muted_drive_is_zero(result: tuple[Timeline, NDArray[np.int32]]) -> None:
    timeline, drive = result
    outside = np.ones(drive.size, bool)
    for event in timeline.events:
        outside[event.window.start : event.window.stop] = False
        assert np.any(drive[event.window.start : event.window.stop])
    assert not np.any(drive[outside])


def test_outside_the_windows_a_direct_background_is_the_film(
    samples: NDArray[np.float64], film: Path, tmp_path: Path
) -> None:
    timeline, drive = rendered(film, tmp_path / "out", background="direct")
    outside = np.ones(drive.size, bool)
    for event in timeline.events:
        outside[event.window.start : event.window.stop] = False
    np.testing.assert_array_equal(drive[outside], np.round(samples[outside] * 2.0**31).astype(np.int64))


@pytest.mark.parametrize("options", [{"phase": "zero"}, {"background": "direct"}, {"drive": "filter"}])
def test_checking_later_finds_what_rendering_found(film: Path, tmp_path: Path, options: dict[str, str]) -> None:
    timeline, _ = rendered(film, tmp_path / "out", **options)
    again = run.check(tmp_path / "out", audio=film)
    assert again == timeline
    assert (again.phase, again.background) == (options.get("phase", "causal"), options.get("background", "mute"))


@pytest.mark.parametrize("size", [1, 7, 4096, 12 * RATE_HZ])
def test_the_block_size_changes_no_bit(
    result: tuple[Timeline, NDArray[np.int32]],
    film: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    size: int,
) -> None:
    monkeypatch.setattr(listening, "BLOCK", size)
    timeline, drive = rendered(film, tmp_path / "out")
    assert timeline == result[0]
    np.testing.assert_array_equal(drive, result[1])


@pytest.mark.parametrize("delay", [1, 37, 48_001])
def test_a_delay_of_the_film_delays_events_and_drive(
    result: tuple[Timeline, NDArray[np.int32]], samples: NDArray[np.float64], tmp_path: Path, delay: int
) -> None:
    film = write(tmp_path / "film.wav", np.concatenate([np.zeros(delay), samples]))
    timeline, drive = rendered(film, tmp_path / "out")
    assert [event.onset_sample - delay for event in timeline.events] == [e.onset_sample for e in result[0].events]
    np.testing.assert_array_equal(drive[delay:], result[1])
    assert not np.any(drive[:delay])


def test_six_decibels_move_no_onset(
    result: tuple[Timeline, NDArray[np.int32]], samples: NDArray[np.float64], tmp_path: Path
) -> None:
    film = tmp_path / "film.wav"
    in_16_bits = soundfile.read(write(film, samples))[0]
    soundfile.write(film, 0.5 * in_16_bits, RATE_HZ, subtype="PCM_24")  # which holds the halves exactly
    timeline, _ = rendered(film, tmp_path / "out")
    assert [event.onset_sample for event in timeline.events] == [event.onset_sample for event in result[0].events]


def test_a_drive_read_again_passes_and_a_shifted_one_says_by_how_much(
    result: tuple[Timeline, NDArray[np.int32]], film: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    rendered(film, out)
    again = run.check(out, audio=film)
    assert again.checks == result[0].checks
    soundfile.write(tmp_path / "late.wav", np.roll(drive_of(out), 240), RATE_HZ, subtype="PCM_24")
    late = run.check(out, audio=film, drive=tmp_path / "late.wav")
    shift = next(check for check in late.checks if check.name == "drive_shift")
    assert not shift.passed
    assert shift.measured == pytest.approx(240.0, abs=0.1)


@pytest.mark.parametrize("drive", ["filter", "direct"])
@pytest.mark.parametrize("quality", ["draft", "standard"])
def test_by_one_sample_a_drive_that_nothing_was_solved_for_is_displaced_at_any_rate(
    drive: str, quality: str, tmp_path: Path
) -> None:
    """Corners of a drive in straight lines are felt aside by more: no other drive may be."""
    rate_hz, out, film = 192_000, tmp_path / "out", tmp_path / "film.wav"
    sound = 1e-5 * np.random.default_rng(0).standard_normal(2 * rate_hz)
    onsets = [rate_hz // 2, 5 * rate_hz // 4]
    decay_s = np.arange(rate_hz // 2) / rate_hz
    for onset in onsets:
        sound[onset : onset + decay_s.size] += 0.1 * np.exp(-decay_s / 0.02) * np.cos(2.0 * np.pi * 120.0 * decay_s)
    soundfile.write(film, sound, rate_hz, subtype="PCM_24")
    (tmp_path / "shots.csv").write_text("id,onset_sample\n" + "".join(f"s{at},{at}\n" for at in onsets))
    rendered(film, out, drive=drive, quality=quality, timeline=tmp_path / "shots.csv")
    moved = tmp_path / "moved.wav"
    soundfile.write(moved, np.roll(drive_of(out), 1), rate_hz, subtype="PCM_24")
    for file, passes in ((out / "drive.wav", True), (moved, False)):
        shift = next(check for check in run.check(out, audio=film, drive=file).checks if check.name == "drive_shift")
        assert shift.passed == passes
        assert shift.limit == 0.5


def test_a_result_that_another_run_replaces_while_it_is_checked_has_no_verdict(
    film: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The timeline is read first: drive and timeline could be of two films."""
    out = tmp_path / "out"
    timeline, _ = rendered(film, out)

    def replaced(path: Path) -> Any:
        later = msgspec.structs.replace(timeline, level_db=6.0)
        (out / "timeline.json").write_bytes(msgspec.json.encode(later))
        return open_drive(path)

    monkeypatch.setattr("blastline.run.checking.open_drive", replaced)
    with pytest.raises(TimelineError, match=r"timeline\.json: was changed while it was read"):
        run.check(out, audio=film)


def test_a_film_without_shots_gives_a_silent_drive_and_an_empty_timeline(tmp_path: Path) -> None:
    film = write(tmp_path / "film.wav", 1e-3 * np.random.default_rng(0).standard_normal(2 * RATE_HZ))
    timeline, drive = rendered(film, tmp_path / "out")
    assert timeline.events == ()
    assert all(check.passed for check in timeline.checks)
    assert drive.size == 2 * RATE_HZ
    assert not np.any(drive)


@pytest.mark.parametrize(("rate_hz", "doubted"), [(8_000, True), (22_050, True), (32_000, False), (96_000, False)])
def test_a_rate_that_leaves_out_what_shots_are_told_by_is_warned_of(
    tmp_path: Path, rate_hz: int, doubted: bool
) -> None:
    noise = 0.1 * np.random.default_rng(3).standard_normal(rate_hz)
    soundfile.write(tmp_path / "film.wav", noise, rate_hz, subtype="PCM_16")
    warnings = run.detect(tmp_path / "film.wav").source.warnings
    assert ["fewer shots are found" in each for each in warnings] == [True] * doubted


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_largest_level_is_taken_and_a_larger_one_is_refused(sign: float) -> None:
    set_up(run.RenderOptions(level_db=sign * LARGEST_LEVEL_DB), no_progress)
    with pytest.raises(RuleError, match="expected -40 to 40"):
        set_up(run.RenderOptions(level_db=sign * (LARGEST_LEVEL_DB + 0.1)), no_progress)

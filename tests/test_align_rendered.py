"""What `render` makes of a timeline passes its checks."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import soundfile
from scipy.signal import resample_poly

from blastline import run
from blastline.errors import RuleError
from blastline.model import Background, DriveChoice, Phase
from blastline.ruleset import load_actuator, rules_path
from blastline.run import RenderOptions
from checked_films import RATE_HZ, failures, film, rendered, with_booms


@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("gap_ms", [50, 100])
@pytest.mark.parametrize("peak", [0.01, 0.03])
def test_a_faint_shot_before_a_loud_one_passes(tmp_path: Path, phase: Phase, gap_ms: int, peak: float) -> None:
    onsets = [14_400, 14_400 + gap_ms * 48, 48_000]
    path = film(tmp_path / "film.wav", onsets, [peak, 1.0, 0.5])
    assert failures(rendered(path, onsets, RenderOptions(report=False, phase=phase))) == []


@pytest.mark.parametrize("gain_db", [-12.0, -20.0, -28.0])
def test_a_shot_that_is_asked_to_be_softer_than_the_one_before_passes(tmp_path: Path, gain_db: float) -> None:
    onsets = [14_400, 19_200, 24_000]
    path = film(tmp_path / "film.wav", onsets, [0.03] * 3, decay_s=0.03)
    assert failures(rendered(path, onsets, RenderOptions(report=False), [0.0, 0.0, gain_db])) == []


@pytest.mark.parametrize(("gain_db", "is_held"), [(-40.0, False), (0.0, True), (18.0, True)])
@pytest.mark.parametrize("level_db", [0.0, 18.0])
def test_over_the_films_own_sound_a_shot_is_held_to_its_own_unless_it_was_muted(
    tmp_path: Path, gain_db: float, level_db: float, *, is_held: bool
) -> None:
    """Beneath what else is felt there nothing can be told of it, of one that was raised all the more."""
    onsets = [14_400, 34_000, 54_000]
    path = film(tmp_path / "film.wav", onsets, [0.3] * 3, decay_s=0.03)
    options = RenderOptions(report=False, background="direct", level_db=level_db)
    made = rendered(path, onsets, options, [0.0, gain_db - level_db * (not is_held), 0.0])
    assert failures(made) == []
    limits = {check.name: check.limit for check in made.checks if check.event == made.events[1].id}
    assert (limits["felt_lag"] is not None) == is_held


@pytest.mark.parametrize("drive", ["direct", "constrained"])
def test_in_silence_a_shot_is_held_to_its_own_however_soft_it_was_asked_to_be(
    tmp_path: Path, drive: DriveChoice
) -> None:
    """Nothing else is felt there that it could lie beneath."""
    onsets = [14_400, 34_000, 54_000]
    path = film(tmp_path / "film.wav", onsets, [0.3] * 3, decay_s=0.03)
    made = rendered(path, onsets, RenderOptions(report=False, drive=drive), [0.0, -40.0, 0.0])
    assert failures(made) == []
    limits = {check.name: check.limit for check in made.checks if check.event == made.events[1].id}
    assert limits["lag_as_rendered"] is not None


def test_a_seat_whose_band_leaves_nothing_above_it_has_its_drive_checked_in_the_band(tmp_path: Path) -> None:
    shipped = rules_path("actuators/crowson-t108sm.toml").read_text(encoding="utf-8")
    seat = tmp_path / "wide.toml"
    seat.write_text(shipped.replace("corner_hz = 1000.0", "corner_hz = 7000.0"), encoding="utf-8")
    path = film(tmp_path / "film.wav", [14_400, 40_000], [0.1, 0.1])
    options = RenderOptions(report=False, drive="constrained", actuator=str(seat))
    made = rendered(path, [14_400, 40_000], options)
    assert failures(made) == []
    assert [check.measured for check in made.checks if check.name == "drive_above_band"] == [None, None]
    assert all(check.limit for check in made.checks if check.name == "felt_correlation")


@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("seed", [0, 1])
def test_a_direct_drive_that_is_raised_into_the_limit_passes(tmp_path: Path, phase: Phase, seed: int) -> None:
    onsets = [14_400, 26_400, 40_000]
    path = film(tmp_path / "film.wav", onsets, [0.6] * 3, seed=seed)
    options = RenderOptions(report=False, drive="direct", level_db=12.0, phase=phase)
    assert failures(rendered(path, onsets, options)) == []


@pytest.mark.parametrize("level_db", [0.0, 6.0, 20.0])
def test_as_much_like_the_sound_as_was_predicted_is_a_shot_whose_attack_the_limit_bends(
    tmp_path: Path, level_db: float
) -> None:
    """The prediction is of the whole shot: what lingers for a second is followed, the attack before it is not."""
    random = np.random.default_rng(7)
    onsets, times_s = [14_400, 72_000], np.arange(52_800) / RATE_HZ
    samples = 1e-5 * random.standard_normal(130_000)
    for onset in onsets:
        samples[onset : onset + times_s.size] += 0.9 * np.exp(-times_s / 0.01) * np.cos(440.0 * times_s)
        samples[onset : onset + times_s.size] += 0.02 * random.standard_normal(times_s.size) * np.exp(-times_s / 2.0)
    path = tmp_path / "film.wav"
    soundfile.write(path, samples, RATE_HZ, subtype="PCM_24")
    made = rendered(path, onsets, RenderOptions(report=False, drive="constrained", level_db=level_db))
    assert failures(made) == []
    predicted = {event.id: event.drive.fidelity for event in made.events if event.drive}
    found = {check.event: check.measured for check in made.checks if check.name == "felt_correlation"}
    assert found == pytest.approx(predicted, abs=0.005)
    assert min(predicted.values()) < 0.97


@pytest.mark.parametrize(("level_db", "blast_ms"), [(9.0, 4.0), (12.0, 2.0), (12.0, 4.0), (18.0, 2.0)])
def test_a_direct_drive_is_where_it_is_however_far_it_is_clipped(
    tmp_path: Path, level_db: float, blast_ms: float
) -> None:
    """Long blasts clipped at their beginning seem to come later than their sound, but what is due of them does not."""
    onsets = [48_000, 72_000]
    samples = 1e-5 * np.random.default_rng(1).standard_normal(110_000)
    for onset in onsets:
        t = np.arange(20_000) / (RATE_HZ * blast_ms / 1000.0)
        samples[onset : onset + t.size] += 0.9 * (1.0 - t) * np.exp(-t)
    path = tmp_path / "film.wav"
    soundfile.write(path, samples, RATE_HZ, subtype="PCM_24")
    made = rendered(path, onsets, RenderOptions(report=False, drive="direct", level_db=level_db))
    assert {name for name, _, _ in failures(made)} <= {"drive_correlation"}, "it no longer follows the sound"
    assert all(abs(check.measured or 0.0) < 0.05 for check in made.checks if check.name == "drive_shift")
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    soundfile.write(tmp_path / "late.wav", np.roll(drive, 3), RATE_HZ, subtype="PCM_24")
    late = run.check(tmp_path / "out" / "timeline.json", audio=path, drive=tmp_path / "late.wav")
    assert [check.measured for check in late.checks if check.name == "drive_shift"] == [pytest.approx(3.0, abs=0.05)]


@pytest.mark.parametrize("rate_hz", [96_000, 192_000])
def test_a_coarse_drive_passes_at_any_rate(tmp_path: Path, rate_hz: int) -> None:
    onsets = [round(at * rate_hz / RATE_HZ) for at in (14_400, 26_400, 40_000)]
    path = film(tmp_path / "film.wav", [14_400, 26_400, 40_000], [0.9] * 3)
    samples, _ = soundfile.read(path)
    soundfile.write(path, resample_poly(0.9 * samples, rate_hz // RATE_HZ, 1), rate_hz, subtype="PCM_24")
    options = RenderOptions(report=False, quality="draft", drive="constrained", phase="zero")
    assert failures(rendered(path, onsets, options)) == []


@pytest.mark.parametrize("level_db", [30.0, 36.0])
def test_a_burst_far_beyond_the_limit_is_as_calm_before_its_shots_in_draft(tmp_path: Path, level_db: float) -> None:
    """There a drive is at its limit most of the time, and a coarse one turns over at the wrong moments."""
    onsets = [14_400 + number * 60 * 48 for number in range(6)]
    path = film(tmp_path / "film.wav", onsets, [0.9, 0.8, 0.9, 0.7, 0.9, 0.8])
    options = RenderOptions(report=False, quality="draft", drive="constrained", level_db=level_db)
    assert failures(rendered(path, onsets, options)) == []


@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize(("boom_hz", "gap"), [(25.0, 9_000), (30.0, 5_000), (40.0, 7_000)])
def test_shots_with_a_boom_under_them_are_calm_before_the_next_in_draft(
    tmp_path: Path, phase: Phase, boom_hz: float, gap: int
) -> None:
    onsets = [24_000, 24_000 + gap, 24_000 + 2 * gap]
    path = with_booms(film(tmp_path / "film.wav", onsets, [0.6, 0.6, 0.6]), onsets, boom_hz, peak=0.6)
    options = RenderOptions(report=False, quality="draft", phase=phase)
    assert failures(rendered(path, onsets, options)) == []


def test_a_seat_whose_name_is_no_line_is_refused(tmp_path: Path) -> None:
    shipped = rules_path("actuators/crowson-t108sm.toml").read_text(encoding="utf-8")
    seat = tmp_path / "mine.toml"
    seat.write_text(shipped.replace('"crowson-t108sm"', '"a\\nb"'), encoding="utf-8")
    with pytest.raises(RuleError, match=r"mine\.toml: name = 'a\\nb': expected printable characters alone"):
        load_actuator(str(seat))


def test_a_seat_that_fits_no_film_of_this_rate_is_named_before_the_film_is_heard(tmp_path: Path) -> None:
    shipped = (rules_path("actuators/crowson-t108sm.toml")).read_text(encoding="utf-8")
    seat = tmp_path / "mine.toml"
    seat.write_text(re.sub(r"(\[lowpass\][^\[]*corner_hz = )[\d.]+", r"\g<1>30000.0", shipped), encoding="utf-8")
    path = film(tmp_path / "film.wav", [14_400], [0.9])
    heard: list[str] = []
    with pytest.raises(RuleError, match=r"mine\.toml: crowson-t108sm: lowpass\.corner_hz: 30000 Hz: expected"):
        run.render(path, tmp_path / "out", RenderOptions(actuator=str(seat)), lambda stage, *_: heard.append(stage))
    assert heard == []
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("phase", ["causal", "zero"])
def test_a_film_that_begins_with_a_shot_passes(tmp_path: Path, phase: Phase) -> None:
    onsets = [0, 24_000, 40_000]
    path = film(tmp_path / "film.wav", onsets, [0.9] * 3)
    assert failures(rendered(path, onsets, RenderOptions(report=False, phase=phase))) == []


def test_a_lead_longer_than_the_checks_search_is_checked_as_well(tmp_path: Path) -> None:
    rules = tmp_path / "rules" / "quality" / "standard.toml"
    rules.parent.mkdir(parents=True)
    rules.write_text('schema = 1\nsource = "a test"\n[render]\nsource = "a test"\nlead_ms = 30.0\n')
    path = film(tmp_path / "film.wav", [14_400, 40_000], [0.9, 0.05])
    made = rendered(path, [14_400, 40_000], RenderOptions(report=False, rules=tmp_path / "rules"))
    assert {check.event for check in made.checks} > {"shot-0001", "shot-0002"}


STREET = """
schema = 1
rate_hz = 48000
duration_s = 30.0
seed = 77
[[beds]]
kind = "ambience"
level_dbfs = -46.0
[[beds]]
kind = "dialogue"
level_dbfs = -34.0
start_s = 4.0
stop_s = 20.0
"""


STREET_SHOTS = (
    (2.5, "pistol", 4.0, 34.0),
    (6.1, "shotgun", 12.0, 28.0),
    (10.0, "rifle", 35.0, 28.0),
    (14.2, "smg", 7.0, 30.0),
    (14.32, "smg", 7.0, 30.0),
    (14.44, "smg", 7.0, 30.0),
    (20.0, "pistol", 20.0, 34.0),
    (25.3, "rifle", 30.0, 34.0),
)


@pytest.mark.parametrize("kept", [(1, 7), (0, 7), (2, 7)])
def test_a_draft_solved_at_few_corners_has_no_drift(tmp_path: Path, kept: tuple[int, ...]) -> None:
    """The last shot, at the limit, is followed by 0.998, but 0.7 samples beside its place."""
    shots = "".join(
        f'[[shots]]\nat_s = {at_s}\nweapon = "{weapon}"\nenvironment = "street"\ndistance_m = {metres}\nsnr_db = {db}\n'
        for at_s, weapon, metres, db in STREET_SHOTS
    )
    (tmp_path / "street.toml").write_text(STREET + shots)
    run.synthesise(tmp_path / "street.toml", tmp_path)
    truth = json.loads((tmp_path / "street.truth.json").read_text())
    onsets = [truth["shots"][index]["onset_sample"] for index in kept]
    made = rendered(tmp_path / "street.wav", onsets, RenderOptions(report=False, quality="draft"))
    assert failures(made) == []


@pytest.mark.parametrize("background", ["mute", "direct"])
def test_a_drive_that_an_editor_saved_in_16_bits_passes_and_one_whose_background_it_softened_fails(
    tmp_path: Path, background: Background
) -> None:
    onsets = [14_400, 48_000]
    path = film(tmp_path / "film.wav", onsets, [0.5, 0.3])
    samples, _ = soundfile.read(path)
    hum = 0.02 * np.sin(np.arange(samples.size) / 97.0)
    soundfile.write(path, samples + hum, RATE_HZ, subtype="PCM_24")
    made = rendered(path, onsets, RenderOptions(report=False, background=background))
    assert failures(made) == []
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    soundfile.write(tmp_path / "saved.wav", drive, RATE_HZ, subtype="PCM_16")
    assert failures(run.check(tmp_path / "out", audio=path, drive=tmp_path / "saved.wav")) == []
    windows = [event.window for event in made.events]
    drive[: windows[0].start] = drive[: windows[0].start] * 0.99 + (1e-4 if background == "mute" else 0.0)
    soundfile.write(tmp_path / "softer.wav", drive, RATE_HZ, subtype="PCM_16")
    names = {name for name, _, _ in failures(run.check(tmp_path / "out", audio=path, drive=tmp_path / "softer.wav"))}
    assert names & {"sound_outside_windows", "silence_outside_windows"}

"""How late or early a drive may be: as much as its band and its seat make it, and no more."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import soundfile

from blastline import dsp, run
from blastline.align.attack import late_start
from blastline.align.due import DueDrive
from blastline.model import Phase, Quality, Span
from blastline.ruleset import load_actuator, rules_path
from blastline.run import RenderOptions
from checked_films import RATE_HZ, failures, film, pole_of, rendered, seat, with_booms


@pytest.mark.parametrize(("corner_hz", "order"), [(1000, 3), (1000, 4), (700, 3), (1000, 8), (300, 4)])
def test_a_drive_may_be_as_late_as_its_band_has_to_be_and_no_later(tmp_path: Path, corner_hz: int, order: int) -> None:
    """A low-pass of 700 Hz delays by .48 ms, and the actuator's limit bends that beyond the .5 ms of the rules."""
    shipped = rules_path("actuators/crowson-t108sm.toml").read_text(encoding="utf-8")
    seat = tmp_path / "mine.toml"
    seat.write_text(shipped.replace("1000.0\norder = 3", f"{corner_hz}.0\norder = {order}"), encoding="utf-8")
    onsets = [14_400, 26_400, 40_000, 52_000]
    path = film(tmp_path / "film.wav", onsets, [0.9, 0.3, 0.1, 0.6])
    options = RenderOptions(report=False, actuator=str(seat), quality="draft", level_db=18.0)
    assert failures(rendered(path, onsets, options)) == []
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    bend = 0.1 * max(1.0, 1000.0 / corner_hz) * RATE_HZ / 1000
    for by in (round(2.2 * bend), -round(2.2 * bend)):
        soundfile.write(tmp_path / "wrong.wav", np.roll(drive, by), RATE_HZ, subtype="PCM_24")
        checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "wrong.wav", actuator=str(seat))
        names = {name for name, _, _ in failures(checked)}
        assert {"drive_shift", "felt_lag"} <= names if by > 0 else "drive_shift" in names


@pytest.mark.parametrize("late_ms", [0.0, 3.0, 8.0])
def test_a_drive_that_misses_the_attack_is_late_however_much_comes_after_it(late_ms: float) -> None:
    """A room may answer a shot more strongly than it is."""
    ms = RATE_HZ // 1000
    due = np.sin(np.arange(200 * ms) / 20.0) * np.where(np.arange(200 * ms) < 60 * ms, 0.03, 1.0)
    due[: 10 * ms] = 0.0
    made = np.where(np.arange(200 * ms) < (10 + late_ms) * ms, 0.0, due)
    shared: Any = SimpleNamespace(lead_ms=0.0, samples=lambda length_ms: round(length_ms * ms))
    heard: Any = SimpleNamespace(core=Span(10 * ms, 200 * ms))
    felt: Any = SimpleNamespace(drive=made)
    assert late_start(shared, heard, felt, (DueDrive(1.0, due),)) == pytest.approx(late_ms * ms, abs=0.5 * ms)


RINGING_SEAT = """
schema = 1
name = "rings"
source = "a seat that rings at 60 Hz, behind the skin's thresholds"
[response]
source = "a fit"
gain = 4222.0
zeros_rad_s = [[-46.3, 0.0], [-85.5, 93.9], [-85.5, -93.9], [-140.2, 0.0], [-162.2, 3240.0], [-162.2, -3240.0]]
poles_rad_s = [
    [-11.6, 378.4], [-11.6, -378.4], [-256.6, 813.6], [-256.6, -813.6],
    [-240.2, 1333.0], [-240.2, -1333.0], [-270.5, 1967.0], [-270.5, -1967.0],
]
[lowpass]
source = "where the fit ends"
corner_hz = 523.5
order = 3
[highpass]
source = "where the fit begins"
corner_hz = 21.0
order = 2
"""


@pytest.mark.parametrize("boom_hz", [15.0, 20.0, 25.0, 40.0, 60.0])
def test_a_drive_leads_with_a_boom_by_what_its_band_brings_it_forward_and_no_more(
    tmp_path: Path, boom_hz: float
) -> None:
    """A high-pass turns the phase of a tone forward, a low-pass back; a boom that dies away is a tone to both."""
    with_booms(film(tmp_path / "film.wav", [24_000], [0.3]), [24_000], boom_hz, peak=0.4)
    made = rendered(tmp_path / "film.wav", [24_000], RenderOptions(level_db=-6.0))
    assert failures(made) == []
    (lag_ms,) = (check.measured for check in made.checks if check.name == "felt_lag")
    band = dsp.band(load_actuator("crowson-t108sm")[0]).at(np.array([boom_hz]))
    due_ms = -1000.0 * float(np.angle(band)[0]) / (2.0 * np.pi * boom_hz)
    assert lag_ms == pytest.approx(due_ms, abs=0.25)
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    soundfile.write(tmp_path / "aside.wav", np.roll(drive, -96), RATE_HZ, subtype="PCM_24")
    checked = run.check(tmp_path / "out", audio=tmp_path / "film.wav", drive=tmp_path / "aside.wav")
    assert {"lag_as_rendered", "felt_lag"} <= {name for name, *_ in failures(checked)}


@pytest.mark.parametrize(
    ("boom_hz", "level_db", "quality"), [(15.0, 0.0, "standard"), (25.0, 6.0, "standard"), (40.0, 6.0, "draft")]
)
def test_a_boom_at_the_limit_displaces_no_right_drive_and_hides_no_displaced_one(
    tmp_path: Path, boom_hz: float, level_db: float, quality: Quality
) -> None:
    """Likeness rises on beyond what the limit bends a lag by, so that its largest within that is at the end of it."""
    path = with_booms(film(tmp_path / "film.wav", [24_000], [0.6]), [24_000], boom_hz, peak=0.9)
    options = RenderOptions(report=False, quality=quality, level_db=level_db)
    assert failures(rendered(path, [24_000], options)) == []
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    for by, told in ((-48, "drive_shift"), (48, "drive_shift"), (-3, "lag_as_rendered"), (3, "lag_as_rendered")):
        soundfile.write(tmp_path / "aside.wav", np.roll(drive, by), RATE_HZ, subtype="PCM_24")
        checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "aside.wav")
        assert told in {name for name, *_ in failures(checked)}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_on_a_seat_that_rings_through_a_burst_a_right_drive_passes_and_a_wrong_one_fails(
    tmp_path: Path, seed: int
) -> None:
    """There a shot's drive may be more like the sound elsewhere than at its place, where it is as like as predicted."""
    seat = tmp_path / "rings.toml"
    seat.write_text(RINGING_SEAT, encoding="utf-8")
    onsets = [14_400 + number * 85 * 48 for number in range(5)]
    path = film(tmp_path / "film.wav", onsets, [0.9, 0.8, 0.9, 0.7, 0.9], decay_s=0.02, seed=seed)
    made = rendered(path, onsets, RenderOptions(report=False, actuator=str(seat)))
    assert failures(made) == []
    assert all(event.drive is not None and event.drive.fidelity < 0.7 for event in made.events)
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    third = slice(onsets[2] - 48, onsets[3] - 48)
    for wrong in (np.roll(drive[third], 96), np.zeros_like(drive[third]), drive[third][::-1]):
        changed = drive.copy()
        changed[third] = wrong
        soundfile.write(tmp_path / "wrong.wav", changed, RATE_HZ, subtype="PCM_24")
        checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "wrong.wav", actuator=str(seat))
        assert "shot-0003" in {event for _, event, _ in failures(checked)}


def resonant(path: Path, resonance_hz: float, q: float, up_to_hz: float) -> str:
    """Write the profile of a seat with one resonance, up to a frequency; a full drive is felt by half at most."""
    pole = pole_of(resonance_hz, q)
    at = 2.0j * np.pi * np.geomspace(1.0, up_to_hz, 2000)
    gain = 0.5 / float(np.abs(1.0 / ((at - pole) * (at - pole.conjugate()))).max())
    return seat(path, resonance_hz, q, up_to_hz, gain=gain, zeros_rad_s=())


@pytest.mark.parametrize(
    ("resonance_hz", "q", "up_to_hz", "quality", "phase", "boom_hz"),
    [
        (25.0, 1.0, 500.0, "draft", "zero", 0.0),
        (25.0, 1.0, 500.0, "reference", "causal", 0.0),
        (25.0, 3.0, 500.0, "draft", "causal", 25.0),
        (25.0, 8.0, 1000.0, "reference", "causal", 25.0),
        (40.0, 1.0, 80.0, "draft", "zero", 0.0),
        (40.0, 3.0, 150.0, "reference", "zero", 0.0),
        (40.0, 3.0, 500.0, "draft", "causal", 25.0),
        (58.0, 1.0, 500.0, "reference", "causal", 0.0),
    ],
)
def test_how_well_a_lag_is_known_decides_what_it_is_held_to(
    tmp_path: Path, resonance_hz: float, q: float, up_to_hz: float, quality: Quality, phase: Phase, boom_hz: float
) -> None:
    """What is slow, or at the limit, tells its lag badly; so do the shots of a burst on a seat that rings for long."""
    onsets = [14_400, 21_000, 40_000, 52_000]
    path = film(tmp_path / "film.wav", onsets, [0.9, 0.3, 0.1, 0.6])
    if boom_hz:
        with_booms(path, onsets, boom_hz, peak=0.5)
    seat = resonant(tmp_path / "seat.toml", resonance_hz, q, up_to_hz)
    options = RenderOptions(report=False, actuator=seat, quality=quality, phase=phase)
    assert failures(rendered(path, onsets, options)) == []
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    for by in (-960, 960):
        soundfile.write(tmp_path / "aside.wav", np.roll(drive, by), RATE_HZ, subtype="PCM_24")
        checked = run.check(tmp_path / "out", audio=path, drive=tmp_path / "aside.wav", actuator=seat)
        assert {"drive_shift", "lag_as_rendered"} & {name for name, *_ in failures(checked)}

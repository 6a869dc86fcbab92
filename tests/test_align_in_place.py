"""A drive without a solver is known sample for sample: it is found where it is what is due, whatever a seat rings."""

from pathlib import Path

import numpy as np
import pytest
import soundfile

from blastline import run
from blastline.model import Background, Phase, Timeline
from blastline.run import RenderOptions
from checked_films import RATE_HZ, failures, film, rendered

ONSETS = [14_400 + 4_000 * number for number in range(6)]
PEAKS = [0.3, 0.01, 0.3, 0.02, 0.3, 0.005]

SEAT = """
schema = 1
source = "made for a test"
name = "two resonances"
[response]
source = "51 Hz with a Q of 7, 190 Hz with one of 3: it falls by 24 dB per octave, and all is scaled down for that"
gain = 2.3e10
zeros_rad_s = []
poles_rad_s = [[-24.0, 320.0], [-24.0, -320.0], [-200.0, 1180.0], [-200.0, -1180.0]]
[lowpass]
source = "made for a test"
corner_hz = 1000.0
order = 5
[highpass]
source = "made for a test"
corner_hz = 11.0
order = 1
"""


def made_on_a_seat_that_rings(path: Path, phase: Phase, background: Background) -> Timeline:
    seat = path.with_name("seat.toml")
    seat.write_text(SEAT)
    film(path, ONSETS, PEAKS)
    options = RenderOptions(report=False, drive="filter", actuator=str(seat), phase=phase, background=background)
    return rendered(path, ONSETS, options)


@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("background", ["mute", "direct"])
def test_soft_shots_among_loud_ones_are_in_their_place_on_a_seat_that_rings(
    tmp_path: Path, phase: Phase, background: Background
) -> None:
    made = made_on_a_seat_that_rings(tmp_path / "film.wav", phase, background)
    assert failures(made) == []
    apart = [check.measured for check in made.checks if check.name == "drive_as_rendered"]
    assert max(each for each in apart if each is not None) < 1e-3


@pytest.mark.parametrize("late", [-1, 1, 5])
def test_what_is_displaced_is_not_taken_to_be_in_its_place(tmp_path: Path, late: int) -> None:
    made_on_a_seat_that_rings(tmp_path / "film.wav", "causal", "mute")
    drive, _ = soundfile.read(tmp_path / "out" / "drive.wav")
    soundfile.write(tmp_path / "late.wav", np.roll(drive, late), RATE_HZ, subtype="PCM_24")
    checked = run.check(
        tmp_path / "out", audio=tmp_path / "film.wav", drive=tmp_path / "late.wav", actuator=str(tmp_path / "seat.toml")
    )
    figures = {name: figure for name, _, figure in failures(checked)}
    assert figures["drive_shift"] == pytest.approx(late, abs=0.3)


def test_a_direct_drive_that_is_at_its_limit_throughout_is_due(tmp_path: Path) -> None:
    samples = 0.2 + 1e-3 * np.random.default_rng(6).standard_normal(40_000)
    samples[20_000:20_400] += 0.5
    soundfile.write(tmp_path / "film.wav", samples, RATE_HZ, subtype="PCM_24")
    options = RenderOptions(report=False, drive="direct", level_db=24.0)
    made = rendered(tmp_path / "film.wav", [20_000], options)
    (apart,) = (check.measured for check in made.checks if check.name == "drive_as_rendered")
    assert apart == pytest.approx(0.0, abs=1e-3)

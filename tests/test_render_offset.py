"""A film that stands off zero is driven as one that does not: the band has nothing of a constant."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
import soundfile

from blastline import dsp, run
from blastline.actuator.profile import profile_text
from blastline.model import DriveModel, Phase
from blastline.render import drive_filters
from blastline.ruleset import load_actuator
from blastline.run import RenderOptions
from blastline.study.stability_signals import drive_of, shot_film
from commands import RATE_HZ

PROFILE, _ = load_actuator("crowson-t108sm")
ONSET = 60_000  # later than the filters take to settle


@pytest.mark.parametrize("rate_hz", [8_000, 48_000, 192_000])
@pytest.mark.parametrize("model", ["filter", "constrained"])
@pytest.mark.parametrize("phase", ["causal", "zero"])
def test_a_constant_under_the_film_changes_nothing_of_its_drive(rate_hz: int, model: DriveModel, phase: Phase) -> None:
    filters = drive_filters(PROFILE, rate_hz, phase)
    onset = ONSET * rate_hz // RATE_HZ
    film = shot_film(frames=2 * onset, onset=onset, scale=0.1, rate_hz=rate_hz)
    film += 1e-4 * np.random.default_rng(5).standard_normal(film.size)
    length = rate_hz // 10
    plain = drive_of(film, onset, model, filters, length=length)
    assert np.max(np.abs(plain)) > 0.1
    for offset in (0.8, -0.5):
        shifted = drive_of(film + offset, onset, model, filters, length=length)
        np.testing.assert_allclose(shifted, plain, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("model", ["filter", "constrained"])
@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("onset_s", [0.0, 0.02, 0.1])
@pytest.mark.parametrize("bed", [0.0, 0.02])
def test_a_constant_changes_nothing_where_a_film_begins(
    model: DriveModel, phase: Phase, onset_s: float, bed: float
) -> None:
    """There is too little before the shot to tell the constant by, and from rest the filters hear it as a step."""
    onset = round(onset_s * RATE_HZ)
    film = shot_film(frames=2 * RATE_HZ, onset=onset, scale=0.1)
    film += bed * np.random.default_rng(5).standard_normal(film.size)
    filters = drive_filters(PROFILE, RATE_HZ, phase)
    plain = drive_of(film, onset, model, filters)
    for offset in (0.8, -0.05):
        shifted = drive_of(film + offset, onset, model, filters)
        np.testing.assert_allclose(shifted, plain, rtol=0.0, atol=1e-7 + 0.3 * bed)  # as well as noise lets it be known


@pytest.mark.parametrize("rate_hz", [8_000, 48_000, 192_000])
def test_what_a_film_stands_on_is_told_by_as_long_a_beginning_at_any_rate(rate_hz: int) -> None:
    seconds = dsp.opening_frames(10**9, rate_hz) / rate_hz
    assert seconds == dsp.opening_frames(10**9, RATE_HZ) / RATE_HZ > 0.5
    assert dsp.opening_frames(rate_hz // 10, rate_hz) == rate_hz // 10


def test_a_boom_that_a_short_film_begins_with_is_no_constant() -> None:
    boom = np.sin(2.0 * np.pi * 4.0 * np.arange(RATE_HZ // 5) / RATE_HZ + 0.1)
    assert dsp.opening_level(boom, RATE_HZ) == 0.0
    hum = 0.25 + 1e-3 * np.random.default_rng(5).standard_normal(RATE_HZ // 5)
    assert dsp.opening_level(hum, RATE_HZ) == 0.0
    quiet = np.concatenate([np.zeros(16), np.full(RATE_HZ, 0.25)])
    assert dsp.opening_level(quiet, RATE_HZ) == 0.0
    assert dsp.opening_level(np.zeros(0), RATE_HZ) == 0.0
    rumble = np.random.default_rng(5).standard_normal(RATE_HZ).cumsum()
    assert dsp.opening_level(rumble - rumble.mean(), RATE_HZ) == 0.0


@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("onset", [500, 9_600])
def test_a_shot_soon_after_a_film_begins_off_zero_passes_its_checks(tmp_path: Path, phase: Phase, onset: int) -> None:
    film = 0.1 * shot_film(frames=2 * RATE_HZ, onset=onset) + 0.05
    film += 1e-4 * np.random.default_rng(5).standard_normal(film.size)
    soundfile.write(tmp_path / "film.wav", film, RATE_HZ, subtype="FLOAT")
    (tmp_path / "shots.csv").write_text(f"id,onset_sample,origin\nshot-0001,{onset},found\n")
    options = RenderOptions(report=False, timeline=tmp_path / "shots.csv", phase=phase)
    made = run.render(tmp_path / "film.wav", tmp_path / "out", options)
    assert [check.name for check in made.checks if not check.passed] == []


@pytest.mark.parametrize("onset_s", [0.5, 0.7, 1.7])
def test_what_a_film_stands_on_at_its_end_is_one_for_the_drive_and_its_checks(tmp_path: Path, onset_s: float) -> None:
    """Where a band runs backwards, it hears that as a step, up to what was taken for the constant."""
    onset = round(onset_s * RATE_HZ)
    film = 0.1 * shot_film(frames=onset + round(0.19 * RATE_HZ), onset=onset) + 0.02
    film[onset - round(0.3 * RATE_HZ) :] += 0.03
    film += 1e-4 * np.random.default_rng(5).standard_normal(film.size)
    soundfile.write(tmp_path / "film.wav", film, RATE_HZ, subtype="FLOAT")
    (tmp_path / "shots.csv").write_text(f"onset_sample\n{onset}\n{onset + 4_800}\n")
    options = RenderOptions(report=False, timeline=tmp_path / "shots.csv", phase="zero", drive="filter")
    made = run.render(tmp_path / "film.wav", tmp_path / "out", options)
    assert [check.name for check in made.checks if not check.passed] == []


@pytest.mark.parametrize(
    ("low_hz", "order", "onset_s", "moved_s"), [(2.0, 4, 2.2, 0.6), (5.0, 4, 0.9, 0.45), (2.0, 1, 1.3, 0.7)]
)
def test_the_checks_of_any_seat_take_off_what_its_drive_was_made_without(
    tmp_path: Path, low_hz: float, order: int, onset_s: float, moved_s: float
) -> None:
    """Half a band, as it is without phase, rings for longer or shorter than the whole, and has another pre-roll."""
    highpass = msgspec.structs.replace(PROFILE.highpass, corner_hz=low_hz, order=order)
    seat = tmp_path / "seat.toml"
    seat.write_text(profile_text(msgspec.structs.replace(PROFILE, highpass=highpass)), "utf-8")
    onset = round(onset_s * RATE_HZ)
    film = 0.1 * shot_film(frames=onset + round(0.19 * RATE_HZ), onset=onset) + 0.02
    film[round(moved_s * RATE_HZ) :] += 0.03
    film += 1e-4 * np.random.default_rng(5).standard_normal(film.size)
    soundfile.write(tmp_path / "film.wav", film, RATE_HZ, subtype="FLOAT")
    (tmp_path / "shots.csv").write_text(f"onset_sample\n{onset}\n{onset + 4_800}\n")
    options = RenderOptions(
        report=False, timeline=tmp_path / "shots.csv", phase="zero", drive="filter", actuator=str(seat)
    )
    made = run.render(tmp_path / "film.wav", tmp_path / "out", options)
    assert [check.name for check in made.checks if not check.passed] == []


@pytest.mark.parametrize("phase", ["causal", "zero"])
def test_a_faint_film_on_a_large_constant_passes_its_checks(tmp_path: Path, phase: Phase) -> None:
    film = 0.01 * shot_film(frames=3 * RATE_HZ, onset=ONSET) + 0.9
    soundfile.write(tmp_path / "film.wav", film, RATE_HZ, subtype="FLOAT")
    (tmp_path / "shots.csv").write_text(f"id,onset_sample,origin\nshot-0001,{ONSET},found\n")
    options = RenderOptions(report=False, timeline=tmp_path / "shots.csv", phase=phase)
    made = run.render(tmp_path / "film.wav", tmp_path / "out", options)
    assert [check.name for check in made.checks if not check.passed] == []


@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("offset", [0.0, 0.02])
def test_a_shot_in_the_preroll_is_no_constant_where_the_film_ends_after_the_next(
    tmp_path: Path, phase: Phase, offset: float
) -> None:
    """What is taken off the film as a constant leaves a step where it ends, which runs backwards into its last shot."""
    rng = np.random.default_rng(5)
    film = 1e-4 * rng.standard_normal(round(2.2 * RATE_HZ))
    onsets = [round(second * RATE_HZ) for second in (0.3, 1.65, 2.0)]
    times_s = np.arange(round(0.4 * RATE_HZ)) / RATE_HZ
    for onset in onsets:
        bang = (1.0 - times_s / 0.0015) * np.exp(-times_s / 0.0015) + 0.3 * np.sin(440.0 * times_s) * np.exp(
            -times_s / 0.08
        )
        film[onset : onset + bang.size] += 0.6 * bang[: film.size - onset]
    soundfile.write(tmp_path / "film.wav", film + offset, RATE_HZ, subtype="FLOAT")
    (tmp_path / "shots.csv").write_text("onset_sample\n" + "".join(f"{onset}\n" for onset in onsets))
    options = RenderOptions(report=False, timeline=tmp_path / "shots.csv", phase=phase, drive="filter")
    made = run.render(tmp_path / "film.wav", tmp_path / "out", options)
    assert [check.name for check in made.checks if not check.passed] == []

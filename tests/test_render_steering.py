"""Seats that answer strongly above the band: in every tier the solver's corners lie close enough to steer them."""

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from blastline import dsp
from blastline.actuator import profile_text
from blastline.model import Phase, Quality
from blastline.render import drive_filters, hear_window, plan_windows, render_window
from blastline.ruleset import ActuatorProfile, RenderRules, load_rules
from blastline.run import RenderOptions
from checked_films import failures, film, rendered
from render_signals import PROFILE, RATE_HZ, WINDOWS, clip, film_with_shot

FINEST = {"solver_rate_hz": RATE_HZ, "iterations": 60, "polish_iterations": 30, "tolerance": 1e-6}


def seat(resonance_hz: float, q: float) -> ActuatorProfile:
    """Return a seat with one resonance, felt of a full drive at most by half in the band."""
    pole = 2.0 * math.pi * resonance_hz * complex(-0.5 / q, math.sqrt(1.0 - 0.25 / q**2))
    raw = msgspec.structs.replace(
        PROFILE.response, gain=1.0, poles_rad_s=((pole.real, pole.imag), (pole.real, -pole.imag))
    )
    profile = msgspec.structs.replace(PROFILE, name="seat", response=raw)
    in_band_hz = np.geomspace(profile.highpass.corner_hz, profile.lowpass.corner_hz, 500)
    gain = 0.5 / float(np.max(np.abs(dsp.felt_response(profile).at(in_band_hz))))
    return msgspec.structs.replace(profile, response=msgspec.structs.replace(raw, gain=gain))


def explained(profile: ActuatorProfile, rules: RenderRules) -> float:
    """Return the share of the wanted energy that the drive of a shot makes felt."""
    sound, shot = film_with_shot((1.5, 250.0, 18.0))
    (planned,) = plan_windows([shot], frames=len(sound), rate_hz=RATE_HZ, rules=WINDOWS)
    heard = hear_window(clip(sound), planned, filters=drive_filters(profile, RATE_HZ, "zero"), rules=rules)
    done = render_window(heard, [shot], model="constrained", reason="a test", background="mute")
    share = done.drives[0].explained
    assert share is not None
    return share


@pytest.mark.parametrize("quality", ["draft", "standard"])
@pytest.mark.parametrize(("resonance_hz", "q"), [(1200.0, 3.0), (2000.0, 10.0), (3500.0, 10.0), (5000.0, 5.0)])
def test_a_seat_that_resonates_above_the_band_loses_no_more_than_a_tier_may(
    quality: Quality, resonance_hz: float, q: float
) -> None:
    profile, rules = seat(resonance_hz, q), load_rules(quality).tier.render
    best = explained(profile, msgspec.structs.replace(rules, **FINEST))
    assert explained(profile, rules) >= 0.98 * best


@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize(("resonance_hz", "q"), [(1200.0, 3.0), (2000.0, 3.0), (3500.0, 10.0)])
def test_the_draft_of_a_burst_on_a_seat_that_resonates_above_the_band_passes(
    tmp_path: Path, phase: Phase, resonance_hz: float, q: float
) -> None:
    path = tmp_path / "seat.toml"
    path.write_text(profile_text(seat(resonance_hz, q)), encoding="utf-8")
    onsets = [14_400, 18_240, 22_080, 48_000]
    heard = film(tmp_path / "film.wav", onsets, [0.9, 0.7, 0.8, 0.3], seed=7)
    options = RenderOptions(report=False, quality="draft", drive="constrained", phase=phase, actuator=str(path))
    assert failures(rendered(heard, onsets, options)) == []


@pytest.mark.parametrize("rate_hz", [8_000, 48_000, 192_000])
def test_the_built_in_seat_is_steered_by_the_corners_of_every_tier(rate_hz: int) -> None:
    stride = drive_filters(PROFILE, rate_hz, "causal").recursion.longest_stride
    assert all(
        stride >= max(1, rate_hz // load_rules(quality).tier.render.solver_rate_hz)
        for quality in ("draft", "standard", "reference")
    )

"""Seats that no drive can be made for are refused with one line: too strong, too weak, ringing, or out of the rate."""

import math
from contextlib import nullcontext

import msgspec
import numpy as np
import pytest

from blastline import dsp
from blastline.errors import RuleError
from blastline.render import require_renderable
from blastline.ruleset import ActuatorProfile
from render_signals import PROFILE, RATE_HZ

Roots = tuple[tuple[float, float], ...]


def with_roots(poles: Roots, zeros: Roots = ()) -> ActuatorProfile:
    """Return a seat with these roots, felt at 1 at 100 Hz, whose low-pass is steep enough for its compensator."""
    response = msgspec.structs.replace(PROFILE.response, gain=1.0, poles_rad_s=poles, zeros_rad_s=zeros)
    lowpass = msgspec.structs.replace(PROFILE.lowpass, order=len(poles) + 1)
    return at_gain(msgspec.structs.replace(PROFILE, response=response, lowpass=lowpass), 1.0, at_hz=100.0)


def at_gain(profile: ActuatorProfile, gain: float, *, at_hz: float) -> ActuatorProfile:
    """Return a seat that is felt so strongly at a frequency."""
    now = float(np.abs(dsp.felt_response(profile).at(np.array([at_hz])))[0])
    response = msgspec.structs.replace(profile.response, gain=profile.response.gain * gain / now)
    return msgspec.structs.replace(profile, response=response)


def pair(corner_hz: float, damping: float) -> Roots:
    corner = 2.0 * math.pi * corner_hz
    across = corner * math.sqrt(1.0 - damping**2)
    return ((-damping * corner, across), (-damping * corner, -across))


@pytest.mark.parametrize(
    ("poles", "strongest_hz"),
    [(((-20.0, 0.0),) * 4, 1.0), (pair(15_000.0, 0.005), 15_000.0), (pair(900.0, 0.001), 900.0)],
)
def test_what_is_felt_is_bounded_from_1_hz_to_half_the_rate(poles: Roots, strongest_hz: float) -> None:
    """Of a seat that only creeps, of one that only whistles, and of one that rings far more sharply than any."""
    for gain, refused in ((0.9e6, False), (1.1e6, True)):
        profile = at_gain(with_roots(poles), gain, at_hz=strongest_hz)
        with pytest.raises(RuleError, match=r"peaks at 1\.1\d*e\+06") if refused else nullcontext():
            require_renderable(profile, RATE_HZ)


@pytest.mark.parametrize("gain", [1e300, 1.7e308])
def test_a_gain_beyond_all_numbers_is_refused_without_a_warning(gain: float) -> None:
    response = msgspec.structs.replace(PROFILE.response, gain=gain)
    with pytest.raises(RuleError, match="what is felt of a full drive peaks at"):
        require_renderable(msgspec.structs.replace(PROFILE, response=response), RATE_HZ)


def test_a_seat_that_rings_for_ever_is_refused() -> None:
    for slow in (0.0, 3.0):
        with pytest.raises(RuleError, match="expected a negative real part"):
            require_renderable(with_roots(((slow, 900.0), (slow, -900.0), (-1400.0, 0.0))), RATE_HZ)


@pytest.mark.parametrize("kind", ["poles", "zeros"])
@pytest.mark.parametrize("damping", [0.6, 0.8])
def test_no_corner_of_a_seat_is_at_half_the_rate_or_above(kind: str, damping: float) -> None:
    """A root's corner is its distance from 0."""
    poles = PROFILE.response.poles_rad_s
    for corner_hz, refused in ((23_976.0, False), (24_000.0, True), (24_024.0, True)):
        roots = pair(corner_hz * (1.0 + 1e-12), damping)
        profile = with_roots((*poles, *roots)) if kind == "poles" else with_roots(poles, roots)
        told = rf"response\.{kind}_rad_s\[\d\]: {corner_hz:g} Hz: expected below 24000 Hz"
        with pytest.raises(RuleError, match=told) if refused else nullcontext():
            require_renderable(profile, RATE_HZ)

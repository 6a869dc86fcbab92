"""Whether a drive can be made for an actuator at a film's sample rate."""

import math

import numpy as np

from .. import dsp
from ..errors import RuleError
from ..ruleset import ActuatorProfile, check_stable

_LARGEST_GAIN = 1e6  # 120 dB either way: beyond any unit that an actuator is measured in


def require_renderable(profile: ActuatorProfile, rate_hz: int) -> None:
    """Raise RuleError where a corner of the profile is not below half the sample rate, or nothing can compensate it."""
    _check_corners(profile, rate_hz)
    check_stable(profile, profile.name)
    _check_gain(profile, rate_hz)


def _check_gain(profile: ActuatorProfile, rate_hz: int) -> None:
    felt = dsp.felt_response(profile)
    with np.errstate(over="ignore", invalid="ignore"):
        peak = float(np.max(np.abs(felt.at(dsp.telling_hz(felt, 1.0, rate_hz / 2.0, 200)))))
    if not 1.0 / _LARGEST_GAIN <= peak <= _LARGEST_GAIN:
        raise RuleError(
            f"{profile.name}: response.gain = {profile.response.gain:g}: what is felt of a full drive peaks at "
            f"{peak:g}; expected {1.0 / _LARGEST_GAIN:g} to {_LARGEST_GAIN:g}"
        )


def _check_corners(profile: ActuatorProfile, rate_hz: int) -> None:
    nyquist_hz = rate_hz / 2.0
    corners = [("lowpass.corner_hz", profile.lowpass.corner_hz), ("highpass.corner_hz", profile.highpass.corner_hz)]
    for kind, roots in (("poles", profile.response.poles_rad_s), ("zeros", profile.response.zeros_rad_s)):
        corners += [
            (f"response.{kind}_rad_s[{index}]", math.hypot(real, imaginary) / (2.0 * math.pi))
            for index, (real, imaginary) in enumerate(roots)
        ]
    for key, corner_hz in corners:
        if corner_hz >= nyquist_hz:
            raise RuleError(
                f"{profile.name}: {key}: {corner_hz:g} Hz: expected below {nyquist_hz:g} Hz, "
                f"half the soundtrack's sample rate of {rate_hz} Hz"
            )

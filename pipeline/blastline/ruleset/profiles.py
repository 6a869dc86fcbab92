"""The tables of an actuator profile, and which of them can be compensated."""

from pathlib import Path
from typing import Annotated, Literal

from msgspec import Meta

from ..errors import RuleError
from .table import Positive, Table

DEFAULT_ACTUATOR = "crowson-t108sm"
"""The profile that is taken where nobody names one."""

SLOWEST_RAD_S = -1.0
"""The slowest decay of an actuator, as the real part of a zero or pole: filters keep all of it in memory."""


class LowPass(Table, frozen=True):
    """The Butterworth low-pass that follows the compensator: its `corner_hz` and its `order`."""

    corner_hz: Positive
    order: Annotated[int, Meta(ge=1, le=12)]


class HighPass(Table, frozen=True):
    """The Butterworth high-pass that keeps DC and rumble out of the drive: its `corner_hz` and its `order`."""

    corner_hz: Annotated[float, Meta(ge=0.1, le=1e6)]
    order: Annotated[int, Meta(ge=1, le=4)]


class Response(Table, frozen=True):
    """The felt response of actuator and skin together, H(s) = gain * prod(s - zero) / prod(s - pole).

    `gain` is that of the formula, `zeros_rad_s` and `poles_rad_s` its zeros and poles as [real, imaginary] pairs;
    complex ones are listed with their conjugate.
    """

    gain: Annotated[float, Meta(gt=0.0)]
    zeros_rad_s: tuple[tuple[float, float], ...]
    poles_rad_s: Annotated[tuple[tuple[float, float], ...], Meta(min_length=1)]


class ActuatorProfile(Table, frozen=True):
    """`actuators/*.toml`: a seat actuator with the skin behind it, the filters its drive needs, and its `name`."""

    schema: Literal[1]
    name: Annotated[str, Meta(min_length=1)]
    response: Response
    lowpass: LowPass
    highpass: HighPass


def check_name(name: str, path: Path | str) -> None:
    """Raise RuleError for a profile's name that is no line of text; `path` as for `check_stable`."""
    if not name.isprintable():
        raise RuleError(f"{path}: name = {name!r}: expected printable characters alone")


def check_stable(profile: ActuatorProfile, path: Path | str) -> None:
    """Raise RuleError where a pole does not decay, a zero has no stable inverse, or no band is left.

    `path` is what the message begins with: the profile's file, or its name.
    """
    response = profile.response
    for kind, roots in (("pole", response.poles_rad_s), ("zero", response.zeros_rad_s)):
        for index, (real, imaginary) in enumerate(roots):
            where = f"{path}: response.{kind}s_rad_s[{index}] = [{real}, {imaginary}]"
            if real >= 0.0:
                raise RuleError(f"{where}: expected a negative real part (stable, minimum phase)")
            if real > SLOWEST_RAD_S:
                raise RuleError(
                    f"{where}: expected a real part of {SLOWEST_RAD_S:g} or less (it rings for {-5 / real:.2g} s)"
                )
            if roots.count((real, -imaginary)) != roots.count((real, imaginary)):
                raise RuleError(f"{where}: expected its conjugate [{real}, {-imaginary}] in the list as well")
    if len(response.zeros_rad_s) >= len(response.poles_rad_s):
        raise RuleError(f"{path}: response: expected more poles than zeros (an actuator cannot follow any frequency)")
    excess = len(response.poles_rad_s) - len(response.zeros_rad_s)
    if profile.lowpass.order <= excess:
        raise RuleError(
            f"{path}: lowpass.order = {profile.lowpass.order}: expected more than {excess}, "
            "the compensator's rise per octave, so that its gain falls above the band"
        )
    if profile.highpass.corner_hz >= profile.lowpass.corner_hz:
        raise RuleError(
            f"{path}: highpass.corner_hz = {profile.highpass.corner_hz:g}: expected below lowpass.corner_hz = "
            f"{profile.lowpass.corner_hz:g}; nothing would be left between them"
        )

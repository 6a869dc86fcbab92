"""A fitted model as an actuator profile, with the band filters that its drive needs, and as the text of its file."""

import tomllib
from pathlib import Path

from ..dsp import felt_response
from ..plurals import counted
from ..ruleset import ActuatorProfile, FitRules, Response, check_name, check_stable, convert, toml_lines
from ..units import gain_from_db
from .fit import FittedResponse
from .inverse import band_filters, peak
from .rational import analogue


def fitted_profile(
    fitted: FittedResponse, *, name: str, source: str, origin: str, rules: FitRules, peak_db: float | None = None
) -> ActuatorProfile:
    """Return the profile of a fitted response; its peak gets the level `peak_db`, or stays as measured.

    Raises RuleError where it is one that `load_actuator` would not read.
    """
    check_name(name, name)
    model = fitted.best.model
    felt = analogue(model)
    raised = 0.0 if peak_db is None else peak_db - peak(model, fitted.target.band_hz)[1]
    low, high = band_filters(model, fitted.target, rules=rules)
    profile = ActuatorProfile(
        source=source,
        schema=1,
        name=name,
        response=Response(
            source=origin,
            gain=felt.gain * gain_from_db(raised),
            zeros_rad_s=_pairs(felt.zeros.tolist()),
            poles_rad_s=_pairs(felt.poles.tolist()),
        ),
        lowpass=low,
        highpass=high,
    )
    check_stable(profile, Path(name))
    return convert(tomllib.loads(profile_text(profile)), ActuatorProfile, Path(name))


def profile_text(profile: ActuatorProfile) -> str:
    """Return a profile as the text of a TOML file, which `load_actuator` reads as the same profile."""
    return "\n".join([f"# {_formula(profile)}", *toml_lines(profile)]) + "\n"


def _formula(profile: ActuatorProfile) -> str:
    felt = felt_response(profile)
    zeros, poles = counted(len(felt.zeros), "zero"), counted(len(felt.poles), "pole")
    return f"H(s) = gain * prod(s - zero) / prod(s - pole), {zeros} and {poles} in rad/s as [real, imaginary]"


def _pairs(roots: list[complex]) -> tuple[tuple[float, float], ...]:
    """Return roots as [real, imaginary], slowest first."""
    ordered = sorted(roots, key=lambda root: (abs(root), root.imag))
    return tuple((root.real, root.imag) for root in ordered)

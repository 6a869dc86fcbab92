"""Bode plots of an actuator, with what was measured of it."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..actuator import MeasuredResponse, minimum_phase, read_measured, sensitivity_db
from ..dsp import felt_response
from ..errors import OutputError
from ..report import BodeCurve, write_bode
from ..ruleset import ActuatorProfile, PerceptionCurve, load_actuator, load_perception
from ..staging import staged
from ..units import gains_from_db, levels_db

NO_PERCEPTION = "none"
_PICTURES = (".png", ".svg", ".pdf")
_POINTS_PER_OCTAVE = 48


def draw_bode(
    name: str,
    picture: Path,
    *,
    measured: Path | None = None,
    perception: str = NO_PERCEPTION,
    rules: Path | None = None,
    overwrite: bool = False,
) -> None:
    """Draw an actuator's Bode plots into a .png, .svg or .pdf file: what is felt and the compensator; with a measured
    response, or a perception curve, those as well.

    Raises BlastlineError for a profile, a file or a curve that cannot be used; nothing is written then.
    """
    profile, _ = load_actuator(name, rules)
    curve = perception_curve(perception, rules)
    response = read_measured(measured) if measured else None
    if picture.suffix.lower() not in _PICTURES:
        raise OutputError(f"{picture}: expected a name that ends in {', '.join(_PICTURES)}")
    with staged(picture.parent, names=[picture.name], overwrite=overwrite) as hidden:
        write_bode(
            hidden / picture.name,
            profile,
            actuator=_actuator_curve(response) if response else None,
            skin=_skin_curve(curve) if curve else None,
            product=_product_curve(response, curve, profile) if response else None,
        )


def _actuator_curve(measured: MeasuredResponse) -> BodeCurve:
    """Return a measured response to draw; where its phase was not measured, that of its magnitude."""
    phase_rad = measured.phase_rad
    if phase_rad is None:
        phase_rad = _minimum_phase(measured)
    return BodeCurve(
        measured.frequencies_hz, measured.gain_db, np.degrees(phase_rad), measured.coherence, measured.band_hz
    )


def _minimum_phase(measured: MeasuredResponse) -> NDArray[np.float64]:
    """Return the phase that belongs to the gains, worked out at some points of each octave: it takes room squared."""
    log_f = np.log2(measured.frequencies_hz)
    _, some = np.unique(np.floor(log_f * _POINTS_PER_OCTAVE), return_index=True)
    phase_rad = minimum_phase(measured.frequencies_hz[some], measured.gain[some])
    return np.asarray(np.interp(log_f, log_f[some], phase_rad))


def _skin_curve(curve: PerceptionCurve) -> BodeCurve:
    frequencies_hz = np.geomspace(curve.frequencies_hz[0], curve.frequencies_hz[-1], 200)
    level_db = sensitivity_db(curve, frequencies_hz)
    return BodeCurve(frequencies_hz, level_db, np.degrees(minimum_phase(frequencies_hz, gains_from_db(level_db))))


def _product_curve(measured: MeasuredResponse, curve: PerceptionCurve | None, profile: ActuatorProfile) -> BodeCurve:
    """Return actuator times skin, at the level that the profile was given."""
    inside = measured.within(*(_ends(curve) if curve else (0.0, np.inf)))
    level_db = inside.gain_db + (sensitivity_db(curve, inside.frequencies_hz) if curve else 0.0)
    low_hz, high_hz = profile.highpass.corner_hz, profile.lowpass.corner_hz
    driven = (inside.frequencies_hz >= low_hz) & (inside.frequencies_hz <= high_hz)
    if np.any(driven):
        model_db = levels_db(np.abs(felt_response(profile).at(inside.frequencies_hz[driven])))
        level_db = level_db + np.median(model_db - level_db[driven])
    phase_deg = None if inside.phase_rad is None or curve else np.degrees(inside.phase_rad)
    return BodeCurve(inside.frequencies_hz, level_db, phase_deg)


def perception_curve(name: str, rules: Path | None = None) -> PerceptionCurve | None:
    """Return a curve by its name or file; None for `none`. Raises RuleError where there is no such curve."""
    return None if name == NO_PERCEPTION else load_perception(name, rules)


def _ends(curve: PerceptionCurve) -> tuple[float, float]:
    return curve.frequencies_hz[0], curve.frequencies_hz[-1]

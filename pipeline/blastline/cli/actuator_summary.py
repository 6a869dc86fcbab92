"""What is told of an actuator: its profile, its measurement, its fit; on standard output, as it is the result."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import typer

from ..plurals import counted
from ..ruleset import ActuatorProfile

if TYPE_CHECKING:
    from ..run import MadeProfile

_FAR_FROM_0_DB = 20.0
_POOR_DB = 1.0
_STRANGE_DEG = 40.0
"""Beyond this, a phase and its opposite are nearly as far from minimum phase."""


def say_profile(profile: ActuatorProfile, digest: str, rows: Iterable[tuple[float, float, float, float]]) -> None:
    """Print a profile's name, source and band, and a table with the rows of `run.actuator_table`."""
    low, high = profile.lowpass, profile.highpass
    typer.echo(f"name    {profile.name}\nsource  {profile.source}\ndigest  {digest}")
    typer.echo(f"band    {high.corner_hz:g} Hz (order {high.order}) to {low.corner_hz:g} Hz (order {low.order})\n")
    typer.echo(f"{'Hz':>8} {'H dB':>8} {'H deg':>8} {'C dB':>8}")
    for frequency_hz, felt_db, felt_deg, compensator_db in rows:
        typer.echo(f"{frequency_hz:8.4g} {felt_db:8.2f} {felt_deg:8.1f} {compensator_db:8.2f}")


def say_measured(made: "MadeProfile") -> None:
    """Print what two recordings tell of each other."""
    identified = made.identified
    assert identified is not None
    measured, excess = identified.measured, identified.excess
    low_hz, high_hz = measured.band_hz
    _say("delay", f"{1000.0 * measured.delay_s:.3f} ms, taken out")
    _say("polarity", _polarity(excess.residual_rms_deg, inverted=excess.inverted))
    _say("phase", f"{excess.residual_rms_deg:.1f} degrees rms off that of the levels (minimum phase)")
    _say(
        "usable",
        f"{low_hz:.4g} to {high_hz:.4g} Hz, by the coherence of {identified.segments} segments of "
        f"{identified.segment_s:g} s",
    )


def say_fitted(made: "MadeProfile") -> None:
    """Print which model was chosen, how near it comes, and what it asks of the drive."""
    fitted = made.fitted
    model = fitted.best.model
    low_hz, high_hz = fitted.target.band_hz
    if fitted.best.is_papers:
        rival = "the form of eq. (2)"
    elif fitted.papers is not None:
        rival = f"the form of eq. (2) is {fitted.papers.error_db:.2f} dB off"
    else:
        rival = "the form of eq. (2) exceeds the bound"
    _say("model", f"{counted(model.zeros, 'zero')}, {counted(model.poles, 'pole')}; {rival}")
    _say("fitted", f"{low_hz:.4g} to {high_hz:.4g} Hz, {fitted.best.error_db:.2f} dB rms")
    _say("felt best", f"at {made.peak_hz:.4g} Hz, {made.peak_db:+.1f} dB")
    _say("inverse", f"gains {made.inversion_db:.1f} dB more at its worst frequency than at its best")
    if made.identified is None and made.excess is not None and made.excess.inverted:
        _say("polarity", _polarity(made.excess.residual_rms_deg, inverted=True))
    if fitted.best.error_db > _POOR_DB:
        shown = "`actuator show --picture --measured`, with the same --perception,"
        _say("note", f"the model is far from the measurement; {shown} shows where")
    if abs(made.peak_db) > _FAR_FROM_0_DB and not made.asked:
        _say("note", "this level is the recorder's unless it was calibrated; --peak-db sets it (-7 dB is usual)")
    typer.echo(f"\n{'octave Hz':>9} {'felt dB':>8} {'mean dB':>8} {'rms dB':>8} {'worst dB':>9}")
    for row in made.errors:
        errors = f"{row.mean_db:+8.2f} {row.rms_db:8.2f} {row.worst_db:+9.2f}"
        typer.echo(f"{_nominal(row.centre_hz):>9} {row.level_db:8.2f} {errors}")


def _polarity(residual_rms_deg: float, *, inverted: bool) -> str:
    """Return what a phase tells of polarity; one that is far from minimum phase with any delay tells nothing."""
    if residual_rms_deg > _STRANGE_DEG:
        return f"not known: with any delay, the phase is {residual_rms_deg:.0f} degrees rms off that of the levels"
    return "inverted: the seat moves against the drive" if inverted else "as sent"


def _say(what: str, text: str) -> None:
    typer.echo(f"{what:<10} {text}")


def _nominal(frequency_hz: float) -> str:
    """Return a frequency as octaves are called: 31.5, 63, 125 Hz and so on for those with the centre 1 kHz."""
    names = {3.90625: "4", 7.8125: "8", 15.625: "16", 31.25: "31.5", 62.5: "63"}
    return names.get(frequency_hz, f"{frequency_hz:.3g}" if frequency_hz < 100.0 else f"{frequency_hz:.0f}")

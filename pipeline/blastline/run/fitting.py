"""A measured response becomes an actuator's profile: fit, give it its level, write it."""

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from ..actuator import (
    BandError,
    ExcessPhase,
    FittedResponse,
    Identified,
    MeasuredResponse,
    excess_phase,
    fit,
    fit_target,
    fitted_profile,
    inversion_db,
    measured_csv,
    octave_errors,
    peak,
    profile_text,
)
from ..errors import RuleError
from ..progress import Progress
from ..render import require_renderable
from ..ruleset import ActuatorProfile, FitRules, PerceptionCurve, load_measuring
from ..staging import staged
from .bode_plots import NO_PERCEPTION, perception_curve

_FILM_RATE_HZ = 48_000


@dataclass(frozen=True)
class FitOptions:
    """What a user may ask of a fit, with what they get when they do not ask.

    `peak_db` is the level that the felt response gets at its peak, None leaves it as measured; `largest_gain_db` of
    None is that of the rules.
    """

    perception: str = NO_PERCEPTION
    peak_db: float | None = None
    largest_gain_db: float | None = None
    name: str | None = None
    rules: Path | None = None
    overwrite: bool = False


@dataclass(frozen=True, eq=False)
class MadeProfile:
    """A profile that was written, the fit that it holds with its errors by octave, and what led there.

    The felt response peaks at `peak_hz` with `peak_db`, which was `asked` for or else is as measured. `excess` is None
    where no phase was measured, `identified` where the response came from a CSV file. `warnings` tell what of the
    recordings was damaged, or looks wrong in the table.
    """

    profile: ActuatorProfile
    fitted: FittedResponse
    measured: MeasuredResponse
    errors: tuple[BandError, ...]
    inversion_db: float
    peak_hz: float
    peak_db: float
    asked: bool
    excess: ExcessPhase | None
    identified: Identified | None = None
    warnings: tuple[str, ...] = ()


def fit_and_write(
    measured: MeasuredResponse,
    output: Path,
    options: FitOptions,
    origin: str,
    progress: Progress,
    *,
    identified: Identified | None = None,
    csv: Path | None = None,
) -> MadeProfile:
    """Fit a measured response, whose `origin` is told in a few words, and write its profile, and itself to `csv`.

    `identified` is what it came from, where that was recordings. Raises BlastlineError for rules or a profile that
    cannot be used; nothing is written then.
    """
    rules = load_measuring(options.rules).fit
    if options.largest_gain_db is not None:
        rules = msgspec.structs.replace(rules, largest_gain_db=options.largest_gain_db)
    curve = perception_curve(options.perception, options.rules)
    progress("fitting", 0, None)
    fitted = fit(fit_target(measured, curve, rules=rules, name=origin), rules=rules, name=origin)
    profile = fitted_profile(
        fitted,
        name=options.name or output.stem,
        source=_source(fitted, origin, curve, rules),
        origin="fitted in dB, minimum phase",
        rules=rules,
        peak_db=options.peak_db,
    )
    _require_usable(profile)
    texts = {} if csv is None else {csv: measured_csv(measured, origin)}
    _write({**texts, output: profile_text(profile)}, overwrite=options.overwrite)
    return replace(_made(profile, fitted, measured, rules, options.peak_db), identified=identified)


def _require_usable(profile: ActuatorProfile) -> None:
    """Raise RuleError for a profile that no film could be rendered with."""
    try:
        require_renderable(profile, _FILM_RATE_HZ)
    except RuleError as error:
        raise RuleError(f"{error}; not written: --peak-db gives the level of what is felt") from error


def _write(texts: Mapping[Path, str], *, overwrite: bool) -> None:
    """Write files all together, or none where one cannot be written."""
    with ExitStack() as places:
        for path, text in texts.items():
            hidden = places.enter_context(staged(path.parent, names=[path.name], overwrite=overwrite))
            (hidden / path.name).write_text(text, encoding="utf-8")


def _made(
    profile: ActuatorProfile,
    fitted: FittedResponse,
    measured: MeasuredResponse,
    rules: FitRules,
    asked_peak_db: float | None,
) -> MadeProfile:
    """Return a profile with its fit, whose levels are raised to the peak that was asked for."""
    target = fitted.target
    peak_hz, fitted_peak_db = peak(fitted.best.model, target.band_hz)
    peak_db = fitted_peak_db if asked_peak_db is None else asked_peak_db
    raised_db = peak_db - fitted_peak_db
    return MadeProfile(
        profile,
        fitted,
        measured,
        errors=tuple(replace(row, level_db=row.level_db + raised_db) for row in octave_errors(fitted)),
        inversion_db=inversion_db(fitted.best.model, target, rules=rules),
        peak_hz=peak_hz,
        peak_db=peak_db,
        asked=asked_peak_db is not None,
        excess=excess_phase(measured),
    )


def _source(fitted: FittedResponse, origin: str, curve: PerceptionCurve | None, rules: FitRules) -> str:
    """Return where a profile comes from, in one line."""
    skin = "no perception curve" if curve is None else f"perception {curve.name}, H_m = (1/T)^2 ({curve.source})"
    low_hz, high_hz = fitted.target.band_hz
    rivals = f"; eq. (2)'s form: {fitted.papers.error_db:.2f} dB" if fitted.papers else ""
    return (
        f"Actuator {origin}; {skin}. Fitted from {low_hz:.4g} to {high_hz:.4g} Hz within "
        f"{fitted.best.error_db:.2f} dB rms{rivals}; chosen by Schwarz's criterion with {rules.negligible_db:g} dB "
        f"negligible; inverse bounded to {rules.largest_gain_db:g} dB"
    )

"""An actuator's figures, its measurement, and the profile that comes of it."""

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np

from ..actuator import (
    BandError,
    ExcessPhase,
    FittedResponse,
    Identified,
    MeasuredResponse,
    doubts,
    doubts_of_order,
    excess_phase,
    fit,
    fit_target,
    fitted_profile,
    identify,
    inversion_db,
    measured_csv,
    octave_errors,
    peak,
    profile_text,
    read_measured,
    record,
    require_coherent,
    require_running_along,
    require_unclipped_excitation,
)
from ..dsp import compensator, felt_response
from ..errors import OutputError, RuleError, SoundtrackError
from ..plurals import counted
from ..progress import Progress, no_progress
from ..render import require_renderable
from ..ruleset import (
    ActuatorProfile,
    FitRules,
    PerceptionCurve,
    load_actuator,
    load_measuring,
)
from ..soundtrack import Soundtrack, open_soundtrack
from ..staging import require_free, staged
from ..units import levels_db
from .bode_plots import NO_PERCEPTION, perception_curve
from .options import require_seat

_TABLE_HZ = (1.0, 3.18, 10.0, 20.0, 31.5, 50.0, 80.0, 100.0, 150.0, 200.0, 292.0, 400.0, 500.0, 700.0, 1000.0, 2000.0)

_HIGHEST_RATE_HZ, _FILM_RATE_HZ = 384_000, 48_000


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


def usable_actuator(name: str, rules: Path | None = None) -> tuple[ActuatorProfile, str]:
    """Return a profile and its digest; RuleError for one of which no drive can be made at any rate that films have."""
    profile, digest = load_actuator(name, rules)
    require_seat(name, profile, _HIGHEST_RATE_HZ)
    return profile, digest


def actuator_table(name: str, rules: Path | None = None) -> list[tuple[float, float, float, float]]:
    """Return rows of frequency in Hz, level and phase (degrees) of what is felt, and level of the compensator, in dB.

    Raises RuleError for a profile that does not exist or does not fit.
    """
    profile, _ = load_actuator(name, rules)
    frequencies_hz = np.array(_TABLE_HZ)
    felt = felt_response(profile).at(frequencies_hz)
    drive = compensator(profile).at(frequencies_hz)
    columns = (frequencies_hz, levels_db(np.abs(felt)), np.degrees(np.angle(felt)), levels_db(np.abs(drive)))
    return [(float(f), float(level), float(phase), float(gain)) for f, level, phase, gain in zip(*columns, strict=True)]


def identify_actuator(
    excitation: Path,
    response: Path,
    *,
    output: Path,
    options: FitOptions,
    csv: Path | None = None,
    channels: tuple[int | None, int | None] = (None, None),
    progress: Progress = no_progress,
) -> MadeProfile:
    """Measure an actuator from two recordings, fit it, and write its profile, and its response to `csv`.

    `channels` are those of excitation and response, None for the only one. Raises BlastlineError for recordings, rules
    or files that cannot be used; nothing is written then.
    """
    _require_place(output, csv, options)
    measuring = load_measuring(options.rules)
    with ExitStack() as open_files:
        progress("hearing", 0, None)
        excitation_track = open_files.enter_context(_open_channel(excitation, channels[0], "excitation"))
        response_track = open_files.enter_context(_open_channel(response, channels[1], "response"))
        heard = record(str(excitation), excitation_track), record(str(response), response_track)
        warnings = tuple(
            f"{path}: {each}"
            for path, track in ((excitation, excitation_track), (response, response_track))
            for each in track.source().warnings
        )
        progress("identifying", 0, None)
        identified = identify(*heard, rules=measuring.identify)
        modelled_hz = measuring.fit.highest_hz
        require_running_along(*heard, identified, modelled_hz=modelled_hz, rules=measuring.identify)
        require_unclipped_excitation(*heard, identified, rules=measuring.identify)
    origin = f"measured from {response.name} against {excitation.name}"
    made = _fit_and_write(identified.measured, output, options, origin, progress, identified=identified, csv=csv)
    return replace(made, warnings=(*warnings, *doubts_of_order(identified.measured, excitation, response)))


def fit_actuator(measured: Path, output: Path, *, options: FitOptions, progress: Progress = no_progress) -> MadeProfile:
    """Fit a measured response from a CSV file and write its profile.

    Raises BlastlineError for a measurement, rules or an output that cannot be used; nothing is written then.
    """
    _require_place(output, None, options)
    response = read_measured(measured)
    require_coherent(response, measured, least=load_measuring(options.rules).identify.least_coherence)
    made = _fit_and_write(response, output, options, f"measured in {measured.name}", progress)
    return replace(made, warnings=doubts(response, measured))


def _fit_and_write(
    measured: MeasuredResponse,
    output: Path,
    options: FitOptions,
    origin: str,
    progress: Progress,
    *,
    identified: Identified | None = None,
    csv: Path | None = None,
) -> MadeProfile:
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


def _require_place(profile: Path, csv: Path | None, options: FitOptions) -> None:
    """Raise OutputError, before anything is heard, where the files could not be written.

    And for names under which the commands that go on from here would not take them.
    """
    if profile.suffix != ".toml":
        raise OutputError(f"{profile}: expected a name that ends in .toml, so that --actuator takes it")
    if csv is not None and csv.suffix != ".csv":
        raise OutputError(f"{csv}: expected a name that ends in .csv, so that `actuator fit` takes it")
    for path in (profile, *([csv] if csv is not None else [])):
        require_free(path.parent, names=[path.name], overwrite=options.overwrite)


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


def _open_channel(path: Path, channel: int | None, what: str) -> Soundtrack:
    with open_soundtrack(path, mix="0") as track:
        channels = track.channels
    count = counted(channels, "channel")
    if channel is None and channels > 1:
        raise SoundtrackError(f"{path}: has {count}; expected --{what}-channel N to say which, counted from 0")
    if channel is not None and channel >= channels:
        raise SoundtrackError(f"--{what}-channel {channel}: {path} has {count}, counted from 0")
    return open_soundtrack(path, mix=str(channel or 0))

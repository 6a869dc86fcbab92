"""What `actuator` does: an actuator's figures, and its measurement, from recordings or a table, to its profile."""

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..actuator import (
    doubts,
    doubts_of_order,
    identify,
    read_measured,
    record,
    require_coherent,
    require_running_along,
    require_unclipped_excitation,
)
from ..dsp import compensator, felt_response
from ..errors import OutputError, SoundtrackError
from ..plurals import counted
from ..progress import Progress, no_progress
from ..ruleset import ActuatorProfile, check_name, load_actuator, load_measuring
from ..soundtrack import Soundtrack, open_soundtrack
from ..staging import require_free, require_utf_8
from ..units import levels_db
from .fitting import FitOptions, MadeProfile, fit_and_write
from .options import require_seat

_TABLE_HZ = (1.0, 3.18, 10.0, 20.0, 31.5, 50.0, 80.0, 100.0, 150.0, 200.0, 292.0, 400.0, 500.0, 700.0, 1000.0, 2000.0)

_HIGHEST_RATE_HZ = 384_000


def usable_actuator(name: str, rules: Path | None = None) -> tuple[ActuatorProfile, str]:
    """Return a profile and its digest; RuleError for one of which no drive can be made at any rate that films have."""
    profile, digest = load_actuator(name, rules)
    require_seat(name, profile, _HIGHEST_RATE_HZ)
    return profile, digest


def actuator_table(profile: ActuatorProfile) -> list[tuple[float, float, float, float]]:
    """Return rows of frequency in Hz, level (dB) and phase (degrees) of what is felt, and the compensator's level."""
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
    made = fit_and_write(identified.measured, output, options, origin, progress, identified=identified, csv=csv)
    return replace(made, warnings=(*warnings, *doubts_of_order(identified.measured, excitation, response)))


def fit_actuator(measured: Path, output: Path, *, options: FitOptions, progress: Progress = no_progress) -> MadeProfile:
    """Fit a measured response from a CSV file and write its profile.

    Raises BlastlineError for a measurement, rules or an output that cannot be used; nothing is written then.
    """
    _require_place(output, None, options)
    require_utf_8(measured, advice="rename the file")  # the profile says what it comes from
    response = read_measured(measured)
    require_coherent(response, measured, least=load_measuring(options.rules).identify.least_coherence)
    made = fit_and_write(response, output, options, f"measured in {measured.name}", progress)
    return replace(made, warnings=doubts(response, measured))


def _require_place(profile: Path, csv: Path | None, options: FitOptions) -> None:
    """Raise BlastlineError, before anything is heard, where the files could not be written.

    And for names under which the commands that go on from here would not take them, or that no profile can hold.
    """
    if profile.suffix != ".toml":
        raise OutputError(f"{profile}: expected a name that ends in .toml, so that --actuator takes it")
    if csv is not None and csv.suffix != ".csv":
        raise OutputError(f"{csv}: expected a name that ends in .csv, so that `actuator fit` takes it")
    check_name(options.name or profile.stem, profile)
    require_utf_8(Path(options.perception), advice="rename the file")
    for path in (profile, *([csv] if csv is not None else [])):
        require_free(path.parent, names=[path.name], overwrite=options.overwrite)


def _open_channel(path: Path, channel: int | None, what: str) -> Soundtrack:
    with open_soundtrack(path, mix="0") as track:
        channels = track.channels
    count = counted(channels, "channel")
    if channel is None and channels > 1:
        raise SoundtrackError(f"{path}: has {count}; expected --{what}-channel N to say which, counted from 0")
    if channel is not None and channel >= channels:
        raise SoundtrackError(f"--{what}-channel {channel}: {path} has {count}, counted from 0")
    return open_soundtrack(path, mix=str(channel or 0))

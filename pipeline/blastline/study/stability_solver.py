"""Rows about the constrained drive: nothing to follow, what the filter can do as well, and far more than the limit."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..render import drive_filters
from ..render.filters import DriveFilters, Samples, compensated, felt, in_band
from ..ruleset import DEFAULT_ACTUATOR, load_actuator, load_rules
from ..units import db_from_gain
from .bars import Bar, exact
from .optimum import against_optimum
from .stability_signals import RATE_HZ, drive_of, shot_film

_ONSET, _LEAD = 14_400, 48


def solver_rows(folder: Path) -> Iterator[Bar]:
    """Yield the rows about the solver; needs no files."""
    profile, _ = load_actuator(DEFAULT_ACTUATOR)
    filters = drive_filters(profile, RATE_HZ, "causal")
    silent = drive_of(np.zeros(24_000), _ONSET, "constrained", filters)
    yield exact("zero target: samples of drive that are not 0", np.count_nonzero(silent))
    yield _weak_row(filters)
    yield _optimum_row(filters)
    for scale in (1.0, 1e3, 1e9, 1e30):
        yield from _strong_rows(shot_film(scale=scale), f"{scale:g} times", filters)
    enormous = [drive_of(shot_film(scale=scale), _ONSET, "constrained", filters) for scale in (1e20, 1e24)]
    yield Bar("target 1e20 and 1e24 times: greatest difference", float(np.max(np.abs(np.subtract(*enormous)))), 1e-6)


def _weak_row(filters: DriveFilters) -> Bar:
    """Return how far what is felt stays from a target that the actuator can follow."""
    film = shot_film(scale=0.01)
    drive = drive_of(film, _ONSET, "constrained", filters)
    whole = slice(_ONSET, _ONSET + 4_800)
    wanted = in_band(film, filters)[whole]
    error = np.linalg.norm(felt(drive, filters)[whole] - wanted) / np.linalg.norm(wanted)
    return Bar("target well inside the limit: error of what is felt", db_from_gain(float(error)), -40.0, "dB")


def _optimum_row(filters: DriveFilters) -> Bar:
    """Return by how much the solver leaves more of a shot than scipy's slow least squares in a box, drives at 6 kHz."""
    film, part = shot_film(), slice(_ONSET - _LEAD, _ONSET + 1_200)
    found = against_optimum(
        in_band(film, filters)[part],
        compensated(film, filters)[part],
        scene="study",
        onset_s=_ONSET / RATE_HZ,
        filters=filters,
        rules=load_rules("standard").tier.render,
        stride=8,
    )
    return Bar("objective against the optimum by scipy", 100.0 * found.excess, 0.1, "%")


def _strong_rows(film: Samples, name: str, filters: DriveFilters) -> Iterator[Bar]:
    """Yield what a drive at the limit does: stays in it, keeps to its lead, gains on the compensator clipped.

    The larger the target, the more the best drive is the one whose felt vibration has the largest product with it.
    """
    drive = drive_of(film, _ONSET, "constrained", filters)
    yield Bar(f"target {name}: peak", float(np.max(np.abs(drive))), 1.0, "of the limit")
    yield exact(f"target {name}: not 0 before the lead", np.count_nonzero(drive[: _ONSET - _LEAD]))
    target = in_band(film, filters)
    target = target / np.max(np.abs(target))
    clipped = np.clip(compensated(film, filters), -1.0, 1.0)
    clipped[drive == 0.0] = 0.0
    one, other = (float(np.sum(felt(samples, filters) * target)) for samples in (drive, clipped))
    yield Bar(f"target {name}: product with what is felt, against clipped", one / other, 1.0, "", "above")

"""The checks of one shot's drive: each figure beside its limit."""

from collections.abc import Iterator

import msgspec

from ..model import Check, Event
from ..units import db_from_gain, ms_from_samples
from .comparison import Comparison
from .feeling import peak_in
from .found import likeness_limit, reach
from .hearing import Part, coarseness, is_direct, is_solved
from .shots import ShotFigures
from .sounds import TimeMap

_STEP = 2.0**-15

_EXACT_SHARE, _BENT_SHARE = 0.4, 1.25
"""So much of what the actuator's limit bends a lag by, a right drive may be found beside the lag intended: where it is
known to a sample, and where it is not. In 15381 shots rendered in every way 0.2 was the most, in draft at 192 kHz
and in windows cut short by hand, and 1.05, on a seat that rings; a direct drive was found to 0.14 samples."""


def shot_checks(shared: Comparison, event: Event, figures: ShotFigures | None, lag: float | None) -> Iterator[Check]:
    """Yield the checks of a shot's drive; a `direct` one is compared as it is, any other as it is felt.

    A shot that is not found in the drive has no lag, and fails by that.
    """
    rules = shared.rules
    subject = "drive" if is_direct(event) else "felt"
    late_ms = None if lag is None or figures is None else ms_from_samples(lag + figures.delay, shared.rate_hz)
    allowed_ms = _allowed_lag_ms(shared, event, figures, late_ms)
    yield Check(f"{subject}_lag", event.id, within(late_ms, allowed_ms), late_ms, allowed_ms, "ms")
    likeness, wanted = figures.likeness if figures else 0.0, likeness_limit(shared, event)
    yield Check(f"{subject}_correlation", event.id, likeness >= wanted, likeness, wanted, "ratio")
    if figures is None:
        return
    if event.drive is not None:
        yield _own_lag_check(shared, event, figures, lag)
        yield _drive_check(shared, event, figures)
        yield from _above_band_check(shared, event, figures)
    yield _onset_check(shared, event, figures, lag)
    yield from _level_check(shared, event, figures)
    allowed_db = max(rules.preecho_db, figures.pre_echo.due_db + rules.preecho_margin_db)
    early_db = figures.pre_echo.level_db
    still = early_db is None or early_db <= allowed_db
    yield Check("pre_echo", event.id, still, early_db, allowed_db, "dB of its peak")
    yield Check("peak", event.id, figures.peak <= rules.peak, figures.peak, rules.peak, "of the limit")


def _spare_ms(shared: Comparison, event: Event, figures: ShotFigures) -> float:
    """Return how far from the lag that is intended a right drive may be found."""
    if is_direct(event) and figures.uncertainty == 0.0:
        return ms_from_samples(shared.rules.lag_zero_samples, shared.rate_hz)
    if figures.uncertainty > shared.rules.lag_zero_samples * coarseness(shared, event):
        return max(ms_from_samples(reach(shared), shared.rate_hz), _BENT_SHARE * shared.bend_ms)
    one_sample_ms = ms_from_samples(shared.rules.lag_zero_samples * coarseness(shared, event), shared.rate_hz)
    return max(one_sample_ms, _EXACT_SHARE * shared.bend_ms)


def _allowed_lag_ms(shared: Comparison, event: Event, figures: ShotFigures | None, late_ms: float | None) -> float:
    """Return by how much a shot may lag or lead: as the rules have it, or where its band moves it by more, by as much.

    A low-pass delays, and a high-pass brings what is close above its corner forward: 1.5 ms at 20 Hz, over 5 Hz. A
    drive is as late as it is meant to be within what it may be found aside; so far it may be without delay, too.
    """
    exact_ms = ms_from_samples(shared.rules.lag_zero_samples * coarseness(shared, event), shared.rate_hz)
    allowed_ms = exact_ms if shared.phase == "zero" else shared.rules.lag_causal_ms
    if figures is not None:
        spare_ms = _spare_ms(shared, event, figures)
        delay_ms = ms_from_samples(figures.delay, shared.rate_hz)
        if late_ms is not None and abs(late_ms - delay_ms) <= spare_ms:
            allowed_ms = max(allowed_ms, abs(delay_ms) + spare_ms)
        allowed_ms = max(allowed_ms, spare_ms)
    return allowed_ms if can_lead(shared, event) else max(allowed_ms, shared.lead_ms)


def _own_lag_check(shared: Comparison, event: Event, figures: ShotFigures, lag: float | None) -> Check:
    """Return the check of how far a shot's lag is from the one intended; one that is not found fails by its lag."""
    aside_ms = None if lag is None else ms_from_samples(lag, shared.rate_hz)
    spare_ms = _spare_ms(shared, event, figures)
    allowed_ms = spare_ms if can_lead(shared, event) else max(spare_ms, shared.lead_ms)
    return Check(
        "lag_as_rendered", event.id, aside_ms is None or within(aside_ms, allowed_ms), aside_ms, allowed_ms, "ms"
    )


def can_lead(shared: Comparison, event: Event) -> bool:
    """Return whether the film has room for the lead before a shot: without it, a solved drive comes late."""
    return not is_solved(event) or event.onset_sample >= shared.samples(shared.lead_ms)


def noted(
    shared: Comparison, event: Event, part: Part, figures: ShotFigures | None, lag: float | None
) -> Iterator[Check]:
    """Yield the same checks of a shot that cannot be compared, without holding it to them.

    But for what needs no attack to tell: the actuator's limit, what is due of its drive in its place, and its peak. Of
    a shot that is over when the drive of the next begins, none of that peak is its own.
    """
    has_own_peak = len(part.span) > 1 or part.driven.stop == event.window.stop
    held = ["peak", "drive_as_rendered", *(["peak_as_rendered"] if has_own_peak else [])]
    for check in shot_checks(shared, event, figures, lag):
        measured = check.measured if figures else None
        free = msgspec.structs.replace(check, passed=True, measured=measured, limit=None)
        yield check if check.name in held else free
    if figures is None and has_own_peak:
        yield from _own_peak_check(shared, event, peak_in(shared, part.driven, time_map=TimeMap()))


def _onset_check(shared: Comparison, event: Event, figures: ShotFigures, lag: float | None) -> Check:
    """Return the check of the attack; one of which nothing can be told passes, with nothing measured."""
    late, allowed_ms = figures.late_start, max(shared.rules.onset_error_ms, shared.bend_ms)
    error_ms = None if late is None else ms_from_samples(late + (lag or 0.0), shared.rate_hz)
    in_time = error_ms is None or -shared.lead_ms - allowed_ms <= error_ms <= allowed_ms
    name = "drive_onset" if is_direct(event) else "felt_onset"
    return Check(name, event.id, in_time, error_ms, allowed_ms, "ms")


def _drive_check(shared: Comparison, event: Event, figures: ShotFigures) -> Check:
    """Return the check of whether the drive is what is due to its end; one too short to tell passes."""
    limit = shared.rules.departure_solved if is_solved(event) else shared.rules.departure
    apart = figures.departure
    return Check("drive_as_rendered", event.id, apart is None or apart <= limit, apart, limit, "of what is due")


def _above_band_check(shared: Comparison, event: Event, figures: ShotFigures) -> Iterator[Check]:
    """Yield the check of what a solved drive has above the band; any other is compared with what is due there, too."""
    if is_solved(event):
        limit, added = shared.rules.above_band, figures.above_band
        still = added is None or added <= limit
        yield Check("drive_above_band", event.id, still, added, limit, "of the compensator's")


def _level_check(shared: Comparison, event: Event, figures: ShotFigures) -> Iterator[Check]:
    if event.drive is None:
        return
    rules = shared.rules
    error_db = figures.level_db - event.drive.perceived_gain_db
    yield Check(
        "level_as_rendered", event.id, abs(error_db) <= rules.level_error_db, error_db, rules.level_error_db, "dB"
    )
    yield from _own_peak_check(shared, event, figures.own_peak)


def _own_peak_check(shared: Comparison, event: Event, own_peak: float) -> Iterator[Check]:
    """Yield the check of the peak: what is clipped keeps most of its level; a step of 16 bits is no difference."""
    if event.drive is not None:
        error_db, limit_db = db_from_gain((own_peak + _STEP) / (event.drive.peak + _STEP)), shared.rules.peak_error_db
        yield Check("peak_as_rendered", event.id, abs(error_db) <= limit_db, error_db, limit_db, "dB")


def within(figure: float | None, limit: float) -> bool:
    """Return whether a figure is known and within its limit either way."""
    return figure is not None and abs(figure) <= limit

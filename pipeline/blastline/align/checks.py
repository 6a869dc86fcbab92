"""The checks themselves: each figure beside its limit."""

import math
from collections.abc import Iterator, Sequence

import msgspec

from ..model import Background, Check, Event, Phase, RandomAccessSound, SoundFile, Span, Timeline
from ..ruleset import ActuatorProfile, AlignRules
from ..units import db_from_gain, ms_from_samples, samples_from_ms
from .comparable import is_comparable
from .comparison import Comparison, compare
from .hearing import is_direct, is_solved
from .sanity import fade_margin, heard_rise_db, is_rise_owed, order_faults
from .shots import ShotFigures, likeness_limit, parts_of
from .sounds import Sound, read_padded
from .timing import Timing, time_film
from .whole_drive import DriveFigures, fades_of, gaps, scan

_STEP = 2.0**-15


def check_files(
    timeline: Timeline,
    *,
    audio: RandomAccessSound,
    drive: SoundFile,
    profile: ActuatorProfile,
    rules: AlignRules,
    lead_ms: float,
    corner_ms: float,
    phase: Phase,
    background: Background,
) -> tuple[Check, ...]:
    """Return the checks of a drive as it was written, first of the film, then of each shot in order.

    `audio` has been decoded and has the timeline's number of frames; `drive` is decoded here, once. A drive may begin
    `lead_ms` before its shot's onset, and a solved one is made of straight lines between corners `corner_ms` apart.
    Figures are None where there is nothing to measure: a drive in which no shot is found has failed, a film without
    shots has not.
    """
    heard = Sound(audio, timeline.source.frames)
    film = _scan(timeline, heard, drive, background)
    shared = compare(
        heard,
        Sound(drive, film.frames),
        profile=profile,
        rules=rules,
        lead_ms=lead_ms,
        phase=phase,
        background=background,
        level_db=timeline.level_db,
        corner_ms=corner_ms,
    )
    checks = [*_file_checks(timeline, shared, film, drive.damaged_samples), *_order_check(timeline)]
    if not timeline.events:
        return (*checks, *_timing_checks(shared, (), None))
    parts = parts_of(timeline.events, lead=shared.samples(shared.lead_ms))
    comparable = [is_comparable(shared, event, part) for event, part in zip(timeline.events, parts, strict=True)]
    placing = [each and _can_lead(shared, event) for event, each in zip(timeline.events, comparable, strict=True)]
    timing = time_film(shared, timeline.events, parts, placing)
    checks += _timing_checks(shared, [e for e, places in zip(timeline.events, placing, strict=True) if places], timing)
    for event, compared, figures, lag in zip(timeline.events, comparable, timing.figures, timing.lags, strict=True):
        checks += _window_checks(event, shared.rate_hz)
        checks += _shot_checks(shared, event, figures, lag) if compared else _noted(shared, event, figures, lag)
    return tuple(checks)


def check_timeline(timeline: Timeline, *, audio: RandomAccessSound, rules: AlignRules) -> tuple[Check, ...]:
    """Return the checks of a timeline without a drive: of its order, its windows, and its onsets in the sound.

    A rise that a right shot need not have is listed without a limit.
    """
    heard = Sound(audio, timeline.source.frames)
    checks = list(_order_check(timeline))
    for before, event in zip((None, *timeline.events), timeline.events, strict=False):
        checks += _window_checks(event, heard.rate_hz)
        rise_db = heard_rise_db(event, heard)
        limit_db = rules.rise_db if is_rise_owed(event, before, heard.rate_hz) else None
        rises = limit_db is None or rise_db is None or rise_db >= limit_db
        checks.append(Check("audio_rise", event.id, rises, rise_db, limit_db, "dB"))
    return tuple(checks)


def _scan(timeline: Timeline, audio: Sound, drive: SoundFile, background: Background) -> DriveFigures:
    """Read the whole drive; at another rate than the timeline's, what lies outside windows is only roughly known."""
    ratio = drive.rate_hz / timeline.source.sample_rate_hz
    spare = 0 if ratio == 1.0 else samples_from_ms(5.0, drive.rate_hz)
    windows = [_scaled(event, ratio, spare) for event in timeline.events]
    still = gaps(windows, round(timeline.source.frames * ratio))
    fades = fades_of(event.window for event in timeline.events) if ratio == 1.0 else []
    if background == "direct" and ratio == 1.0:
        return scan(drive.blocks(), still, expected=lambda span: read_padded(audio, span), fades=fades)
    return scan(drive.blocks(), still if background == "mute" else [], expected=None, fades=fades)


def _scaled(event: Event, ratio: float, spare: int) -> Span:
    window = event.window
    return Span(max(0, math.floor(window.start * ratio) - spare), math.ceil(window.stop * ratio) + spare)


def _file_checks(timeline: Timeline, shared: Comparison, film: DriveFigures, damaged: int) -> Iterator[Check]:
    rate_hz, drive_rate_hz = timeline.source.sample_rate_hz, shared.drive.rate_hz
    same_rate = drive_rate_hz == rate_hz
    yield Check("sample_rate", None, same_rate, drive_rate_hz, rate_hz, "Hz")
    excess = film.frames - round(timeline.source.frames * drive_rate_hz / rate_hz)
    yield Check("frames", None, excess == 0, excess, 0.0, "frames")
    yield Check("drive_samples", None, damaged == 0, damaged, 0.0, "samples")
    yield Check("drive_peak", None, film.peak <= shared.rules.peak, film.peak, shared.rules.peak, "of the limit")
    if shared.background == "mute":
        yield Check("silence_outside_windows", None, film.stray == 0, film.stray, 0.0, "samples")
    else:
        stray = film.stray if same_rate else None
        yield Check("sound_outside_windows", None, stray == 0, stray, 0.0, "samples")
    if timeline.events:
        yield Check("fades", None, film.unfaded == 0, film.unfaded if same_rate else None, 0.0, "samples")


def _order_check(timeline: Timeline) -> Iterator[Check]:
    faults = order_faults(timeline.events, timeline.source.frames)
    yield Check("timeline_order", None, faults == 0, faults, 0.0, "faults")


def _timing_checks(shared: Comparison, events: Sequence[Event], timing: Timing | None) -> Iterator[Check]:
    """Yield displacement, drift and speed of the drive as a whole, by comparable shots; drift and speed need two.

    Where the actuator's limit bends the lags of most shots, no more than that is held against the drive.
    """
    rules = shared.rules
    if timing is None or not events:
        yield Check("drive_shift", None, True, None, rules.shift_samples, "samples")
        return
    bend = 0.0 if timing.exact else shared.bend
    shift_limit = max(rules.shift_samples * shared.coarseness, bend)
    drift_limit = max(rules.drift_samples * shared.coarseness, 2.0 * bend)
    time_map, first, last = timing.time_map, events[0].onset_sample, events[-1].onset_sample
    drift = time_map.lag(last) - time_map.lag(first) if time_map else None
    steady = _within(drift, drift_limit)
    shift = time_map.lag((first + last) / 2 if steady else first) if time_map else None
    yield Check("drive_shift", None, _within(shift, shift_limit), shift, shift_limit, "samples")
    if last > first:
        yield Check("drive_drift", None, steady, drift, drift_limit, "samples")
        speed = 1.0 / time_map.scale if time_map else None
        yield Check("drive_speed", None, steady, speed, 1.0 + drift_limit / (last - first), "ratio")


def _window_checks(event: Event, rate_hz: int) -> Iterator[Check]:
    margin_ms = ms_from_samples(fade_margin(event), rate_hz)
    inside = event.onset_sample in event.window.span
    yield Check("fade_in_before_onset", event.id, inside and margin_ms >= 0.0, margin_ms, 0.0, "ms")


def _shot_checks(shared: Comparison, event: Event, figures: ShotFigures | None, lag: float | None) -> Iterator[Check]:
    """Yield the checks of a shot's drive; a `direct` one is compared as it is, any other as it is felt.

    A shot that is not found in the drive has no lag, and fails by that.
    """
    rules = shared.rules
    subject = "drive" if is_direct(event) else "felt"
    late_ms = None if lag is None or figures is None else ms_from_samples(lag + figures.delay, shared.rate_hz)
    allowed_ms = _allowed_lag_ms(shared, event, figures, late_ms)
    yield Check(f"{subject}_lag", event.id, _within(late_ms, allowed_ms), late_ms, allowed_ms, "ms")
    likeness, wanted = figures.match.correlation if figures else 0.0, likeness_limit(shared, event)
    yield Check(f"{subject}_correlation", event.id, likeness >= wanted, likeness, wanted, "ratio")
    if figures is None:
        return
    yield _onset_check(shared, event, figures, lag)
    yield from _level_check(shared, event, figures)
    allowed_db = max(rules.preecho_db, figures.pre_echo.due_db + rules.preecho_margin_db)
    early_db = figures.pre_echo.level_db
    still = early_db is None or early_db <= allowed_db
    yield Check("pre_echo", event.id, still, early_db, allowed_db, "dB of its peak")
    yield Check("peak", event.id, figures.peak <= rules.peak, figures.peak, rules.peak, "of the limit")


def _allowed_lag_ms(shared: Comparison, event: Event, figures: ShotFigures | None, late_ms: float | None) -> float:
    """Return by how much a shot may lag: as the rules have it, or where its band delays it by more, by as much.

    A drive is as late as it is meant to be within what the actuator's limit may bend; a lag in which that has no part,
    within what any has to without delay.
    """
    rules, exact_ms = shared.rules, ms_from_samples(shared.rules.lag_zero_samples * shared.coarseness, shared.rate_hz)
    allowed_ms = exact_ms if shared.phase == "zero" else rules.lag_causal_ms
    if figures is not None:
        spare_ms = exact_ms if figures.exact else shared.bend_ms
        delay_ms = ms_from_samples(figures.delay, shared.rate_hz)
        if late_ms is not None and delay_ms > 0.0 and abs(late_ms - delay_ms) <= spare_ms:
            allowed_ms = max(allowed_ms, delay_ms + spare_ms)
        if not figures.exact:
            allowed_ms = max(allowed_ms, shared.bend_ms)  # so much the actuator's limit alone may bend a lag of nothing
    return allowed_ms if _can_lead(shared, event) else max(allowed_ms, shared.lead_ms)


def _can_lead(shared: Comparison, event: Event) -> bool:
    """Return whether the film has room for the lead before a shot: without it, a solved drive comes late."""
    return not is_solved(event) or event.onset_sample >= shared.samples(shared.lead_ms)


def _noted(shared: Comparison, event: Event, figures: ShotFigures | None, lag: float | None) -> Iterator[Check]:
    """Yield the same checks of a shot that cannot be compared, without holding it to them.

    But for the actuator's limit: that holds for every drive.
    """
    for check in _shot_checks(shared, event, figures, lag):
        noted = check.measured if figures else None
        yield check if check.name == "peak" else msgspec.structs.replace(check, passed=True, measured=noted, limit=None)


def _onset_check(shared: Comparison, event: Event, figures: ShotFigures, lag: float | None) -> Check:
    """Return the check of the attack; one of which nothing can be told passes, with nothing measured."""
    late, allowed_ms = figures.late_start, max(shared.rules.onset_error_ms, shared.bend_ms)
    error_ms = None if late is None else ms_from_samples(late + (lag or 0.0), shared.rate_hz)
    in_time = error_ms is None or -shared.lead_ms - allowed_ms <= error_ms <= allowed_ms
    name = "drive_onset" if is_direct(event) else "felt_onset"
    return Check(name, event.id, in_time, error_ms, allowed_ms, "ms")


def _level_check(shared: Comparison, event: Event, figures: ShotFigures) -> Iterator[Check]:
    if event.drive is None:
        return
    rules = shared.rules
    error_db = figures.level_db - event.drive.perceived_gain_db
    yield Check(
        "level_as_rendered", event.id, abs(error_db) <= rules.level_error_db, error_db, rules.level_error_db, "dB"
    )
    # what is clipped keeps most of its level; a step of 16 bits is no difference
    error_db = db_from_gain((figures.own_peak + _STEP) / (event.drive.peak + _STEP))
    yield Check("peak_as_rendered", event.id, abs(error_db) <= rules.peak_error_db, error_db, rules.peak_error_db, "dB")


def _within(figure: float | None, limit: float) -> bool:
    return figure is not None and abs(figure) <= limit

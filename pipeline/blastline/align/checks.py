"""The checks themselves: each figure beside its limit."""

import math
from collections.abc import Iterator, Mapping, Sequence

from ..model import Background, Check, Event, Phase, RandomAccessSound, SoundFile, Span, Timeline
from ..ruleset import ActuatorProfile, AlignRules
from ..units import ms_from_samples, samples_from_ms
from .comparable import is_comparable
from .comparison import Comparison, compare
from .hearing import coarseness
from .sanity import changed_shots, fade_margin, heard_rise_db, is_rise_owed, order_faults, rendered_shots
from .shot_checks import can_lead, noted, shot_checks, within
from .shots import parts_of
from .sounds import Sound, read_padded
from .timing import Timing, time_film
from .whole_drive import DriveFigures, fades_of, gaps, scan

_SAME_DB = 0.001
"""Two gains that differ by less are one: they are sums."""


def check_files(
    timeline: Timeline,
    *,
    audio: RandomAccessSound,
    drive: SoundFile,
    profile: ActuatorProfile,
    rules: AlignRules,
    lead_ms: float,
    preroll_ms: float,
    corner_ms: float,
    phase: Phase,
    background: Background,
    markers: Mapping[str, int] | None = None,
) -> tuple[Check, ...]:
    """Return the checks of a drive as it was written, first of the film, then of each shot in order.

    `audio` has been decoded and has the timeline's number of frames; `drive` is decoded here, once. A drive may begin
    `lead_ms` before its shot's onset, its filters were started `preroll_ms` before its window, earlier where they are
    slow, and a solved one is made of straight lines between corners `corner_ms` apart.
    `markers` are the samples of the shots that it was rendered with, by their ids, where these are known.
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
        preroll_ms=preroll_ms,
        phase=phase,
        background=background,
        level_db=timeline.level_db,
        corner_ms=corner_ms,
    )
    return (
        *_file_checks(timeline, shared, film, drive.damaged_samples),
        *_order_check(timeline),
        *_number_check(timeline, markers),
        *_checks_by_shots(timeline, shared),
    )


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
        yield Check("sound_outside_windows", None, not stray, stray, 0.0, "samples")
    if timeline.events:
        yield Check("fades", None, film.unfaded == 0, film.unfaded if same_rate else None, 0.0, "samples")


def _order_check(timeline: Timeline) -> Iterator[Check]:
    faults = order_faults(timeline.events, timeline.source.frames)
    yield Check("timeline_order", None, faults == 0, faults, 0.0, "faults")


def _number_check(timeline: Timeline, markers: Mapping[str, int] | None) -> Iterator[Check]:
    """Yield how many shots more have a drive than were rendered, by the drive's markers and by the timeline's checks.

    Either name every shot that was rendered. Where as many were added as are lost, these are the figure; where nothing
    is left of either, there is none.
    """
    if timeline.actuator is None:
        return
    driven = sum(event.drive is not None for event in timeline.events)
    lost, added = changed_shots(timeline, markers)
    excess = driven - len(rendered_shots(timeline)) if timeline.checks else len(added) - len(lost)
    passed = not (excess or lost or added)
    is_told = markers is not None or timeline.checks
    yield Check("shots_as_rendered", None, passed, (excess or -len(lost)) if is_told else None, 0.0, "shots")


def _checks_by_shots(timeline: Timeline, shared: Comparison) -> Iterator[Check]:
    """Yield the checks of the drive's timing as a whole, which its shots tell, then those of each shot in order."""
    events = timeline.events
    if not events:
        yield from _timing_checks(shared, (), None)
        return
    parts = parts_of(events, lead=shared.samples(shared.lead_ms))
    comparable = [is_comparable(shared, event, part) for event, part in zip(events, parts, strict=True)]
    placing = [each and can_lead(shared, event) for event, each in zip(events, comparable, strict=True)]
    timing = time_film(shared, events, parts, placing)
    yield from _timing_checks(shared, [e for e, places in zip(events, placing, strict=True) if places], timing)
    measured = zip(events, parts, comparable, timing.figures, timing.lags, strict=True)
    for event, part, compared, figures, lag in measured:
        yield from _window_checks(event, shared.rate_hz)
        yield from _edit_checks(event, timeline.level_db, shared.rate_hz)
        yield from shot_checks(shared, event, figures, lag) if compared else noted(shared, event, part, figures, lag)


def _timing_checks(shared: Comparison, events: Sequence[Event], timing: Timing | None) -> Iterator[Check]:
    """Yield displacement, drift and speed of the drive as a whole, by comparable shots; drift and speed need two.

    Where the actuator's limit bends the lags of most shots, no more than that is held against the drive.
    """
    rules = shared.rules
    if timing is None or not events:
        yield Check("drive_shift", None, True, None, rules.shift_samples, "samples")
        return
    bend = 0.0 if timing.exact else shared.bend
    coarse = max(coarseness(shared, event) for event in events)
    shift_limit = max(rules.shift_samples * coarse, bend)
    drift_limit = max(rules.drift_samples * coarse, 2.0 * bend)
    time_map, first, last = timing.time_map, events[0].onset_sample, events[-1].onset_sample
    drift = time_map.lag(last) - time_map.lag(first) if time_map else None
    steady = within(drift, drift_limit)
    shift = time_map.lag((first + last) / 2 if steady else first) if time_map else None
    yield Check("drive_shift", None, within(shift, shift_limit), shift, shift_limit, "samples")
    if last > first:
        yield Check("drive_drift", None, steady, drift, drift_limit, "samples")
        speed = 1.0 / time_map.scale if time_map else None
        yield Check("drive_speed", None, steady, speed, 1.0 + drift_limit / (last - first), "ratio")


def _window_checks(event: Event, rate_hz: int) -> Iterator[Check]:
    margin_ms = ms_from_samples(fade_margin(event), rate_hz)
    inside = event.onset_sample in event.window.span
    yield Check("fade_in_before_onset", event.id, inside and margin_ms >= 0.0, margin_ms, 0.0, "ms")


def _edit_checks(event: Event, level_db: float, rate_hz: int) -> Iterator[Check]:
    """Yield the checks of what may be edited in a timeline and has to be rendered again: the onset, gain and level.

    The blast, which begins at the onset, and what the drive was made with are as the last rendering left them.
    """
    moved_ms = ms_from_samples(event.onset_sample - event.blast.start, rate_hz)
    yield Check("onset_as_rendered", event.id, moved_ms == 0.0, moved_ms, 0.0, "ms")
    if event.drive is not None:
        aside_db = event.drive.raised_db - (event.gain_db + level_db)
        yield Check("gain_as_rendered", event.id, abs(aside_db) <= _SAME_DB, aside_db, _SAME_DB, "dB")

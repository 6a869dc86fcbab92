"""The figures of one shot: what is felt against what is heard, wherever the drive has put it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import dsp
from ..correlate import Match, lag_of_product, match_template
from ..model import Event, Span
from ..units import db_from_gain
from .above import added_above_band
from .attack import PreEcho, late_start, pre_echo
from .comparison import Comparison, Samples
from .due import Adjoints, adjoints_of, borne_out, departure, possible_drives, unsolved_drive
from .hearing import Felt, Heard, Part, feel, hear, is_direct, peak_in
from .sounds import TimeMap

_EXACT = 0.999
"""Where the drive is free of its limit, a right one follows the sound at least this well, and tells its lag exactly.

What `standard` renders does by 0.9999; in `draft` 0.998 was seen with lags of 0.7 samples."""

_LEAST_MS = 5.0
"""So much of a shot tells its lag to half a sample; 2 ms, before a film's end, were up to 1.9 samples off."""


@dataclass(frozen=True)
class ShotFigures:
    """What was measured of a shot: lags in samples, levels in decibels.

    `peak` is the largest of all that was compared, `own_peak` of the drive that is the shot's own.
    `match` is against the sound with the delay that the drive is meant to have; `delay` is that delay. `exact` says
    that the actuator's limit has no part in the lag. `departure` is by which share of it the drive is not what is due,
    in its worst stretch, None where it is too short or had to be interpolated; `above_band` what it has above
    the band beside the compensator's, as a share of that, None likewise. The others are measured where the match
    is, or in the shot's own place where the match is too poor to be believed.
    """

    match: Match
    exact: bool
    delay: float
    peak: float
    own_peak: float
    late_start: float | None
    level_db: float
    pre_echo: PreEcho
    departure: float | None
    above_band: float | None


@dataclass(frozen=True, eq=False)
class _DriveRead:
    """The drive as read from one place of its file: what is felt of it, and what its limit leaves open."""

    felt: Felt
    adjoints: Adjoints


@dataclass(frozen=True, eq=False)
class _Located:
    """Where a shot's drive is, whether the actuator's limit has no part in that, and the drive read from there."""

    match: Match
    exact: bool
    drive: _DriveRead


def parts_of(events: Sequence[Event], *, lead: int) -> tuple[Part, ...]:
    """Return for each shot what lies between its onset and its window's fade-out or `lead` before the next onset.

    window   |------------------------|
    onsets     ^         ^
    parts      [-------) [---------)
    """
    parts = []
    for before, event, after in zip([None, *events[:-1]], events, [*events[1:], None], strict=True):
        stop = whole = max(event.window.stop - event.window.fade_out_samples, event.onset_sample + 1)
        if after is not None and after.onset_sample > event.onset_sample:
            stop = min(whole, max(after.onset_sample - lead, event.onset_sample + 1))
        opens = before is None or before.window != event.window
        since = event.window.start if before is None or opens else before.onset_sample - lead
        before_db = 0.0 if before is None or opens else before.gain_db - event.gain_db
        after_db = after.gain_db - event.gain_db if after is not None and stop < whole else 0.0
        begins = event.window.start if opens else max(event.window.start, event.onset_sample - lead)
        driven = Span(begins, max(begins + 1, stop if stop < whole else event.window.stop))
        parts.append(Part(Span(event.onset_sample, stop), opens, stop < whole, since, driven, before_db, after_db))
    return tuple(parts)


def likeness_limit(shared: Comparison, event: Event) -> float:
    """Return the correlation that a shot's drive has to reach: nearly what was predicted when it was rendered.

    A direct drive, and one of which nothing was predicted, is to follow the sound as it is.
    """
    rules = shared.rules
    if event.drive is None or is_direct(event):
        return rules.correlation
    return max(rules.least_correlation, event.drive.fidelity - rules.correlation_loss)


def measure(shared: Comparison, event: Event, part: Part, *, time_map: TimeMap) -> ShotFigures | None:
    """Return a shot's figures, with the drive read from where `time_map` says and searched for around there.

    None where soundtrack or drive are silent.
    """
    search = shared.samples(shared.rules.search_ms)
    heard = hear(shared, event, part, margin=max(search, shared.memory, shared.samples(shared.lead_ms)))
    core = heard.core
    pattern = slice(core.start, min(core.stop, core.start + shared.samples(shared.rules.longest_ms)))
    felt = feel(shared, event, heard.span, time_map=time_map)
    match = _match(shared, event, heard, felt, pattern)
    if math.isnan(match.lag):
        return None
    found = _refined(shared, event, part, heard, felt, pattern=pattern, match=match, time_map=time_map)
    felt = found.drive.felt
    possible = possible_drives(shared, heard, felt, found.drive.adjoints)
    due = borne_out(shared, heard, felt, possible)
    as_written = time_map.is_whole and shared.drive.rate_hz == shared.rate_hz
    return ShotFigures(
        found.match,
        exact=found.exact,
        delay=0.0 if shared.phase == "zero" or is_direct(event) else _delay(shared, heard.undelayed[pattern], search),
        peak=felt.peak,
        own_peak=peak_in(shared, part.driven, time_map=time_map),
        late_start=late_start(shared, heard, felt, due),
        level_db=db_from_gain(_rms(felt.own[core])) - db_from_gain(_rms(heard.direct[core])),
        pre_echo=pre_echo(shared, event, part, heard, felt, due),
        departure=departure(shared, heard, felt, possible) if as_written else None,
        above_band=added_above_band(shared, heard, felt) if as_written else None,
    )


def locate(shared: Comparison, event: Event, part: Part, *, time_map: TimeMap, search: int) -> Match:
    """Return where the drive holds a shot, within `search` samples of where `time_map` says."""
    start, longest = part.span.start, shared.samples(shared.rules.longest_ms)
    short = replace(part, span=Span(start, min(part.span.stop, start + longest)))
    heard = hear(shared, event, short, margin=0)
    felt = feel(shared, event, Span(start - search, short.span.stop + search), time_map=time_map)
    return match_template(heard.expected, felt.following)


def _match(shared: Comparison, event: Event, heard: Heard, felt: Felt, pattern: slice) -> Match:
    """Return where the drive is most like the sound; its own place, if it is due or as like there as was predicted."""

    def within(aside: int) -> Match:
        return match_template(heard.expected[pattern], felt.following[pattern.start - aside : pattern.stop + aside])

    if event.drive is not None and not is_direct(event):
        own = within(reach(shared))
        if own.correlation >= event.drive.fidelity - shared.rules.fidelity_error or _is_due(shared, heard, felt):
            return own
    return within(shared.samples(shared.rules.search_ms))


def _is_due(shared: Comparison, heard: Heard, felt: Felt) -> bool:
    """Return whether a drive without a solver is, sample for sample, what is due where it was read.

    So it is there, however little a seat that rings lets what is felt be like the sound.
    """
    apart = None if heard.solved else departure(shared, heard, felt, (unsolved_drive(shared, heard, felt),))
    return apart is not None and apart <= shared.rules.departure


def reach(shared: Comparison) -> int:
    """Return within how many samples of its place the actuator's limit alone leaves a shot."""
    return max(4, shared.samples(shared.bend_ms))


def _refined(
    shared: Comparison,
    event: Event,
    part: Part,
    heard: Heard,
    here: Felt,
    *,
    pattern: slice,
    match: Match,
    time_map: TimeMap,
) -> _Located:
    """Return the match made exact where that can be, and the drive read anew from there, `here` where that is the same.

    Where the match is too poor to be believed, or where the limit alone may have bent it aside, the drive is read from
    the shot's own place.
    """

    def read(late: int) -> _DriveRead:
        there = TimeMap(time_map.scale, time_map.offset + late * time_map.scale)
        felt = feel(shared, event, heard.span, time_map=there) if late else here
        return _DriveRead(felt, adjoints_of(shared, heard, felt))

    believed = abs(match.correlation) >= likeness_limit(shared, event)
    late = round(match.lag) if believed else 0
    drive = read(late)
    exact = is_direct(event) and bool(drive.felt.free[pattern].all())
    if not is_direct(event):
        asked = part.followed or event.window.fade_out_samples < shared.memory
        stop = min(pattern.stop, heard.core.stop - (shared.memory if asked else 0))
        bend = _bend(shared, drive, slice(pattern.start, stop))
        if bend is not None:
            match, exact = Match(late + bend, match.correlation), True
    settled = round(match.lag) if believed and (exact or abs(match.lag) > shared.samples(shared.bend_ms)) else 0
    if settled != late:
        drive = read(settled)
    return _Located(match, exact, drive)


def _bend(shared: Comparison, drive: _DriveRead, pattern: slice) -> float | None:
    """Return the lag that the actuator's limit cannot bend; None where the limit leaves too little.

    A drive u that makes |H u - t| least within its limit has, wherever it is free of it, no slope left to descend:
    H'(H u - t) = 0. So H'H u and H't are one and the same at these samples, and only at the right lag. The pattern
    ends before H is asked for what the drive does not know or do: the next shot, and what follows the film's end.
    """
    within = reach(shared)
    if pattern.stop - pattern.start < shared.samples(_LEAST_MS):
        return None
    around = slice(pattern.start - within, pattern.stop + within)
    where_free = match_template(drive.adjoints.intended[pattern], drive.adjoints.felt[around], drive.felt.free[around])
    return where_free.lag if where_free.correlation >= _EXACT and abs(where_free.lag) < within else None


def _delay(shared: Comparison, undelayed: Samples, search: int) -> float:
    """Return by how many samples a sound is later, or earlier, with the delay that the drive is meant to have.

    A boom that dies away is like itself a period later, and so is as like it there as in its own place: not the best
    likeness tells the delay, but the greatest product.
    """
    delayed = dsp.run_filter(shared.band, np.concatenate([undelayed, np.zeros(search)]))
    return lag_of_product(undelayed, np.concatenate([np.zeros(search), delayed]))


def _rms(samples: Samples) -> float:
    return math.sqrt(float(np.mean(samples**2))) if len(samples) else 0.0

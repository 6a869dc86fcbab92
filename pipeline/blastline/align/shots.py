"""The figures of one shot: what is felt against what is heard, wherever the drive has put it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import dsp
from ..correlate import Match, lag_of_product
from ..model import Event, Span, Window
from ..units import db_from_gain
from .above import added_above_band
from .attack import PreEcho, late_start, pre_echo
from .comparison import Comparison, Samples
from .due import borne_out, departure, possible_drives, upright
from .feeling import peak_in
from .found import find_shot, likeness_to_sound
from .hearing import Part, hear, is_direct
from .sounds import TimeMap

_EARLIEST_MS = 10_000.0
"""So long before its onset a window is looked at that opens earlier, which takes memory."""


@dataclass(frozen=True)
class ShotFigures:
    """What was measured of a shot: lags in samples, levels in decibels.

    `peak` is the largest of all that was compared, `own_peak` of the drive that is the shot's own.
    `match` and `uncertainty` are those of `FoundShot`, `likeness` is to the sound; `delay` is the delay that the drive
    is meant to have. `departure` is by which share of it the drive is not what is due, in its worst stretch, None where
    it is too short or had to be interpolated; `above_band` what it has above the band beside the compensator's, None
    likewise. The others are measured where the match is, or in the shot's own place where the match is too poor to be
    believed.
    """

    match: Match
    uncertainty: float
    likeness: float
    delay: float
    peak: float
    own_peak: float
    late_start: float | None
    level_db: float
    pre_echo: PreEcho
    departure: float | None
    above_band: float | None


def parts_of(events: Sequence[Event], *, lead: int) -> tuple[Part, ...]:
    """Return for each shot what lies between its onset and its window's fade-out or `lead` before the next onset.

    window   |------------------------|
    onsets     ^         ^
    parts      [-------) [---------)
    """
    parts, earlier_stop, gains = [], 0, _gains_of(events)
    for before, event, after in zip([None, *events[:-1]], events, [*events[1:], None], strict=True):
        stop = whole = max(event.window.stop - event.window.fade_out_samples, event.onset_sample + 1)
        if after is not None and after.onset_sample > event.onset_sample:
            stop = min(whole, max(after.onset_sample - lead, event.onset_sample + 1))
        opens = before is None or before.window != event.window
        if before is not None and opens:
            earlier_stop = min(before.window.stop, event.window.start)
        since = event.window.start if before is None or opens else before.onset_sample - lead
        before_db = 0.0 if before is None or opens else before.gain_db - event.gain_db
        begins = event.window.start if opens else max(event.window.start, event.onset_sample - lead)
        driven = Span(begins, max(begins + 1, stop if stop < whole else event.window.stop))
        of_window = gains.get(event.window, ())
        parts.append(Part(Span(event.onset_sample, stop), opens, since, driven, before_db, of_window, earlier_stop))
    return tuple(parts)


def _gains_of(events: Sequence[Event]) -> dict[Window, tuple[tuple[int, float], ...]]:
    """Return the onsets and gains of the shots of each window in which not all are asked to be as strong, in order."""
    by_window: dict[Window, list[tuple[int, float]]] = {}
    for event in events:
        by_window.setdefault(event.window, []).append((event.onset_sample, event.gain_db))
    return {window: tuple(sorted(gains)) for window, gains in by_window.items() if len({gain for _, gain in gains}) > 1}


def measure(shared: Comparison, event: Event, part: Part, *, time_map: TimeMap, in_place: bool) -> ShotFigures | None:
    """Return a shot's figures, with the drive read from where `time_map` says and searched for around there.

    `in_place` it is read nowhere else, wherever it seems to be. None where the soundtrack is silent.
    """
    search = shared.samples(shared.rules.search_ms)
    margin = max(search, shared.memory, shared.samples(shared.lead_ms))
    since = min(part.span.start, part.driven.start, part.since)  # how a shot before was solved tells what follows it
    opened = max(since, part.span.start - shared.samples(_EARLIEST_MS))
    around = Span(opened - margin, max(part.span.stop, part.driven.stop) + margin)
    heard = hear(shared, event, part, around)
    core = heard.core
    pattern = slice(core.start, min(core.stop, core.start + shared.samples(shared.rules.longest_ms)))
    found = find_shot(shared, event, part, heard, pattern=pattern, time_map=time_map, in_place=in_place)
    if found is None:
        return None
    felt = found.felt
    possible = possible_drives(shared, heard, felt, found.adjoints)
    due = borne_out(shared, heard, felt, possible)
    as_written = time_map.is_whole and shared.drive.rate_hz == shared.rate_hz
    return ShotFigures(
        found.match,
        uncertainty=found.uncertainty,
        likeness=likeness_to_sound(shared, event, heard, found, pattern),
        delay=0.0 if shared.phase == "zero" or is_direct(event) else _delay(shared, heard.undelayed[pattern], search),
        peak=felt.peak,
        own_peak=peak_in(shared, part.driven, time_map=time_map),
        late_start=late_start(shared, heard, felt, due),
        level_db=db_from_gain(_rms(felt.own[core])) - db_from_gain(_rms(heard.direct[core])),
        pre_echo=pre_echo(shared, event, part, heard, felt, due),
        departure=departure(shared, heard, felt, upright(heard, possible)) if as_written else None,
        above_band=added_above_band(shared, heard, felt) if as_written else None,
    )


def _delay(shared: Comparison, undelayed: Samples, search: int) -> float:
    """Return by how many samples a sound is later, or earlier, with the delay that the drive is meant to have.

    A boom that dies away is like itself a period later, and so is as like it there as in its own place: not the best
    likeness tells the delay, but the greatest product.
    """
    delayed = dsp.run_filter(shared.band, np.concatenate([undelayed, np.zeros(search)]))
    return lag_of_product(undelayed, np.concatenate([np.zeros(search), delayed]))


def _rms(samples: Samples) -> float:
    return math.sqrt(float(np.mean(samples**2))) if len(samples) else 0.0

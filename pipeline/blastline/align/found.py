"""Where the drive holds a shot: by what its limit cannot bend, or else by where it is felt most like the sound."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from ..correlate import Match, lag_uncertainty, match_template, normalised_product
from ..model import Event, Span
from .comparison import Comparison
from .due import Adjoints, adjoints_of, away_from_due, departure, unsolved_drive
from .feeling import Felt, feel
from .hearing import Heard, Part, coarseness, hear, is_direct
from .sounds import TimeMap

_LEAST_MS = 5.0
"""So much of a shot tells its lag to half a sample; 2 ms, before a film's end, were up to 1.9 samples off."""

_LEAST_FREE = 1e-4
"""So little of the energy may lie where a drive is free of its limit; the uncertainty tells what that is worth."""


@dataclass(frozen=True, eq=False)
class FoundShot:
    """Where a drive holds a shot, and the drive as read from there.

    `match` is against the sound with the delay that the drive is meant to have; `uncertainty` is by how many samples
    its lag may be out, infinite where likeness alone tells it, which the actuator's limit bends.
    """

    match: Match
    uncertainty: float
    felt: Felt
    adjoints: Adjoints


@dataclass(frozen=True)
class _Unbent:
    """By how many samples a drive is late where its limit has no part in that, and how far out that may be."""

    lag: float
    uncertainty: float


def likeness_limit(shared: Comparison, event: Event) -> float:
    """Return the correlation that a shot's drive has to reach: nearly what was predicted when it was rendered.

    A direct drive, and one of which nothing was predicted, is to follow the sound as it is.
    """
    rules = shared.rules
    if event.drive is None or is_direct(event):
        return rules.correlation
    return max(rules.least_correlation, event.drive.fidelity - rules.correlation_loss)


def reach(shared: Comparison) -> int:
    """Return within how many samples of its place the actuator's limit alone leaves a shot."""
    return max(4, shared.samples(shared.bend_ms))


def sharp(shared: Comparison, event: Event) -> float:
    """Return how many samples a lag may be out to tell where the drive as a whole is: two of them tell its drift."""
    return 0.5 * min(shared.rules.shift_samples, shared.rules.drift_samples) * coarseness(shared, event)


def locate(shared: Comparison, event: Event, part: Part, *, time_map: TimeMap, search: int) -> Match:
    """Return where the drive holds a shot, by likeness alone, within `search` samples of where `time_map` says."""
    start, longest = part.span.start, shared.samples(shared.rules.longest_ms)
    short = replace(part, span=Span(start, min(part.span.stop, start + longest)))
    heard = hear(shared, event, short, Span(start, short.span.stop))
    felt = feel(shared, event, part, Span(start - search, short.span.stop + search), time_map=time_map)
    return match_template(heard.expected, felt.following)


def find_shot(
    shared: Comparison, event: Event, part: Part, heard: Heard, *, pattern: slice, time_map: TimeMap, in_place: bool
) -> FoundShot | None:
    """Return where the drive holds a shot, of which it is to follow `pattern`, around where `time_map` says.

    What the actuator's limit cannot bend counts before likeness: over a boom that rises on from the shot's own place,
    and where a seat rings the next shot may be more like this one than itself. Where the match is too poor to be
    believed, or where the limit alone may have bent it aside, the drive is read from the shot's own place. So is one
    without a solver that is nearer there to what is due, one at rest, which lacks all of it, and, `in_place`, that of a
    shot which no likeness can place: the match is told all the same. None where the soundtrack is silent.
    """
    lead = shared.samples(shared.lead_ms)
    piece = slice(heard.core.start - lead, part.driven.stop - heard.span.start)

    def read(late: int) -> FoundShot:
        there = TimeMap(time_map.scale, time_map.offset + late * time_map.scale)
        felt = feel(shared, event, part, heard.span, time_map=there)
        return FoundShot(Match(float(late), 0.0), math.inf, felt, adjoints_of(shared, heard, felt, piece=piece))

    own = read(0)
    unbent = None if is_direct(event) else _unbent(shared, own, pattern)
    nearby = _match_within(event, heard, own.felt, pattern, reach(shared))
    if unbent is None or unbent.uncertainty > sharp(shared, event):
        found = _by_likeness(shared, event, heard, own, unbent, pattern=pattern, read=read)
    else:
        found = read(round(unbent.lag)) if round(unbent.lag) else own
        found = replace(found, match=Match(unbent.lag, nearby.correlation), uncertainty=unbent.uncertainty)
    if found is None:
        return own if heard.expected[pattern].any() else None
    if found.felt is own.felt:
        return found
    if in_place:
        return replace(own, match=found.match, uncertainty=found.uncertainty)
    if not _is_nearer_to_due(shared, heard, own.felt, found.felt):
        return found
    return replace(own, match=Match(0.0, nearby.correlation), uncertainty=0.0)


def _by_likeness(
    shared: Comparison,
    event: Event,
    heard: Heard,
    own: FoundShot,
    near: _Unbent | None,
    *,
    pattern: slice,
    read: Callable[[int], FoundShot],
) -> FoundShot | None:
    """Return where a drive holds a shot by likeness, and by what the limit cannot bend there, or else `near`."""
    match = _match(shared, event, heard, own.felt, pattern)
    if math.isnan(match.lag):
        return None
    believed = abs(match.correlation) >= likeness_limit(shared, event)
    late = round(match.lag) if believed else 0
    found = read(late) if late else own
    uncertainty = 0.0 if is_direct(event) else math.inf  # a direct drive is known to the sample
    there = None if is_direct(event) or not late else _unbent(shared, found, pattern)
    if there is not None:
        match, uncertainty = Match(late + there.lag, match.correlation), there.uncertainty
    elif near is not None and abs(late) <= reach(shared):
        match, uncertainty = Match(near.lag, match.correlation), near.uncertainty
    is_aside = uncertainty <= sharp(shared, event) or abs(match.lag) > shared.samples(shared.bend_ms)
    settled = round(match.lag) if believed and is_aside else 0
    if settled != late:
        found = read(settled) if settled else own
    return replace(found, match=match, uncertainty=uncertainty)


def _match(shared: Comparison, event: Event, heard: Heard, felt: Felt, pattern: slice) -> Match:
    """Return where the drive is most like the sound; its own place, if it is due or as like there as was predicted."""
    if event.drive is not None and not is_direct(event):
        own = _match_within(event, heard, felt, pattern, reach(shared))
        if own.correlation >= event.drive.fidelity - shared.rules.fidelity_error or _is_due(shared, heard, felt):
            return own
    return _match_within(event, heard, felt, pattern, shared.samples(shared.rules.search_ms))


def _match_within(event: Event, heard: Heard, felt: Felt, pattern: slice, aside: int) -> Match:
    """Return where the drive is most like the sound within so many samples of where it was read, and how much so.

    The pattern tells where. What was predicted is the likeness of the whole shot: its attack, which the limit bends
    most, is less like the sound.
    """
    match = match_template(heard.expected[pattern], felt.following[pattern.start - aside : pattern.stop + aside])
    if event.drive is None or is_direct(event) or math.isnan(match.lag):
        return match
    late, core = round(match.lag), heard.core
    felt_there = felt.following[core.start + late : core.stop + late]
    return Match(match.lag, normalised_product(felt_there, heard.expected[core]))


def likeness_to_sound(shared: Comparison, event: Event, heard: Heard, found: FoundShot, pattern: slice) -> float:
    """Return how much a drive is like the sound where it was found; a direct one is found by what the limit leaves."""
    if not is_direct(event):
        return found.match.correlation
    around = slice(pattern.start - reach(shared), pattern.stop + reach(shared))
    return match_template(heard.undelayed[pattern], found.felt.following[around]).correlation


def _is_due(shared: Comparison, heard: Heard, felt: Felt) -> bool:
    """Return whether a drive without a solver is, sample for sample, what is due where it was read.

    So it is there, however little a seat that rings lets what is felt be like the sound.
    """
    apart = None if heard.solved else departure(shared, heard, felt, (unsolved_drive(shared, heard, felt),))
    return apart is not None and apart <= shared.rules.departure


def _is_nearer_to_due(shared: Comparison, heard: Heard, own: Felt, elsewhere: Felt) -> bool:
    """Return whether a drive without a solver is as near to what is due in its own place as elsewhere, or nearer.

    What is felt of one that was scaled down far lies beneath what a seat still rings with, and is found anywhere.
    """
    if heard.solved:
        return False
    return away_from_due(shared, heard, own) <= away_from_due(shared, heard, elsewhere)


def _unbent(shared: Comparison, read: FoundShot, pattern: slice) -> _Unbent | None:
    """Return the lag that the actuator's limit cannot bend; None where that tells it no better than likeness does.

    A drive u that makes |H u - t| least within its limit has, wherever it is free of it, no slope left to descend:
    H'(H u - t) = 0. So H'H u and H't are one and the same at these samples, and only at the right lag.
    """
    within = reach(shared)
    if pattern.stop - pattern.start < shared.samples(_LEAST_MS):
        return None
    around = slice(pattern.start - within, pattern.stop + within)
    intended, felt, free = read.adjoints.intended[pattern], read.adjoints.felt[around], read.felt.free[around]
    where_free = match_template(intended, felt, free, least_share=_LEAST_FREE)
    if where_free.correlation <= 0.0 or abs(where_free.lag) >= within:
        return None
    uncertainty = lag_uncertainty(intended, where_free, len(felt), free)
    return _Unbent(where_free.lag, uncertainty) if uncertainty <= shared.bend else None

"""The figures of one shot: what is felt against what is heard, wherever the drive has put it."""

import math
from dataclasses import dataclass

import numpy as np

from ..model import Event, Span
from ..units import SILENCE_DB, db_from_gain
from .correlate import Match, find
from .hearing import Comparison, Felt, Heard, Samples, feel, hear, is_direct
from .sounds import Place

_BEFORE_MS = 20.0
"""Where a pre-echo is looked for; what precedes a shot by more is not heard or felt as part of it."""

_EARLIEST_MS = 5.0
"""How long before the onset a felt attack is looked for."""

_ATTACK_MS = 12.0
"""The longest blast of the segmentation: the attack's peak lies within."""

_HIDDEN = 0.7
"""A rise that needs more than this share of its peak to stand out of what precedes it is hidden."""

_REST = 0.01
"""A drive below this share of its peak is at rest."""

REFINE_MS = 0.1
"""How far the actuator's limit can bend the plain correlation's peak aside: 1.1 samples at 48 kHz was the most seen."""

_EXACT = 0.98
"""Where the drive is free of its limit, a right one follows the sound at least this well (0.99 in what we rendered)."""


@dataclass(frozen=True)
class ShotFigures:
    """What was measured of a shot: lags in samples, levels in decibels.

    `match` is against the sound with the delay that the drive is meant to have; `delay` is that delay. `exact` says
    that the actuator's limit has no part in the lag. The others are measured where the match is, or in the shot's own
    place where the match is too poor to be believed.
    """

    match: Match
    exact: bool
    delay: float
    peak: float
    onset_error: float
    level_db: float
    preecho_db: float
    intended_preecho_db: float


def part_of(event: Event, following: Event | None, *, lead: int) -> Span:
    """Return what belongs to a shot alone: from its onset to its window's fade-out or `lead` before the next onset.

    window   |------------------------|
    onsets     ^         ^
    parts      [-------) [---------)
    """
    window = event.window
    stop = max(window.stop - window.fade_out_samples, event.onset_sample + 1)
    if following is not None and following.onset_sample > event.onset_sample:
        stop = min(stop, max(following.onset_sample - lead, event.onset_sample + 1))
    return Span(event.onset_sample, stop)


def likeness_limit(shared: Comparison, event: Event) -> float:
    """Return the correlation that a shot's drive has to reach: nearly what was predicted when it was rendered.

    A direct drive, and one of which nothing was predicted, is to follow the sound as it is.
    """
    rules = shared.rules
    if event.drive is None or is_direct(event):
        return rules.correlation
    return max(rules.least_correlation, event.drive.fidelity - rules.correlation_loss)


def measure(shared: Comparison, event: Event, part: Span, *, place: Place) -> ShotFigures | None:
    """Return a shot's figures, with the drive read from where `place` says and searched for around there.

    None where soundtrack or drive are silent.
    """
    search = shared.samples(shared.rules.search_ms)
    heard = hear(shared, event, part, margin=search)
    felt = feel(shared, event, heard.span, place=place)
    core = heard.core
    pattern = slice(core.start, min(core.stop, core.start + shared.samples(shared.rules.longest_ms)))
    match = find(heard.intended[pattern], felt.following[pattern.start - search : pattern.stop + search])
    if math.isnan(match.lag):
        return None
    refined = None if is_direct(event) else _refined(shared, heard, felt, pattern, match)
    match = refined or match
    late = round(match.lag) if abs(match.correlation) >= likeness_limit(shared, event) else 0
    vibration = felt.vibration[core.start + late : core.stop + late]
    preecho, own_preecho = _preechos(shared, heard, felt.following, late)
    return ShotFigures(
        match,
        exact=refined is not None or is_direct(event),
        delay=_delay(heard, pattern, search),
        peak=felt.peak,
        onset_error=_onset_error(shared, heard, felt, late),
        level_db=db_from_gain(_rms(vibration)) - db_from_gain(_rms(heard.direct[core])),
        preecho_db=preecho,
        intended_preecho_db=own_preecho,
    )


def locate(shared: Comparison, event: Event, part: Span, *, place: Place, search: int) -> Match:
    """Return where the drive holds a shot, within `search` samples of where `place` says."""
    part = Span(part.start, min(part.stop, part.start + shared.samples(shared.rules.longest_ms)))
    heard = hear(shared, event, part, margin=0)
    felt = feel(shared, event, Span(part.start - search, part.stop + search), place=place)
    return find(heard.intended, felt.following)


def _refined(shared: Comparison, heard: Heard, felt: Felt, pattern: slice, match: Match) -> Match | None:
    """Return the match with the lag that the actuator's limit cannot bend; None where the limit leaves too little.

    A drive u that makes |H u - t| least within its limit has, wherever it is free of it, no slope left to descend:
    H'(H u - t) = 0. So H'H u and H't are one and the same at these samples, and only at the right lag.
    """
    late, reach = round(match.lag), max(4, shared.samples(REFINE_MS))
    around = slice(max(0, pattern.start + late - reach), pattern.stop + late + reach)
    sound, vibration = (shared.shown_to_actuator(signal) for signal in (heard.intended, felt.following))
    if len(vibration[around]) != pattern.stop - pattern.start + 2 * reach:
        return None
    at_limit = find(sound[pattern], vibration[around], felt.free[around])
    if at_limit.correlation < _EXACT or abs(at_limit.lag) >= reach:
        return None
    return Match(late + at_limit.lag, match.correlation)


def _delay(heard: Heard, pattern: slice, search: int) -> float:
    """Return how many samples later the intended sound is than the undelayed one."""
    if heard.intended is heard.undelayed:
        return 0.0
    return find(heard.undelayed[pattern], heard.intended[pattern.start - search : pattern.stop + search]).lag


def _onset_error(shared: Comparison, heard: Heard, felt: Felt, late: int) -> float:
    """Return how many samples later the felt attack rises than the heard one.

    Both rise when they first exceed the same share of their own peaks: a tenth, or twice what precedes the attack.
    Where noise hides the rise, it is how much too late the drive begins to move at all.
    """
    onset, before = heard.core.start, shared.samples(_BEFORE_MS)
    attack = max(1, min(shared.samples(_ATTACK_MS), heard.core.stop - onset))
    share, rises = 0.1, []
    for signal, at, early in (
        (heard.intended, onset, shared.samples(shared.rules.lead_ms)),
        (felt.following, onset + late, shared.samples(_EARLIEST_MS)),
    ):
        start = max(0, at - early)
        rising = np.abs(signal[start : max(start, at) + attack])
        peak = float(rising.max(initial=0.0))
        if peak == 0.0:
            return _first_move(shared, felt, onset + late, attack)
        share = max(share, 2.0 * float(np.abs(signal[max(0, at - before) : start]).max(initial=0.0)) / peak)
        rises.append((rising / peak, start - at))
    if share > _HIDDEN:
        return _first_move(shared, felt, onset + late, attack)
    heard_rise, felt_rise = (int(np.argmax(rising >= share)) + start for rising, start in rises)
    return float(felt_rise - heard_rise)


def _first_move(shared: Comparison, felt: Felt, onset: int, attack: int) -> float:
    """Return how many samples after an onset the drive leaves rest, 0 where it moves before.

    Rest is judged by the attack alone: what is loud later in the window does not make a quiet attack rest.
    """
    start = max(0, onset - shared.samples(_EARLIEST_MS))
    moving = np.abs(felt.drive[start : max(start, onset) + attack])
    peak = float(moving.max(initial=0.0))
    if peak == 0.0:
        return float(attack)
    return float(max(0, start + int(np.argmax(moving > _REST * peak)) - onset))


def _preechos(shared: Comparison, heard: Heard, following: Samples, late: int) -> tuple[float, float]:
    """Return the level before a shot against its own peak, of what is felt and of what was intended.

    The latter holds what the sound itself has there, and what a zero-phase band rings before a bang.
    """
    guard, before = shared.samples(shared.rules.preecho_guard_ms), shared.samples(_BEFORE_MS)
    levels = []
    for signal, onset in ((following, heard.core.start + late), (heard.intended, heard.core.start)):
        peak = float(np.abs(signal[max(0, onset) : heard.core.stop]).max(initial=0.0))
        early = float(np.abs(signal[max(0, onset - before) : max(0, onset - guard)]).max(initial=0.0))
        levels.append(db_from_gain(early / peak) if peak > 0.0 else SILENCE_DB)
    return levels[0], levels[1]


def _rms(samples: Samples) -> float:
    return math.sqrt(float(np.mean(samples**2))) if len(samples) else 0.0

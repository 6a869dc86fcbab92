"""One shot: what is felt against what is heard, wherever the drive has put it."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..model import Event, Phase, Span
from ..ruleset import ActuatorProfile, AlignRules
from ..units import SILENCE_DB, db_from_gain, samples_from_ms
from .correlate import Match, find
from .sounds import Place, Sound, drive_at, stretch_of

_SETTLE_MS = 250.0
"""Filters run this long before what is compared: eight time constants of a 5 Hz high-pass."""

_BEFORE_MS = 20.0
"""Where a pre-echo is looked for; what precedes a shot by more is not heard or felt as part of it."""

_ATTACK_MS = 12.0
"""The longest blast of the segmentation: the attack's peak lies within."""

_AT_LIMIT = 0.995
"""A drive sample of this share of the limit is taken as limited: interpolated and quantised ones miss it a little."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """What the checks of every shot share: films, rules, and the actuator's filters at the soundtrack's rate."""

    audio: Sound
    drive: Sound
    rules: AlignRules
    phase: Phase
    felt: NDArray[np.float64]
    band: NDArray[np.float64]
    band_gains: Callable[[int], NDArray[np.float64]]

    @property
    def rate_hz(self) -> int:
        """Return the rate at which everything is compared, the soundtrack's."""
        return self.audio.rate_hz

    def samples(self, duration_ms: float) -> int:
        """Return a duration in samples."""
        return samples_from_ms(duration_ms, self.rate_hz)


def compare(audio: Sound, drive: Sound, *, profile: ActuatorProfile, rules: AlignRules, phase: Phase) -> Comparison:
    """Return what the checks of every shot share."""
    rate_hz = audio.rate_hz
    band = dsp.band(profile)

    @lru_cache(maxsize=64)
    def band_gains(size: int) -> NDArray[np.float64]:
        frequencies_hz = np.asarray(np.fft.rfftfreq(size, 1.0 / rate_hz), dtype=np.float64)
        if phase == "zero":
            return np.abs(dsp.half_band(profile).at(frequencies_hz)) ** 2
        return np.abs(band.at(frequencies_hz))

    felt = dsp.digital(dsp.felt_response(profile), rate_hz)
    return Comparison(audio, drive, rules, phase, felt, dsp.digital(band, rate_hz), band_gains)


@dataclass(frozen=True, eq=False)
class Heard:
    """The sound of a shot in the band of vibration, over `span`, of which `core` holds what is compared.

    `intended` has the delay that the drive is meant to have, `undelayed` none, `causal` that of causal filters;
    `direct` is what direct conversion would make felt.
    """

    span: Span
    core: slice
    intended: NDArray[np.float64]
    undelayed: NDArray[np.float64]
    causal: NDArray[np.float64]
    direct: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Felt:
    """The drive of a shot over a span: its vibration as felt, and what of it is to follow the sound.

    They are the same but for a `direct` drive, which does not compensate: there the drive itself is to follow, in
    the band of vibration. `free` marks samples away from the actuator's limit.
    """

    vibration: NDArray[np.float64]
    following: NDArray[np.float64]
    free: NDArray[np.bool_]
    peak: float


@dataclass(frozen=True)
class ShotFigures:
    """What was measured of a shot: lags in samples, levels in decibels; None where it cannot be measured."""

    match: Match
    peak: float
    undelayed_lag: float | None
    onset_error: float | None
    level_db: float | None
    preecho_db: float | None
    heard_preecho_db: float | None


def part_of(event: Event, following: Event | None) -> Span:
    """Return what belongs to a shot alone: from its onset to its window's fade-out or to the next onset.

    window   |------------------------|
    onsets     ^         ^
    parts      [---------)[--------)
    """
    window = event.window
    stop = max(window.stop - window.fade_out_samples, event.onset_sample + 1)
    if following is not None and following.onset_sample > event.onset_sample:
        stop = min(stop, following.onset_sample)
    return Span(event.onset_sample, stop)


def measure(shared: Comparison, event: Event, part: Span, *, place: Place) -> ShotFigures:
    """Return a shot's figures, with the drive read from where `place` says and searched for around there."""
    search = shared.samples(shared.rules.search_ms)
    heard = _hear(shared, event, part, margin=search)
    felt = _feel(shared, event, heard.span, place)
    core = heard.core
    pattern = slice(core.start, min(core.stop, core.start + shared.samples(shared.rules.longest_ms)))
    around = slice(0, pattern.stop + search)
    match = find(heard.intended[pattern], felt.following[around], felt.free[around])
    if math.isnan(match.lag):
        return ShotFigures(match, felt.peak, None, None, None, None, None)
    undelayed = find(heard.undelayed[pattern], felt.following[around], felt.free[around])
    late = round(match.lag)
    vibration = felt.vibration[core.start + late : core.stop + late]
    preecho, own_preecho = _preechos(shared, heard, felt.following, late)
    return ShotFigures(
        match,
        felt.peak,
        undelayed.lag,
        _onset_error(shared, heard, felt.following),
        db_from_gain(_rms(vibration)) - db_from_gain(_rms(heard.direct[core])),
        preecho,
        own_preecho,
    )


def locate(shared: Comparison, event: Event, part: Span, *, place: Place, search: int) -> Match:
    """Return where the drive holds a shot, within `search` samples of where `place` says."""
    part = Span(part.start, min(part.stop, part.start + shared.samples(shared.rules.longest_ms)))
    heard = _hear(shared, event, part, margin=0)
    felt = _feel(shared, event, Span(part.start - search, part.stop + search), place)
    return find(heard.intended, felt.following, felt.free)


def _hear(shared: Comparison, event: Event, part: Span, *, margin: int) -> Heard:
    settle = shared.samples(_SETTLE_MS)
    span = Span(part.start - margin, part.stop + margin)
    audio = stretch_of(shared.audio, Span(span.start - settle, span.stop + settle))
    kept = slice(settle, settle + len(span))
    undelayed = _without_delay(shared, audio)[kept]
    causal = dsp.run_filter(shared.band, audio[: kept.stop])[kept]
    as_intended = causal if shared.phase == "causal" and not _is_direct(event) else undelayed
    direct = dsp.run_filter(shared.felt, np.clip(audio[: kept.stop], -1.0, 1.0))[kept]
    return Heard(span, slice(margin, margin + len(part)), as_intended, undelayed, causal, direct)


def _feel(shared: Comparison, event: Event, span: Span, place: Place) -> Felt:
    settle = shared.samples(_SETTLE_MS)
    wide = Span(span.start - settle, span.stop + settle)
    drive, written = drive_at(shared.drive, wide, rate_hz=shared.rate_hz, place=place)
    kept = slice(settle, settle + len(span))
    vibration = dsp.run_filter(shared.felt, drive[: kept.stop])[kept]
    following = _without_delay(shared, drive)[kept] if _is_direct(event) else vibration
    limited = np.abs(drive[: kept.stop]) >= _AT_LIMIT * shared.rules.peak
    free = ~_near(limited, shared.samples(shared.rules.free_ms))[kept]
    return Felt(vibration, following, free, float(np.abs(written).max(initial=0.0)))


def _is_direct(event: Event) -> bool:
    return event.drive is not None and event.drive.model == "direct"


def _onset_error(shared: Comparison, heard: Heard, following: NDArray[np.float64]) -> float | None:
    """Return how many samples later the felt attack rises than the heard one; None where noise hides the rise.

    Both rise when they first exceed the same share of their own peaks: a tenth, or twice what precedes the attack.
    """
    onset = heard.core.start
    attack = slice(
        onset - shared.samples(shared.rules.lead_ms), min(onset + shared.samples(_ATTACK_MS), heard.core.stop)
    )
    before = np.abs(heard.intended[max(0, onset - shared.samples(_BEFORE_MS)) : attack.start])
    heard_peak, felt_peak = (float(np.abs(signal[attack]).max()) for signal in (heard.intended, following))
    if heard_peak == 0.0 or felt_peak == 0.0:
        return None
    share = max(0.1, 2.0 * float(before.max(initial=0.0)) / heard_peak)
    if share > 0.7:
        return None
    heard_rise = int(np.argmax(np.abs(heard.intended[attack]) >= share * heard_peak))
    felt_rise = int(np.argmax(np.abs(following[attack]) >= share * felt_peak))
    return float(felt_rise - heard_rise)


def _preechos(shared: Comparison, heard: Heard, following: NDArray[np.float64], late: int) -> tuple[float, float]:
    """Return the level before a shot against its own peak, of what is felt and of what is heard."""
    guard = shared.samples(shared.rules.preecho_guard_ms)
    before = shared.samples(_BEFORE_MS)
    own = heard.undelayed if heard.intended is heard.undelayed and shared.phase == "causal" else heard.causal
    levels = []
    for signal, onset in ((following, heard.core.start + late), (own, heard.core.start)):
        peak = float(np.abs(signal[onset : max(onset, heard.core.stop)]).max(initial=0.0))
        early = float(np.abs(signal[max(0, onset - before) : max(0, onset - guard)]).max(initial=0.0))
        levels.append(db_from_gain(early / peak) if peak > 0.0 else SILENCE_DB)
    return levels[0], levels[1]


def _without_delay(shared: Comparison, samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return samples in the band of vibration, by the magnitude of its response alone, hence without delay."""
    from scipy import fft

    size = fft.next_fast_len(len(samples), real=True)
    return np.asarray(fft.irfft(fft.rfft(samples, size) * shared.band_gains(size), size)[: len(samples)], np.float64)


def _near(marked: NDArray[np.bool_], reach: int) -> NDArray[np.bool_]:
    """Return which samples lie within `reach` of a marked one."""
    if not marked.any():
        return marked
    count = np.cumsum(np.concatenate([np.zeros(reach + 1, np.int64), marked, np.zeros(reach, np.int64)]))
    return np.asarray(count[2 * reach + 1 :] > count[: len(marked)], dtype=np.bool_)


def _rms(samples: NDArray[np.float64]) -> float:
    return math.sqrt(float(np.mean(samples**2))) if len(samples) else 0.0

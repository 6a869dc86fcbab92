"""A shot's sound in the band of vibration, and what the drive that belongs to it is to do."""

import math
from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..model import Event, Span
from ..units import gain_from_db
from .comparison import Comparison, Samples
from .sounds import read_padded


@dataclass(frozen=True)
class Part:
    """What belongs to a shot alone: `span` of its sound, and `driven`, where the drive is its own.

    `opens` says that the shot is the first of its window. `since` is from where on the drive before it is known, by the
    window or by the shot before, which was asked to be `before_db` stronger. `gains` are the onset of each shot of the
    window with how much stronger than usual it was asked to be, in dB; empty where all of them were by as much.
    `earlier_stop` is where the window before its own ends, 0 where there is none: a seat that rings for long still
    moves with that.
    """

    span: Span
    opens: bool
    since: int
    driven: Span
    before_db: float = 0.0
    gains: tuple[tuple[int, float], ...] = ()
    earlier_stop: int = 0


@dataclass(frozen=True, eq=False)
class Heard:
    """The sound of a shot in the band of vibration, over `span`, and the drives that go with it; arrays are as long.

    `core` is where in the span the shot itself lies. Up to its sample `stop` the drive is the shot's own, with the
    fade-out where its window ends there.

    - `intended`: the sound with the delay that the drive is meant to have, and with what a louder shot before leaves
      ringing where nothing solves against that; of a direct drive, as the limit leaves it;
    - `undelayed`: the same without any delay, and of a direct drive without the limit on the shot itself;
    - `expected`: what is felt where the drive succeeds: `intended`, and what the background before the window, since
      the window before that, leaves ringing;
    - `direct`: what direct conversion would make felt of the window alone, from rest;
    - `background`: the drive beside the windows;
    - `wet`: the drive of an open window if nothing limited it. That of a `solved` one is another, but was solved as if
      it were this from the next onset on;
    - `weights`: by how much an open window's drive is blended in over the background;
    - `fading`: by how much the window's end leaves of it.

    `gain` is how much stronger than usual the shot was made.
    """

    span: Span
    core: slice
    stop: int
    intended: Samples
    undelayed: Samples
    expected: Samples
    direct: Samples
    background: Samples
    wet: Samples
    weights: Samples
    fading: Samples
    solved: bool
    gain: float


def is_direct(event: Event) -> bool:
    """Return whether a shot's drive is its sound as it is."""
    return event.drive is not None and event.drive.model == "direct"


def is_solved(event: Event) -> bool:
    """Return whether a shot's drive is to be the best within the limit; of one of unknown making that is assumed."""
    return event.drive is None or event.drive.model == "constrained"


def coarseness(shared: Comparison, event: Event) -> float:
    """Return by how much limits in samples grow for a shot's drive: only one that is solved has corners."""
    return shared.coarseness if is_solved(event) else 1.0


def hear(shared: Comparison, event: Event, part: Part, span: Span) -> Heard:
    """Return the sound of a shot over a span that its part lies in."""
    settle = shared.settle
    wide = Span(span.start - settle, span.stop + settle)
    audio = read_padded(shared.audio, wide, event.made_of)
    kept = slice(settle, settle + len(span))
    dry = np.clip(audio, -1.0, 1.0)
    background = _background(shared, event, dry, wide)
    wet, undelayed, delayed = _wanted(shared, event, part, audio, background, wide)
    is_linear = not is_solved(event) and not is_direct(event)
    # H rings on with the shots before, however soft this one
    intended = dsp.run_filter(shared.felt, wet) if is_linear and part.gains else delayed
    return Heard(
        span,
        slice(part.span.start - span.start, part.span.stop - span.start),
        part.driven.stop - span.start,
        intended[kept],
        undelayed[kept],
        _expected(shared, event, part, wet, intended, background, wide)[kept],
        direct=dsp.run_filter(shared.felt, resting_until(event.window.start, dry, wide)[: kept.stop])[kept],
        background=background[kept],
        wet=wet[kept],
        weights=_risen(event, span),
        fading=_fallen(event, span),
        solved=is_solved(event),
        gain=_gain(shared, event),
    )


def _background(shared: Comparison, event: Event, dry: Samples, span: Span) -> Samples:
    """Return the drive beside the windows over a span, of which `dry` is the sound that the shot's drive is made of."""
    if shared.background == "mute":
        return np.zeros(len(span))
    return dry if event.made_of == "mains" else np.clip(read_padded(shared.audio, span), -1.0, 1.0)


def _wanted(
    shared: Comparison, event: Event, part: Part, audio: Samples, background: Samples, span: Span
) -> tuple[Samples, Samples, Samples]:
    """Return `wet` and `undelayed` of `Heard`, and this with the delay of the drive, over the span of `audio`.

    All is against the gain of the shot.
    """
    relative = _relative_gain(shared, event, part, span)
    if is_direct(event):
        wet = relative * audio
        drive = _as_driven(shared, event, wet, background, span)
        sound, own = drive.copy(), slice(part.span.start - span.start, part.span.stop - span.start)
        sound[own] = wet[own]
        return wet, shared.without_delay(sound), shared.without_delay(drive)
    centred = _centred(shared, event, audio, span)
    wet, undelayed = relative * shared.compensated(centred), relative * shared.without_delay(centred)
    return wet, undelayed, relative * dsp.run_filter(shared.band, centred) if shared.phase == "causal" else undelayed


def _centred(shared: Comparison, event: Event, audio: Samples, span: Span) -> Samples:
    """Return the sound of a span without what it stands off zero; beside the film are zeros."""
    begun, ended = max(0, -span.start), max(0, shared.audio.frames - span.start)
    level = dsp.level_at(
        event.window.start,
        lambda start, stop: read_padded(shared.audio, Span(start, stop), event.made_of),
        preroll=shared.preroll,
        frames=shared.audio.frames,
        rate_hz=shared.rate_hz,
    )
    return np.concatenate([audio[:begun], audio[begun:ended] - level, audio[ended:]])


def _expected(
    shared: Comparison, event: Event, part: Part, wet: Samples, intended: Samples, background: Samples, span: Span
) -> Samples:
    """Return `expected` of `Heard` over a span, against the gain of the shot.

    However soft a shot is, the background that fades out before it has its full level, and H rings on with that.
    """
    if shared.background == "mute" or is_direct(event):
        return intended
    own = np.zeros(len(span)) if is_solved(event) else wet
    opening = dsp.cross_fade(background / _gain(shared, event), own, _risen(event, span))
    return intended + dsp.run_filter(shared.felt, resting_until(part.earlier_stop, opening - own, span))


def _relative_gain(shared: Comparison, event: Event, part: Part, span: Span) -> Samples:
    """Return the gain against the shot's own over a span: each shot's is reached over the lead before its onset.

    Shots that are further away than the next ones count as well: the band without delay spreads them over this one.
    """
    at, lead = np.arange(span.start, span.stop), shared.samples(shared.lead_ms)
    first = max(0, bisect_right(part.gains, (span.start, math.inf)) - 1)
    known = part.gains[first : max(first + 1, bisect_right(part.gains, (span.stop + lead, math.inf)))]
    relative = np.full(len(span), gain_from_db(known[0][1] - event.gain_db) if known else 1.0)
    for (before, before_db), (onset, gain_db) in pairwise(known):
        start = min(onset, max(before + 1, onset - lead))
        ramp = np.interp(at, [start, onset], [gain_from_db(each - event.gain_db) for each in (before_db, gain_db)])
        relative = np.where(at < start, relative, ramp)
    return relative


def _as_driven(shared: Comparison, event: Event, wet: Samples, background: Samples, span: Span) -> Samples:
    """Return a direct drive as the limit leaves it, with what is beside the shot, over which the band will spread it.

    All is against the gain of the shot, as `wet` is.
    """
    gain = _gain(shared, event)
    weights = _risen(event, span) * _fallen(event, span)
    return dsp.cross_fade(background, np.clip(gain * wet, -1.0, 1.0), weights) / gain


def _gain(shared: Comparison, event: Event) -> float:
    """Return the gain of a shot in its window, which is scaled down where the compensator's drive exceeds the limit."""
    gain = gain_from_db(event.gain_db + shared.level_db)
    if event.drive is not None and event.drive.model == "filter":
        gain /= max(1.0, event.drive.evidence.get("filter_peak", 1.0))
    return gain


def _risen(event: Event, span: Span) -> Samples:
    """Return the weight of the window's drive over a span, up to the fade-out."""
    window = event.window
    return _faded_in(np.arange(span.start, span.stop) - window.start, window.fade_in_samples)


def _fallen(event: Event, span: Span) -> Samples:
    """Return the weight of the window's drive over a span, from the fade-in on."""
    window = event.window
    return _faded_in(window.stop - 1 - np.arange(span.start, span.stop), window.fade_out_samples)


def _faded_in(at: NDArray[np.int64], length: int) -> Samples:
    """Return the weights of a fade at samples counted from its start, of which it has `length`."""
    fade = np.concatenate([[0.0], dsp.fade(length), [1.0]])
    return np.asarray(fade[np.clip(at + 1, 0, len(fade) - 1)], dtype=np.float64)


def resting_until(at: int, samples: Samples, span: Span) -> Samples:
    """Return samples over a span of the film, at rest until one of the film's."""
    before = min(at - span.start, len(span))
    return np.concatenate([np.zeros(before), samples[before:]]) if before > 0 else samples

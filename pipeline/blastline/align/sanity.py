"""Whether a timeline makes sense by itself, and whether its shots are where it says."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..model import Event, Span
from ..units import db_from_gain, samples_from_ms
from .sounds import Sound, read_padded

_AROUND_MS = 10.0


def order_faults(events: Sequence[Event], frames: int) -> int:
    """Return how often events are out of order, windows overlap or leave the film, or a shot leaves its window.

    Shots of one window share it; other windows are disjoint.
    """
    late = sum(a.onset_sample > b.onset_sample for a, b in pairwise(events))
    windows = sorted({(event.window.start, event.window.stop) for event in events})
    overlaps = sum(first[1] > second[0] for first, second in pairwise(windows))
    outside = sum(stop > frames for _, stop in windows)
    lost = sum(event.onset_sample not in event.window.span for event in events)
    repeated = len(events) - len({event.id for event in events})
    return late + overlaps + outside + lost + repeated


def fade_margin(event: Event) -> int:
    """Return how many samples before the onset the fade-in is over; negative where it eats into the attack."""
    return event.onset_sample - (event.window.start + event.window.fade_in_samples)


def audio_rise_db(event: Event, audio: Sound) -> float:
    """Return how much higher the peak of what becomes the drive is just after the onset than before it, in decibels."""
    around = samples_from_ms(_AROUND_MS, audio.rate_hz)
    onset = event.onset_sample
    return _rise_db(read_padded(audio, Span(onset - around, onset + around), event.made_of), around)


def heard_rise_db(event: Event, audio: Sound) -> float | None:
    """Return the same of the sound in which the shot was found; None where that cannot be read again.

    Where a film drives the seat from other channels than detection listens to, what becomes the drive need not rise.
    """
    onset, around = event.onset_sample, samples_from_ms(_AROUND_MS, audio.rate_hz)
    inside = Span(onset - around, onset + around) & Span(0, audio.frames)
    heard = audio.file.read(inside, sides=event.heard_in == "sides").heard_in(event.heard_in)
    return None if heard is None else _rise_db(heard, onset - inside.start)


def is_rise_owed(event: Event, before: Event | None, rate_hz: int) -> bool:
    """Return whether the sound of a right shot has to rise at its onset; `before` is the event before it, if any.

    In a burst the shot before still sounds, and may be the louder; and where the film has just begun there is nothing
    before to rise from but the shot's own first samples. A shot that was set by hand is where somebody wants it.
    """
    in_burst = before is not None and before.window == event.window
    return event.origin == "found" and not in_burst and event.onset_sample >= samples_from_ms(_AROUND_MS, rate_hz)


def _rise_db(samples: NDArray[np.floating], onset: int) -> float:
    before, after = (float(np.abs(part).max(initial=0.0)) for part in (samples[:onset], samples[onset:]))
    return db_from_gain(max(after, 1e-12) / max(before, 1e-12))

"""Whether a timeline makes sense by itself, and whether its shots are where it says."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..model import Event, Span
from ..ruleset import AlignRules
from ..units import samples_from_ms
from .sounds import Sound, stretch_of

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
    """Return how much higher the soundtrack's peak is just after the onset than just before it, in decibels."""
    around = samples_from_ms(_AROUND_MS, audio.rate_hz)
    onset = event.onset_sample
    before, after = (
        float(np.abs(stretch_of(audio, span)).max(initial=0.0))
        for span in (Span(onset - around, onset), Span(onset, onset + around))
    )
    return float(20.0 * np.log10(max(after, 1e-12) / max(before, 1e-12)))


def is_telling(event: Event, audio: Sound, rules: AlignRules) -> bool:
    """Return whether a shot's drive can be compared with the sound: of one set by hand, where an attack is heard.

    Who edits a timeline may put an event where nothing begins. In a tone or in silence one place sounds like the next,
    and so nothing tells whether the drive is in its own.
    """
    return event.origin == "found" or audio_rise_db(event, audio) >= rules.hand_rise_db

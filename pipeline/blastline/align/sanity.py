"""Whether a timeline makes sense by itself, and whether its shots are where it says."""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..model import Event, Span, Timeline
from ..units import db_from_gain, samples_from_ms
from .sounds import Sound, read_padded

_AROUND_MS = 10.0
_STANDING_MS = 200.0
"""So long before a shot tells what its film stands on: four swings of a rumble at 20 Hz, and little of a shot."""


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


def changed_shots(timeline: Timeline, markers: Mapping[str, int] | None) -> tuple[Sequence[str], Sequence[str]]:
    """Return which shots the drive was rendered with and are no more in the timeline, and which it was not.

    `markers` are the samples of all shots that it was rendered with, by their ids, None where these are not known: then
    the number of shots tells, by the checks in the timeline, and other ids alone tell nothing. A shot is where its
    blast begins: an onset that was edited, or another id, is told by itself.
    """
    driven = {event.id: event.blast.start for event in timeline.events if event.drive is not None}
    if markers is not None:
        lost = [name for name, sample in markers.items() if sample not in driven.values()]
        added = [name for name, sample in driven.items() if sample not in markers.values()]
        if lost or added:
            return lost, added
    rendered = rendered_shots(timeline)
    if not timeline.checks or len(driven) == len(rendered):
        return (), ()
    lost, added = sorted(rendered - driven.keys()), sorted(driven.keys() - rendered)
    return (lost, ()) if len(driven) < len(rendered) else ((), added)


def rendered_shots(timeline: Timeline) -> frozenset[str]:
    """Return the ids of the shots that had a drive when the checks in the timeline were written, which name each."""
    return frozenset(check.event for check in timeline.checks if check.event is not None)


def fade_margin(event: Event) -> int:
    """Return how many samples before the onset the fade-in is over; negative where it eats into the attack."""
    return event.onset_sample - (event.window.start + event.window.fade_in_samples)


def audio_rise_db(event: Event, audio: Sound) -> float:
    """Return how much higher the peak of what becomes the drive is just after the onset than before it, in decibels.

    Against what it stands on: a constant is neither heard nor driven.
    """
    around = _around(event, audio)
    return _rise_db(read_padded(audio, around, event.made_of), event.onset_sample - around.start, audio.rate_hz)


def heard_rise_db(event: Event, audio: Sound) -> float | None:
    """Return the same of the sound in which the shot was found; None where that cannot be read again.

    Where a film drives the seat from other channels than detection listens to, what becomes the drive need not rise.
    """
    around = _around(event, audio)
    heard = audio.file.read(around, sides=event.heard_in == "sides").heard_in(event.heard_in)
    return None if heard is None else _rise_db(heard, event.onset_sample - around.start, audio.rate_hz)


def is_rise_owed(event: Event, before: Event | None, rate_hz: int) -> bool:
    """Return whether the sound of a right shot has to rise at its onset; `before` is the event before it, if any.

    In a burst the shot before still sounds, and may be the louder; and where the film has just begun there is nothing
    before to rise from but the shot's own first samples. A shot that was set by hand is where somebody wants it.
    """
    in_burst = before is not None and before.window == event.window
    return event.origin == "found" and not in_burst and event.onset_sample >= samples_from_ms(_AROUND_MS, rate_hz)


def _around(event: Event, audio: Sound) -> Span:
    """Return what of the film tells a shot's rise: what it stands on before, and what comes just after its onset."""
    before, after = samples_from_ms(_STANDING_MS, audio.rate_hz), samples_from_ms(_AROUND_MS, audio.rate_hz)
    return Span(event.onset_sample - before, event.onset_sample + after) & Span(0, audio.frames)


def _rise_db(samples: NDArray[np.floating], onset: int, rate_hz: int) -> float:
    swing = np.abs(samples - (np.median(samples[:onset]) if onset else 0.0))
    near = swing[max(0, onset - samples_from_ms(_AROUND_MS, rate_hz)) : onset]
    before, after = (float(part.max(initial=0.0)) for part in (near, swing[onset:]))
    return db_from_gain(max(after, 1e-12) / max(before, 1e-12))

"""Events in the order of time, each with its end: what is long in a tool's timeline must not hide the next shot."""

from collections.abc import Iterator
from itertools import pairwise

from ..model import Event, Timeline


def with_ends(timeline: Timeline) -> Iterator[tuple[Event, int]]:
    """Yield each event in the order of onsets with the sample where it ends: at the next onset or its window's end."""
    events = sorted(timeline.events, key=lambda event: event.onset_sample)
    for event, after in pairwise([*events, None]):
        if event is not None:
            stop = event.window.stop if after is None else min(event.window.stop, after.onset_sample)
            yield event, max(event.onset_sample, stop)

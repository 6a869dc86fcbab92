"""Ends that only make room for the next shot: what a tool shows of a shot in a burst is not its window.

REAPER's regions, as they are exported, end at the next onset, so that none hides another. Such an end was set by
nobody: the shots go on in one window.

    region   |--1--|--2--|--3-------|
    window  |-----------------------|

Audacity's labels end with the window. One that is dragged takes that end along; it is still not where its shot ends,
unless it is the last one there.
"""

from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction

from ...model import Event
from .row import Pair


def without_ends_at_the_next(pairs: Sequence[Pair], originals: Iterable[Event], *, rate_hz: int) -> list[Pair]:
    """Return the rows, those that end at the next onset, or with the window of a later shot, without their end.

    The next onset is that of the file's next row, or that of the original's next event. So it is also where the row
    was moved with its length.
    """
    here = sorted(pair.edit.onset.nearest(rate_hz) for pair in pairs)
    there = sorted(event.onset_sample for event in originals)
    return [_without_end(pair, here, there, rate_hz) for pair in pairs]


def _without_end(pair: Pair, here: Sequence[int], there: Sequence[int], rate_hz: int) -> Pair:
    edit = pair.edit
    if edit.window_stop is None:
        return pair
    onset_s, stop_s = edit.onset.exact_s(rate_hz), edit.window_stop.exact_s(rate_hz)
    ends_s = [Fraction(after, rate_hz) for after in _next(here, edit.onset.nearest(rate_hz))]
    if pair.was is not None:
        begins, stop = pair.was.onset_sample, pair.was.window.stop
        for after in _next(there, begins):
            shared = [stop] if after < stop else []
            for end in (after, *shared):
                ends_s += [Fraction(end, rate_hz), onset_s + Fraction(end - begins, rate_hz)]
    near_s = edit.onset.tool_step_s + edit.window_stop.tool_step_s
    if any(abs(stop_s - end_s) <= near_s for end_s in ends_s):
        return replace(pair, edit=replace(edit, window_stop=None))
    return pair


def _next(onsets: Sequence[int], onset: int) -> Sequence[int]:
    """Return the first of some ascending onsets that is later, if there is one."""
    after = bisect_right(onsets, onset)
    return onsets[after : after + 1]

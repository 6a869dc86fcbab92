"""The windows that an edit settles: kept ones, ends set by hand, and what these leave of the windows around them.

Shots that follow closely share a window, and what is measured as the decay of one holds the next. So where a shot is
gone, or where a later one ends by somebody's hand, it is over for those before it as well.
"""

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from ..export.edits import Wanted, Wish
from ..model import Event, Rejection, Shot, Source, Window
from ..render import window_between
from ..ruleset import Rules
from ..units import samples_from_ms

DELETED: Final = "deleted by hand"
"""Why a timeline turns down what somebody deleted: so the next round of editing knows of it."""


@dataclass(frozen=True)
class _Left:
    """Where no event is any more: `places`, ascending; `movers` has the ids of events that were moved away from one."""

    places: tuple[int, ...]
    movers: dict[int, str]

    def first(self, soonest: int, wish: Wish) -> int | None:
        """Return the first place from a sample on that the wish itself was not moved away from.

        Whoever moves an event says where it begins; what sounded at its old place may still belong to it.
        """
        later = self.places[bisect_left(self.places, soonest) :]
        return next((place for place in later if self.movers.get(place) != wish.id), None)


def settled_windows(
    wanted: Wanted, shots: Sequence[Shot], source: Source, rules: Rules, *, rejections: Iterable[Rejection]
) -> dict[int, Window]:
    """Return the windows that are settled, by the shot's index; the others are planned.

    The ends of a window are those of its first and its last shot: they stay where that was left alone.
    `rejections` are the original's: what somebody deleted in an earlier round of editing stays gone.
    """
    gap = samples_from_ms(rules.tier.bursts.shortest_gap_ms, source.sample_rate_hz)
    fade_out = samples_from_ms(rules.tier.windows.fade_out_ms, source.sample_rate_hz)
    left = _left(wanted, rejections, gap)
    firsts, lasts = _ends_of(wanted)
    given: dict[int, Window] = {}
    for index, (wish, shot) in enumerate(zip(wanted.wishes, shots, strict=True)):
        if wish.window is not None:
            given[index] = wish.window
            continue
        start, stop = wish.start, wish.stop
        was = wish.was if wish.unmoved else None
        if start is None and was is not None and firsts[was.window] == wish.onset:
            start = was.window.start
        if stop is None:
            own = planned = min(shot.span.stop + fade_out, source.frames)
            if was is not None and lasts[was.window] == wish.onset:
                own = min(was.window.stop, source.frames)
            end = min([own, *_bounds(index, wanted.wishes, left, gap, own)])
            stop = end if end != planned else None
        if start is not None or stop is not None:
            given[index] = window_between(
                shot,
                start=start,
                stop=stop,
                frames=source.frames,
                rate_hz=source.sample_rate_hz,
                rules=rules.tier.windows,
            )
    return given


def _bounds(index: int, wishes: Sequence[Wish], left: _Left, gap: int, planned: int) -> Iterator[int]:
    """Yield the places at which a window that would end at `planned` has to end; wishes are in order of their onsets.

    These are: the shot's own end, where somebody set one or the shot was not moved; the next place that an event has
    left; and the ends of later shots. Nothing counts that is nearer than a gun fires again: it is the same shot.
    """
    wish = wishes[index]
    if (own := _end(wish)) is not None:
        yield own
    soonest = wish.onset + gap
    if (place := left.first(soonest, wish)) is not None:
        yield place
    for other in wishes[index + 1 :]:
        if other.onset >= planned:
            break
        if (end := _end(other)) is not None and end >= soonest:
            yield end


def _end(wish: Wish) -> int | None:
    """Return where a wish ends at the latest: where somebody says, or where it did; None where that is planned."""
    if wish.stop is not None:
        return wish.stop
    return wish.was.window.stop if wish.was is not None and wish.unmoved else None


def _left(wanted: Wanted, rejections: Iterable[Rejection], gap: int) -> _Left:
    """Return the places that events have left, now or in an earlier round, and at which none stands any more."""
    movers = {
        wish.was.onset_sample: wish.id
        for wish in wanted.wishes
        if wish.was is not None and abs(wish.onset - wish.was.onset_sample) > gap
    }
    deleted = {event.onset_sample for event in wanted.deleted}
    deleted |= {rejection.at_sample for rejection in rejections if rejection.reason == DELETED}
    taken = [wish.onset for wish in wanted.wishes]
    return _Left(tuple(sorted(place for place in {*movers, *deleted} if not _stands(place, taken, gap))), movers)


def _stands(place: int, taken: Sequence[int], gap: int) -> bool:
    """Return whether one of some ascending onsets is so near to a place that both are one bang."""
    after = bisect_left(taken, place)
    return any(abs(onset - place) < gap for onset in taken[max(0, after - 1) : after + 1])


def _ends_of(wanted: Wanted) -> tuple[dict[Window, int], dict[Window, int]]:
    """Return the onsets of the first and of the last event of each of the original's windows, whose ends are theirs."""
    originals: list[Event] = [wish.was for wish in wanted.wishes if wish.was is not None]
    firsts: dict[Window, int] = {}
    lasts: dict[Window, int] = {}
    for event in (*originals, *wanted.deleted):
        firsts[event.window] = min(event.onset_sample, firsts.get(event.window, event.onset_sample))
        lasts[event.window] = max(event.onset_sample, lasts.get(event.window, event.onset_sample))
    return firsts, lasts

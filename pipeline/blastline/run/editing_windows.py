"""The windows that an edit settles: kept ones, ends set by hand, and what these leave of the windows around them."""

from collections.abc import Sequence

from ..export.edits import Wanted, Wish
from ..model import Shot, Source, Window
from ..render import window_between
from ..ruleset import Rules
from ..units import samples_from_ms


def settled_windows(wanted: Wanted, shots: Sequence[Shot], source: Source, rules: Rules) -> dict[int, Window]:
    """Return the windows that are settled, by the shot's index; the others are planned."""
    given: dict[int, Window] = {}
    for index, (wish, shot) in enumerate(zip(wanted.wishes, shots, strict=True)):
        if wish.window is not None:
            given[index] = wish.window
            continue
        stop = wish.stop if wish.stop is not None else _bound(wish, shot, wanted, rules, source.sample_rate_hz)
        if wish.start is not None or stop is not None:
            given[index] = window_between(
                shot,
                start=wish.start,
                stop=stop,
                frames=source.frames,
                rate_hz=source.sample_rate_hz,
                rules=rules.tier.windows,
            )
    return given


def _bound(wish: Wish, shot: Shot, wanted: Wanted, rules: Rules, rate_hz: int) -> int | None:
    """Return where a shot's window has to end, None where it would have ended by then anyway.

    Shots that follow closely share a window, and what is measured as the decay of one holds the next. So where one was
    deleted, or somebody has set where a later one ends, it is over there for those before it as well. What begins
    sooner than the rounds of a burst can is no round, but more of the same shot.
    """
    if wish.was is None:
        return None
    soonest = wish.onset + samples_from_ms(rules.tier.bursts.shortest_gap_ms, rate_hz)
    ends = [event.onset_sample for event in wanted.deleted if event.window == wish.was.window]
    ends += [
        other.stop
        for other in wanted.wishes
        if other.stop is not None
        and other.onset > wish.onset
        and other.was is not None
        and other.was.window == wish.was.window
    ]
    bound = min((end for end in ends if end >= soonest), default=None)
    fade_out = samples_from_ms(rules.tier.windows.fade_out_ms, rate_hz)
    return bound if bound is not None and bound < shot.span.stop + fade_out else None

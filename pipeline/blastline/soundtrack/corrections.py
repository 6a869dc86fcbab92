"""What was done about time stamps that do not fit the sound, in words."""

from collections.abc import Iterator, Sequence
from typing import Any

from ..plurals import times
from .placement import Placement


def correction_warnings(placement: Placement[Any], first_stamp_off_s: float, *, is_stamped: bool) -> Iterator[str]:
    """Yield a line for the user of all that was filled in, one of what was dropped, and of stamps that were overruled.

    `first_stamp_off_s` is how far the first stamp of the track was off the others, 0 where it was not; `is_stamped`
    tells whether the format has stamps.
    """
    if placement.gaps:
        unsure = (
            "" if is_stamped else "; the file has no time stamps: if more is missing there, what follows plays early"
        )
        if sum(samples for _, samples in placement.gaps) > placement.sound:
            unsure += (
                "; that is more than there is sound: unless the film is silent there, its header or its time stamps "
                "are damaged, and no shot is in its place"
            )
        yield f"{_told('gap', 'filled with silence', placement.gaps, placement.rate_hz)}{unsure}"
    if placement.overlaps:
        dropped = _told("overlap", "dropped", placement.overlaps, placement.rate_hz)
        yield f"{dropped}: by its time stamps, that sound had been played already"
    if first_stamp_off_s:
        yield f"the first time stamp is {first_stamp_off_s:+.3f} s off those that follow; these were believed"
    if placement.jumps:
        yield _jumps_told(placement.jumps, placement.rate_hz)


def _told(what: str, done: str, found: Sequence[tuple[int, int]], rate_hz: int) -> str:
    total_s, first_s = sum(samples for _, samples in found) / rate_hz, found[0][0] / rate_hz
    count = f"1 {what} was" if len(found) == 1 else f"{len(found)} {what}s were"
    return f"{count} {done}, {total_s:.3f} s in all, first at {first_s:.3f} s"


def _jumps_told(jumps: Sequence[tuple[int, int]], rate_hz: int) -> str:
    (position, jump), rest = jumps[0], jumps[1:]
    total = sum(jump for _, jump in jumps)
    more = f", and {times(len(rest))} more, by {total / rate_hz:+.3f} s in all" if rest else ""
    return (
        f"the time stamps jump by {jump / rate_hz:+.3f} s at {position / rate_hz:.3f} s{more}; "
        "the sound was kept in one piece, so what follows may play beside its picture"
    )

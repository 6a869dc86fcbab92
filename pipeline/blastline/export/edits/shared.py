"""Windows that shots share, in a file whose original is not known: the others tell which end of one was edited.

    shot-0004  |-------------------------|
    shot-0005  |----------|                 set by hand
    shot-0006  |-------------------------|

A timeline's windows are one or apart, so those that begin or end at one sample are one. A label tells only where it
ends: it shares the window inside which it begins.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import msgspec

from .row import Pair, Point


@dataclass(frozen=True)
class _Row:
    """A row, its place among the rows, and its times in samples; an end that it does not tell is None."""

    place: int
    pair: Pair
    onset: int
    start: int | None
    stop: int | None


def with_shared_windows(pairs: Sequence[Pair], *, rate_hz: int) -> list[Pair]:
    """Return the rows, those of a shared window without its ends, but for its first and its last row.

    Their originals have the window that they share. Where all rows of a window agree, they stay as they are, unless
    somebody has put a row with an end of its own between them, or behind them: then that ends the window as well.
    """
    rows = sorted((_row(place, pair, rate_hz) for place, pair in enumerate(pairs)), key=lambda row: row.onset)
    added = [row.onset for row in rows if row.pair.id is None and row.stop is not None]
    found = list(pairs)
    for group in _groups(rows):
        start, stop = _shared_start(group), _shared_stop(group)
        inside = [onset for onset in added if stop is not None and group[0].onset < onset < stop]
        alone = len(group) == 1 and group[0].pair.id is None
        if alone or (len({(row.start, row.stop) for row in group}) == 1 and not inside):
            continue
        fades = next((row.pair.was.window for row in group if row.pair.was is not None), None)
        for row in group:
            edit, was = row.pair.edit, row.pair.was
            if row.start == start and row is not group[0]:
                edit = replace(edit, window_start=None)
            if row.stop == stop and (row is not group[-1] or any(onset > row.onset for onset in inside)):
                edit = replace(edit, window_stop=None)
            if was is not None and fades is not None and start is not None and stop is not None:
                window = msgspec.structs.replace(fades, start=start, stop=stop)
                was = msgspec.structs.replace(was, window=window)
            found[row.place] = replace(row.pair, edit=edit, was=was)
    return found


def _row(place: int, pair: Pair, rate_hz: int) -> _Row:
    edit = pair.edit
    return _Row(
        place,
        pair,
        edit.onset.nearest(rate_hz),
        _sample(edit.window_start, rate_hz),
        _sample(edit.window_stop, rate_hz),
    )


def _sample(point: Point | None, rate_hz: int) -> int | None:
    return None if point is None else point.nearest(rate_hz)


def _groups(rows: Iterable[_Row]) -> Iterator[Sequence[_Row]]:
    """Yield the rows of each window, which several may share; rows are in order of their onsets."""
    group: list[_Row] = []
    for row in rows:
        if group and _shares(row, group):
            group.append(row)
        elif not group or row.onset >= max(each.stop or 0 for each in group):
            yield from [group] if group else []
            group = [row]
    yield from [group] if group else []


def _shares(row: _Row, group: Collection[_Row]) -> bool:
    """Return whether a row is of the window of some earlier ones; a row without an id is somebody's new one."""
    if row.start is None:
        inside = any(each.stop is not None and row.onset < each.stop for each in group)
        return inside and row.stop is not None and row.pair.id is not None
    return any(row.start == each.start or row.stop == each.stop for each in group)


def _shared_start(group: Sequence[_Row]) -> int | None:
    """Return the start that most rows have of those before all onsets; of as many, the last row's."""
    return _most_common([row.start for row in reversed(group) if row.start is not None and row.start <= group[0].onset])


def _shared_stop(group: Sequence[_Row]) -> int | None:
    """Return the end that most rows have of those behind all onsets; of as many, the latest."""
    return _most_common(sorted((row.stop for row in group if row.stop and row.stop > group[-1].onset), reverse=True))


def _most_common(values: Sequence[int]) -> int | None:
    """Return the value that is there most often, of as many the first; None where there is none."""
    return Counter(values).most_common(1)[0][0] if values else None

"""How a candidate stands among its neighbours: a shot towers or comes in bursts, a machine repeats itself for ever."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .bandshape import ATTACK, LOWEST_DB

# how far the neighbourhood reaches, in milliseconds
PAST_MS, FUTURE_MS = 3000.0, 2500.0
SHAPE_SEGMENTS = 5  # attack and the 30 ms after it
LEVEL_STEPS_DB = (-12.0, -6.0, -3.0)
RIVAL_DB = 9.0  # a neighbour this much weaker is no rival
ALIKE_DB = 5.0  # attacks whose shapes differ by less, rms over bands and segments, are alike
FARTHEST_DB = 50.0  # what stands for the distance where there is no neighbour
RUN_GAP_MS = 300.0
BURST_ROUNDS, BURST_MS = 8, 700.0
"""A burst, as most are: how many are alike before or after a candidate, and for how long, where no more is to count."""
_AT_ONCE = 128  # candidates that are held against their neighbours together
_SLACK_MS = 1.0


def neighbourhood_names() -> tuple[str, ...]:
    """Return the names of the columns of `neighbourhood`, in order."""
    names = ["louder_past_db", "louder_future_db", "previous_ms", "next_ms"]
    names += ["previous_db", "next_db", "likeness_previous"]
    names += [f"{side}_within{level:g}dB" for side in ("past", "future") for level in LEVEL_STEPS_DB]
    names += ["like_past", "like_future", "rhythm", "like_previous_ms", "like_next_ms"]
    return (*names, "run_before_ms", "run_after_ms")


def neighbourhood(
    places: NDArray[np.intp], levels: NDArray[np.float64], wanted: NDArray[np.intp], rate_hz: int
) -> NDArray[np.float64]:
    """Return how the candidates with the ascending indices `wanted` stand among all of the seconds around them.

    Shape (wanted, names), in the order of `neighbourhood_names`. `places` are the sample indices of all n candidates,
    ascending, `levels` their `band_levels`, shape (n, BANDS + 1, segments).
    """
    at_ms = places.astype(np.float64) * (1000.0 / rate_hz)
    rows = [np.zeros((0, len(neighbourhood_names())))]
    for some in (wanted[first : first + _AT_ONCE] for first in range(0, wanted.size, _AT_ONCE)):
        firsts = np.searchsorted(at_ms, at_ms[some] - PAST_MS - _SLACK_MS)
        stops = np.searchsorted(at_ms, at_ms[some] + FUTURE_MS + _SLACK_MS)
        around = slice(firsts[0], stops[-1])
        rows.append(_standing(at_ms[around], levels[around], *(ends - firsts[0] for ends in (some, firsts, stops))))
    return np.concatenate(rows)


def as_in_a_burst(neighbourhoods: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rows of `neighbourhood` as if what goes on before and after were no more than a burst."""
    columns = {
        **dict.fromkeys(("run_before_ms", "run_after_ms"), BURST_MS),
        **dict.fromkeys(("like_past", "like_future"), BURST_ROUNDS),
        **{f"{side}_within{level:g}dB": BURST_ROUNDS for side in ("past", "future") for level in LEVEL_STEPS_DB},
    }
    most = np.array([columns.get(name, np.inf) for name in neighbourhood_names()])
    return np.asarray(np.minimum(neighbourhoods, most), np.float64)


def _standing(
    at_ms: NDArray[np.float64],
    levels: NDArray[np.float64],
    wanted: NDArray[np.intp],
    firsts: NDArray[np.intp],
    stops: NDArray[np.intp],
) -> NDArray[np.float64]:
    """Return how some candidates stand among their neighbours, by the times and levels of all.

    Each has a row of neighbours in time, those from its index in `firsts` to before that in `stops`.
    """
    neighbours = firsts[:, None] + np.arange((stops - firsts).max())
    lacking = neighbours >= stops[:, None]
    neighbours[lacking] = 0
    times = at_ms[neighbours]
    gap_ms = times - at_ms[wanted, None]
    gap_ms[lacking] = np.inf
    attack_db = levels[:, -1, ATTACK]
    level = attack_db[neighbours] - attack_db[wanted, None]
    before = (gap_ms < 0.0) & (gap_ms >= -PAST_MS)
    after = (gap_ms > 0.0) & (gap_ms <= FUTURE_MS)
    shapes = np.maximum(levels[:, :-1, ATTACK : ATTACK + SHAPE_SEGMENTS] - attack_db[:, None, None], LOWEST_DB)
    distance = _distances(shapes.reshape(at_ms.size, shapes.shape[1] * shapes.shape[2]), wanted, neighbours)
    alike = (distance < ALIKE_DB) & (np.abs(level) < RIVAL_DB)
    alike_before, alike_after, rival = alike & before, alike & after, level >= -RIVAL_DB
    previous, following = _last(before & rival), _first(after & rival)
    loud = [level >= bound for bound in LEVEL_STEPS_DB]
    columns = [
        np.where(before, level, LOWEST_DB).max(axis=1, initial=LOWEST_DB),
        np.where(after, level, LOWEST_DB).max(axis=1, initial=LOWEST_DB),
        -_picked(gap_ms, previous, -PAST_MS),
        _picked(gap_ms, following, FUTURE_MS),
        _picked(level, previous, LOWEST_DB),
        _picked(level, following, LOWEST_DB),
        _picked(distance, previous, FARTHEST_DB),
        *(np.count_nonzero(side & than, axis=1) for side in (before, after) for than in loud),
        np.count_nonzero(alike_before, axis=1),
        np.count_nonzero(alike_after, axis=1),
        *_run(times, alike_before | alike_after | (gap_ms == 0.0), wanted - firsts),
    ]
    return np.stack(columns, axis=1).astype(np.float64)


def _distances(shapes: NDArray[np.float64], own: NDArray[np.intp], neighbours: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the rms difference of every own shape to those of its neighbours, in dB, shape as `neighbours`."""
    squares = np.sum(shapes**2, axis=1)
    products = np.take_along_axis(shapes[own] @ shapes.T, neighbours, axis=1)
    apart = squares[own, None] + squares[neighbours] - 2.0 * products
    return np.asarray(np.sqrt(np.maximum(apart, 0.0) / shapes.shape[1]), np.float64)


def _last(which: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the last true column of each row, -1 where there is none."""
    return np.asarray(np.where(which.any(axis=1), which.shape[1] - 1 - which[:, ::-1].argmax(axis=1), -1), np.intp)


def _first(which: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the first true column of each row, -1 where there is none."""
    return np.asarray(np.where(which.any(axis=1), which.argmax(axis=1), -1), np.intp)


def _picked(values: NDArray[np.float64], column: NDArray[np.intp], otherwise: float) -> NDArray[np.float64]:
    """Return one value of each row, `otherwise` where the column is -1."""
    return np.where(column >= 0, values[np.arange(values.shape[0]), column], otherwise)


def _run(
    times: NDArray[np.float64], alike: NDArray[np.bool_], own: NDArray[np.intp]
) -> tuple[NDArray[np.float64], ...]:
    """Return of each row of times, ascending, how even its alike candidates are, and the run around its own column.

    That is the coefficient of variation of their gaps, 2 at most and for fewer than three; the gaps from the own
    candidate, which is alike, to those before and after; and how long the run goes on in either direction. A run ends
    where the next alike candidate is more than `RUN_GAP_MS` away: a burst is short, a machine goes on.
    """
    row, column = np.nonzero(alike)  # row by row: few of many are alike
    at = times[row, column]
    gap = np.where(np.diff(row, prepend=-1) == 0, np.diff(at, prepend=0.0), np.inf)  # to the one before in the row
    inner = np.isfinite(gap)
    count = _row_sums(inner, row, own.size)
    mean = _row_sums(np.where(inner, gap, 0.0), row, own.size) / np.maximum(count, 1.0)
    spread = np.sqrt(_row_sums(np.where(inner, gap - mean[row], 0.0) ** 2, row, own.size) / np.maximum(count, 1.0))
    variation = np.where(count >= 3, np.minimum(2.0, spread / np.maximum(mean, 1e-9)), 2.0)
    index = np.arange(row.size)
    gap_on = np.append(gap[1:], np.inf)
    run_from = np.maximum.accumulate(np.where(gap > RUN_GAP_MS, index, 0))
    run_to = np.minimum.accumulate(np.where(gap_on > RUN_GAP_MS, index, row.size)[::-1])[::-1]
    me = np.flatnonzero(column == own[row])
    gaps = (np.minimum(side[me], RUN_GAP_MS) for side in (gap, gap_on))
    return variation, *gaps, at[me] - at[run_from[me]], at[run_to[me]] - at[me]


def _row_sums(values: NDArray[Any], row: NDArray[np.intp], rows: int) -> NDArray[np.float64]:
    """Return the sum of the values of each row."""
    return np.asarray(np.bincount(row, weights=values, minlength=rows), np.float64)

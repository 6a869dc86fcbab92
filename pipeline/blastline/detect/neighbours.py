"""How a candidate stands among its neighbours: a shot towers or comes in bursts, a machine repeats itself for ever."""

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
_AT_ONCE = 64  # candidates that are held against one set of neighbours
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
        nearest_ms = at_ms[some[0]] - PAST_MS - _SLACK_MS, at_ms[some[-1]] + FUTURE_MS + _SLACK_MS
        first, stop = np.searchsorted(at_ms, nearest_ms)
        rows.append(_standing(at_ms[first:stop], levels[first:stop], some - first))
    return np.concatenate(rows)


def _standing(at_ms: NDArray[np.float64], levels: NDArray[np.float64], wanted: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return how some candidates stand among all of the last three seconds and the next ones, by times and levels."""
    attack_db = levels[:, -1, ATTACK]
    shapes = np.maximum(levels[:, :-1, ATTACK : ATTACK + SHAPE_SEGMENTS] - attack_db[:, None, None], LOWEST_DB)
    gap_ms = at_ms[None, :] - at_ms[wanted, None]
    level = attack_db[None, :] - attack_db[wanted, None]
    before = (gap_ms < 0.0) & (gap_ms >= -PAST_MS)
    after = (gap_ms > 0.0) & (gap_ms <= FUTURE_MS)
    distance = _distances(shapes.reshape(at_ms.size, shapes.shape[1] * shapes.shape[2]), wanted)
    alike = (distance < ALIKE_DB) & (np.abs(level) < RIVAL_DB)
    run = (alike & (before | after)) | (gap_ms == 0.0)
    previous = _last(before & (level >= -RIVAL_DB))
    following = _last((after & (level >= -RIVAL_DB))[:, ::-1])
    following = np.where(following >= 0, at_ms.size - 1 - following, -1)
    columns = [
        np.where(before, level, LOWEST_DB).max(axis=1, initial=LOWEST_DB),
        np.where(after, level, LOWEST_DB).max(axis=1, initial=LOWEST_DB),
        -_picked(gap_ms, previous, -PAST_MS),
        _picked(gap_ms, following, FUTURE_MS),
        _picked(level, previous, LOWEST_DB),
        _picked(level, following, LOWEST_DB),
        _picked(distance, previous, FARTHEST_DB),
        *((side & (level >= bound)).sum(axis=1) for side in (before, after) for bound in LEVEL_STEPS_DB),
        (alike & before).sum(axis=1),
        (alike & after).sum(axis=1),
        _gap_variation(at_ms, run),
        *_run(at_ms, run, wanted),
    ]
    return np.stack(columns, axis=1).astype(np.float64)


def _distances(shapes: NDArray[np.float64], own: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the rms difference of every own shape to every shape, in dB."""
    squares = np.sum(shapes**2, axis=1)
    apart = squares[own, None] + squares[None, :] - 2.0 * shapes[own] @ shapes.T
    return np.asarray(np.sqrt(np.maximum(apart, 0.0) / shapes.shape[1]), np.float64)


def _last(which: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the last true column of each row, -1 where there is none."""
    return np.asarray(np.where(which, np.arange(which.shape[1]), -1).max(axis=1, initial=-1), np.intp)


def _picked(values: NDArray[np.float64], column: NDArray[np.intp], otherwise: float) -> NDArray[np.float64]:
    """Return one value of each row, `otherwise` where the column is -1."""
    if values.shape[1] == 0:
        return np.full(values.shape[0], otherwise)
    return np.where(column >= 0, values[np.arange(values.shape[0]), column], otherwise)


def _gap_variation(at_ms: NDArray[np.float64], alike: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the coefficient of variation of the gaps between alike candidates, 2 at most and for fewer than three."""
    latest = np.maximum.accumulate(np.where(alike, at_ms, -np.inf), axis=1)
    earlier = np.concatenate([np.full((alike.shape[0], 1), -np.inf), latest[:, :-1]], axis=1)
    counted = alike & np.isfinite(earlier)
    gaps = np.where(counted, at_ms - np.where(counted, earlier, 0.0), 0.0)
    count = counted.sum(axis=1)
    mean = gaps.sum(axis=1) / np.maximum(count, 1)
    spread = np.sqrt((np.where(counted, gaps - mean[:, None], 0.0) ** 2).sum(axis=1) / np.maximum(count, 1))
    return np.where(count >= 3, np.minimum(2.0, spread / np.maximum(mean, 1e-9)), 2.0)


def _run(
    at_ms: NDArray[np.float64], alike: NDArray[np.bool_], own: NDArray[np.intp]
) -> tuple[NDArray[np.float64], ...]:
    """Return the gaps to the alike candidates before and after, and how long the run goes on in either direction.

    A run ends where the next alike candidate is more than `RUN_GAP_MS` away: a burst is short, a machine goes on.
    """
    rows = np.arange(own.size)
    sides = []
    for times, which, place in ((at_ms, alike, own), (-at_ms[::-1], alike[:, ::-1], at_ms.size - 1 - own)):
        latest = np.maximum.accumulate(np.where(which, times, -np.inf), axis=1)
        earlier = np.concatenate([np.full((own.size, 1), -np.inf), latest[:, :-1]], axis=1)
        starts = which & (times - earlier > RUN_GAP_MS)
        start = np.maximum.accumulate(np.where(starts, times, -np.inf), axis=1)
        gap = np.minimum(times[place] - earlier[rows, place], RUN_GAP_MS)
        sides.append((gap, times[place] - start[rows, place]))
    (gap_back, run_back), (gap_on, run_on) = sides
    return gap_back, gap_on, run_back, run_on

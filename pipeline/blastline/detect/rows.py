"""What comes again and again and is no gun: steps and blows at an even pace, machines that go on, and loops."""

import numpy as np
from numpy.typing import NDArray

from ..ruleset import BurstRules, RowRules
from ..units import samples_from_ms, samples_from_s
from .backdrop import bits_apart

_SAME_LAG_MS = 1.0
_NEAR_TURNS, _FEWEST_TURNS = 4, 2


def in_even_rows(
    onsets: NDArray[np.intp], sure: NDArray[np.bool_], *, rate_hz: int, rules: RowRules
) -> NDArray[np.bool_]:
    """Return which onsets, ascending, belong to an even row of which fewer than half are sure by themselves.

    Somebody may fire at an even pace, and then most shots are sure. Steps and blows are so now and then, and would take
    the others of their row along.
    """
    found = np.zeros(onsets.size, bool)
    shortest, longest = (samples_from_ms(ms, rate_hz) for ms in (rules.shortest_gap_ms, rules.longest_gap_ms))
    for row in _even_rows(onsets, shortest, longest, rules.unevenness):
        if row.size >= rules.fewest and 2 * sure[row].sum() < row.size:
            found[row] = True
    return found


def in_endless_fire(
    onsets: NDArray[np.intp], sure: NDArray[np.bool_], *, rate_hz: int, rules: BurstRules
) -> NDArray[np.bool_]:
    """Return which onsets, ascending, belong to a run at a gun's pace that goes on as no gun does.

    More than a magazine holds, half of the gaps near their median, and fewer than half of its sounds sure by
    themselves: so do jackhammers and engines. Several guns at once may go on for as long, but keep no pace.
    """
    found = np.zeros(onsets.size, bool)
    longest = samples_from_ms(rules.longest_gap_ms, rate_hz)
    for run in runs_of(onsets, longest):
        if run.size > rules.most_unsure and 2 * sure[run].sum() < run.size:
            gaps = np.diff(onsets[run])
            usual = np.median(gaps)
            found[run] = 2 * np.sum(np.abs(gaps - usual) <= rules.unevenness * usual) >= gaps.size
    return found


def in_loops(
    onsets: NDArray[np.intp],
    peaks_dbfs: NDArray[np.float64],
    sure: NDArray[np.bool_],
    backdrops: NDArray[np.int64],
    *,
    rate_hz: int,
    rules: RowRules,
) -> NDArray[np.bool_]:
    """Return which onsets, ascending, turn with a loop of ambience: they come again with it, to the ms and as loud.

    That there is a loop is told by what comes again after the same time, beyond an even row's gaps and up to
    `longest_loop_s`, `fewest_turns` times in all and each time with the same backdrop (below 0: unknown). Somebody may
    fire like clockwork, but nobody makes the wind do so. What turns twice and more within four turns belongs to the
    loop, unless it is sure each time.
    """
    found = np.zeros(onsets.size, bool)
    if onsets.size < rules.fewest_turns:
        return found
    chains = _chains(onsets, rate_hz=rate_hz, rules=rules)
    known = (backdrops[chains] >= 0).all(axis=0)
    alike = bits_apart(backdrops[chains[1:]], backdrops[chains[:-1]]) <= rules.backdrop_bits
    loops = chains[:, known & alike.all(axis=0)]
    turns = (onsets[loops[-1]] - onsets[loops[0]]) / (rules.fewest_turns - 1)
    for turn in np.unique(np.round(turns)).tolist():
        found |= _turning(onsets, peaks_dbfs, sure, turn, rate_hz=rate_hz, rules=rules)
    return found


def _chains(onsets: NDArray[np.intp], *, rate_hz: int, rules: RowRules) -> NDArray[np.intp]:
    """Return in columns which onsets follow each other after the same time, `fewest_turns` in each."""
    shortest, longest = samples_from_ms(rules.longest_gap_ms, rate_hz), samples_from_s(rules.longest_loop_s, rate_hz)
    start, stop = np.searchsorted(onsets, onsets + shortest), np.searchsorted(onsets, onsets + longest, side="right")
    first = np.repeat(np.arange(onsets.size), stop - start)
    second = np.concatenate([np.arange(*ends) for ends in zip(start, stop, strict=True)]).astype(np.intp)
    lag, chains = onsets[second] - onsets[first], np.stack([first, second])
    for times in range(2, rules.fewest_turns):
        due = onsets[chains[0]] + times * lag
        there = _nearest(onsets, due)
        again = np.abs(onsets[there] - due) <= samples_from_ms(_SAME_LAG_MS, rate_hz)
        chains, lag = np.concatenate([chains, there[None]])[:, again], lag[again]
    return chains


def _turning(
    onsets: NDArray[np.intp],
    peaks_dbfs: NDArray[np.float64],
    sure: NDArray[np.bool_],
    turn: float,
    *,
    rate_hz: int,
    rules: RowRules,
) -> NDArray[np.bool_]:
    """Return which onsets come again with a loop of that length in samples, twice and more within four turns."""
    turns = turn * np.array([*range(-_NEAR_TURNS, 0), *range(1, _NEAR_TURNS + 1)])
    due = onsets[:, None] + np.round(turns).astype(np.intp)
    there = _nearest(onsets, due)
    again = np.abs(onsets[there] - due) <= samples_from_ms(_SAME_LAG_MS, rate_hz)
    again &= np.abs(peaks_dbfs[there] - peaks_dbfs[:, None]) <= rules.loop_level_db
    sure_each_time = sure & (sure[there] | ~again).all(axis=1)
    return np.asarray((again.sum(axis=1) >= _FEWEST_TURNS) & ~sure_each_time)


def runs_of(onsets: NDArray[np.intp], longest_gap: int) -> list[NDArray[np.intp]]:
    """Return the runs of onsets, ascending, that follow each other within a gap; one alone is a run, too."""
    return np.split(np.arange(onsets.size), np.flatnonzero(np.diff(onsets) > longest_gap) + 1)


def _nearest(onsets: NDArray[np.intp], places: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return which of the onsets, ascending, is nearest to each place."""
    after = np.clip(np.searchsorted(onsets, places), 1, onsets.size - 1)
    return np.asarray(np.where(places - onsets[after - 1] <= onsets[after] - places, after - 1, after), np.intp)


def _even_rows(onsets: NDArray[np.intp], shortest: int, longest: int, unevenness: float) -> list[NDArray[np.intp]]:
    """Return the longest rows of three and more whose gaps lie in a range, each near enough to the one before."""
    gaps = np.diff(onsets)
    paced = (gaps >= shortest) & (gaps <= longest)
    goes_on = paced[1:] & paced[:-1] & (np.abs(np.diff(gaps)) <= unevenness * gaps[:-1])
    rows = np.split(np.arange(gaps.size), np.flatnonzero(~goes_on) + 1)
    return [np.arange(row[0], row[-1] + 2) for row in rows if row.size >= 2]

"""Even rows: what comes again and again at one pace, as steps and blows do and, faster, automatic fire."""

import numpy as np
from numpy.typing import NDArray

from ..ruleset import BurstRules, RowRules
from ..units import samples_from_ms


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


def in_even_fire(
    onsets: NDArray[np.intp], surety: NDArray[np.float64], least: float, *, rate_hz: int, rules: BurstRules
) -> NDArray[np.bool_]:
    """Return which onsets, ascending, belong to a row as even and fast as automatic fire whose mean surety is enough.

    A weapon's action keeps its pace within a few percent. So many sounds at one are no chance, and their mean says more
    of their kind than each of them.
    """
    found = np.zeros(onsets.size, bool)
    shortest, longest = (samples_from_ms(ms, rate_hz) for ms in (rules.shortest_gap_ms, rules.longest_gap_ms))
    for row in _even_rows(onsets, shortest, longest, rules.unevenness):
        if row.size >= rules.fewest_even and surety[row].mean() >= least:
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
    for run in np.split(np.arange(onsets.size), np.flatnonzero(np.diff(onsets) > longest) + 1):
        if run.size > rules.most_unsure and 2 * sure[run].sum() < run.size:
            gaps = np.diff(onsets[run])
            usual = np.median(gaps)
            found[run] = 2 * np.sum(np.abs(gaps - usual) <= rules.unevenness * usual) >= gaps.size
    return found


def _even_rows(onsets: NDArray[np.intp], shortest: int, longest: int, unevenness: float) -> list[NDArray[np.intp]]:
    """Return the longest rows of three and more whose gaps lie in a range, each near enough to the one before."""
    gaps = np.diff(onsets)
    paced = (gaps >= shortest) & (gaps <= longest)
    goes_on = paced[1:] & paced[:-1] & (np.abs(np.diff(gaps)) <= unevenness * gaps[:-1])
    rows = np.split(np.arange(gaps.size), np.flatnonzero(~goes_on) + 1)
    return [np.arange(row[0], row[-1] + 2) for row in rows if row.size >= 2]

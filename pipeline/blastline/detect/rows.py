"""What comes again and again and is no gun: steps and blows at an even pace, and machines that go on."""

import numpy as np
from numpy.typing import NDArray

from ..ruleset import BurstRules, RowRules
from ..units import samples_from_ms


def in_even_rows(
    onsets: NDArray[np.intp], sure: NDArray[np.bool_], *, rate_hz: int, rules: RowRules
) -> NDArray[np.bool_]:
    """Return which of n onsets, ascending, belong to an even row of which fewer than half are sure, shape (n,).

    Somebody may fire at an even pace, and then most shots are sure, each by itself or the row as a whole. Steps and
    blows are so now and then, and would take the others of their row along.
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
    """Return which of n onsets, ascending, belong to a run at a gun's pace that goes on as no gun does, shape (n,).

    More than a magazine holds, half of the gaps near their median, and fewer than half of its sounds sure, alone or as
    sustained fire: so do jackhammers and engines. Several guns at once may go on for as long, but keep no pace.
    """
    found = np.zeros(onsets.size, bool)
    longest = samples_from_ms(rules.longest_gap_ms, rate_hz)
    for run in runs_of(onsets, longest):
        if run.size > rules.most_unsure and 2 * sure[run].sum() < run.size:
            gaps = np.diff(onsets[run])
            usual = np.median(gaps)
            found[run] = 2 * np.sum(np.abs(gaps - usual) <= rules.unevenness * usual) >= gaps.size
    return found


def runs_of(onsets: NDArray[np.intp] | NDArray[np.float64], longest_gap: float) -> list[NDArray[np.intp]]:
    """Return the runs of onsets, ascending, that follow each other within a gap, as indices; one alone is a run, too.

    Of no onsets it is one empty run.
    """
    return np.split(np.arange(onsets.size), np.flatnonzero(np.diff(onsets) > longest_gap) + 1)


def _even_rows(onsets: NDArray[np.intp], shortest: int, longest: int, unevenness: float) -> list[NDArray[np.intp]]:
    """Return the longest rows of three and more whose gaps lie in a range, each near enough to the one before."""
    gaps = np.diff(onsets)
    paced = (gaps >= shortest) & (gaps <= longest)
    goes_on = paced[1:] & paced[:-1] & (np.abs(np.diff(gaps)) <= unevenness * gaps[:-1])
    rows = np.split(np.arange(gaps.size), np.flatnonzero(~goes_on) + 1)
    return [np.arange(row[0], row[-1] + 2) for row in rows if row.size >= 2]

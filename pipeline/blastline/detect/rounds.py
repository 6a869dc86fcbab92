"""What comes as fast as a gun fires: runs that are sure as a whole, a burst's other rounds; and shots in twos."""

import numpy as np
from numpy.typing import NDArray

from ..ruleset import BurstRules
from ..units import samples_from_ms
from .rows import runs_of


def in_a_run(
    onsets: NDArray[np.intp],
    probability: NDArray[np.float64],
    least: NDArray[np.float64],
    *,
    rate_hz: int,
    rules: BurstRules,
) -> NDArray[np.bool_]:
    """Return which candidates belong to a run that is sure as a whole; of those too near each other one counts.

    Gaps are those between the ones that count, so the runs are not those of `runs_of`.
    """
    shortest, longest = (samples_from_ms(ms, rate_hz) for ms in (rules.shortest_gap_ms, rules.longest_gap_ms))
    runs: list[list[int]] = []
    for place in np.flatnonzero(probability >= least).tolist():
        gap = onsets[place] - onsets[runs[-1][-1]] if runs else longest + 1
        if gap > longest:
            runs.append([place])
        elif gap >= shortest:
            runs[-1].append(place)
        elif probability[place] > probability[runs[-1][-1]]:
            before = runs[-1][:-1]
            if not before or onsets[place] - onsets[before[-1]] <= longest:
                runs[-1][-1] = place
    found = np.zeros(onsets.size, bool)
    found[[place for run in runs if len(run) >= rules.fewest_shots for place in run]] = True
    return found


def before_a_round(
    onsets: NDArray[np.intp], rounds: NDArray[np.bool_], *, rate_hz: int, rules: BurstRules
) -> NDArray[np.bool_]:
    """Return which onsets, ascending, a likely round follows as fast as a gun fires, shape (n,)."""
    shortest, longest = (samples_from_ms(ms, rate_hz) for ms in (rules.shortest_gap_ms, rules.longest_gap_ms))
    likely = onsets[rounds]
    first = np.searchsorted(likely, onsets + shortest)
    return np.asarray(np.searchsorted(likely, onsets + longest, side="right") > first)


def with_rounds(
    onsets: NDArray[np.intp],
    believed: NDArray[np.bool_],
    rounds: NDArray[np.bool_],
    peaks_dbfs: NDArray[np.float64],
    *,
    rate_hz: int,
    rules: BurstRules,
) -> NDArray[np.bool_]:
    """Return the believed with the rounds of bursts that have two of them, as far as those are about as loud."""
    shortest, longest = (samples_from_ms(ms, rate_hz) for ms in (rules.shortest_gap_ms, rules.longest_gap_ms))
    members = np.flatnonzero(believed | rounds)
    kept = believed.copy()
    for run in runs_of(onsets[members], longest):
        burst = members[run]
        sure = burst[believed[burst]]
        if sure.size and onsets[sure[-1]] - onsets[sure[0]] >= shortest:
            kept[burst] |= peaks_dbfs[burst] > np.median(peaks_dbfs[sure]) - rules.echo_drop_db
    return kept


def in_pairs(
    onsets: NDArray[np.intp],
    peaks_dbfs: NDArray[np.float64],
    sure: NDArray[np.bool_],
    perhaps: NDArray[np.bool_],
    *,
    longest_ms: float,
    rate_hz: int,
    rules: BurstRules,
) -> NDArray[np.bool_]:
    """Return which of `perhaps` come so soon before or after a sure one, about as loud, shape (n,).

    What is softer is more likely an echo, or a hand at the gun.
    """
    shortest, longest = samples_from_ms(rules.shortest_gap_ms, rate_hz), samples_from_ms(longest_ms, rate_hz)
    found = np.zeros(onsets.size, np.bool_)
    for place in np.flatnonzero(perhaps & ~sure).tolist():
        at = onsets[place]
        begin, end = np.searchsorted(onsets, (at - longest, at + longest + 1))
        partners = sure[begin:end] & (np.abs(onsets[begin:end] - at) >= shortest)
        found[place] = (partners & (peaks_dbfs[place] > peaks_dbfs[begin:end] - rules.echo_drop_db)).any()
    return found

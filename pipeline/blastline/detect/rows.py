"""Even rows: what comes again and again at one pace, slower than automatic fire of a weapon that a person carries."""

import numpy as np
from numpy.typing import NDArray

from ..ruleset import RowRules
from ..units import samples_from_ms


def in_even_rows(
    onsets: NDArray[np.intp], sure: NDArray[np.bool_], *, rate_hz: int, rules: RowRules
) -> NDArray[np.bool_]:
    """Return which onsets, ascending, belong to an even row of which fewer than half are sure by themselves.

    Somebody may fire at an even pace, and then most shots are sure. Steps and blows are so now and then, and would take
    the others of their row along.
    """
    found = np.zeros(onsets.size, bool)
    if onsets.size < rules.fewest:
        return found
    shortest, longest = (samples_from_ms(ms, rate_hz) for ms in (rules.shortest_gap_ms, rules.longest_gap_ms))
    gaps = np.diff(onsets)
    paced = (gaps >= shortest) & (gaps <= longest)
    goes_on = paced[1:] & paced[:-1] & (np.abs(np.diff(gaps)) <= rules.unevenness * gaps[:-1])
    for row in np.split(np.arange(gaps.size), np.flatnonzero(~goes_on) + 1):
        members = np.arange(row[0], row[-1] + 2)
        if members.size >= rules.fewest and 2 * sure[members].sum() < members.size:
            found[members] = True
    return found

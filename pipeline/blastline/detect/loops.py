"""Loops of ambience: what turns with them comes again to the millisecond, as loud, with what is around it.

    |  bed 1  .  x   |  bed 1  .  x   |  bed 1  .  x   |

Somebody may fire like clockwork, but nobody makes the wind do so; and over such a bed somebody may fire as well.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..ruleset import RowRules
from ..units import samples_from_ms, samples_from_s
from .backdrop import hamming_distance

_SAME_LAG_MS = 1.0
_NEAR_TURNS = 4  # within so many turns to either side a candidate has to come again
_FEWEST_TURNS = 2  # and so often
_AT_ONCE = 256  # candidates that are held against the others: an hour of a machine has millions of pairs


@dataclass(frozen=True, eq=False)
class LoopCandidates:
    """Candidates, by onset: how loud, whether sure by themselves, what is heard before each, and its own sound.

    Backdrops below 0 are unknown. `sounds` has shape (n, levels); those that are NaN are like no other.
    """

    onsets: NDArray[np.intp]
    peaks_dbfs: NDArray[np.float64]
    sure: NDArray[np.bool_]
    backdrops: NDArray[np.int64]
    sounds: NDArray[np.float64]


def in_loops(heard: LoopCandidates, *, rate_hz: int, rules: RowRules) -> NDArray[np.bool_]:
    """Return which of n candidates turn with a loop of ambience, shape (n,).

    That there is a loop is told by what comes again after the same time, beyond an even row's gaps and up to
    `longest_loop_s`, `fewest_turns` times in all and each time with the same backdrop. What turns twice and more within
    four turns, as loud and with the same sound, belongs to the loop, unless it is sure each time.
    """
    onsets = heard.onsets
    found = np.zeros(onsets.size, bool)
    if onsets.size < rules.fewest_turns:
        return found
    parts = [slice(first, first + _AT_ONCE) for first in range(0, onsets.size, _AT_ONCE)]
    lengths = [_loop_lengths(heard, part, rate_hz=rate_hz, rules=rules) for part in parts]
    for turn in np.unique(np.concatenate(lengths)).tolist():
        for part in parts:
            found[part] |= _turning(heard, part, turn, rate_hz=rate_hz, rules=rules)
    return found


def _loop_lengths(heard: LoopCandidates, part: slice, *, rate_hz: int, rules: RowRules) -> NDArray[np.float64]:
    """Return how long the loops are, in samples, that are told by what begins with some candidates."""
    onsets = heard.onsets
    chains = _chains(onsets, part, rate_hz=rate_hz, rules=rules)
    known = (heard.backdrops[chains] >= 0).all(axis=0)
    alike = hamming_distance(heard.backdrops[chains[1:]], heard.backdrops[chains[:-1]]) <= rules.backdrop_bits
    loops = chains[:, known & alike.all(axis=0)]
    return np.unique(np.round((onsets[loops[-1]] - onsets[loops[0]]) / (rules.fewest_turns - 1)))


def _chains(onsets: NDArray[np.intp], part: slice, *, rate_hz: int, rules: RowRules) -> NDArray[np.intp]:
    """Return in columns which onsets follow one of a part after the same time each, `fewest_turns` in all."""
    shortest, longest = samples_from_ms(rules.longest_gap_ms, rate_hz), samples_from_s(rules.longest_loop_s, rate_hz)
    own = onsets[part]
    start, stop = np.searchsorted(onsets, own + shortest), np.searchsorted(onsets, own + longest, side="right")
    first = np.repeat(np.arange(onsets.size)[part], stop - start)
    second = np.concatenate([np.arange(*ends) for ends in zip(start, stop, strict=True)]).astype(np.intp)
    lag, chains = onsets[second] - onsets[first], np.stack([first, second])
    for times in range(2, rules.fewest_turns):
        due = onsets[chains[0]] + times * lag
        there = _nearest(onsets, due)
        again = np.abs(onsets[there] - due) <= samples_from_ms(_SAME_LAG_MS, rate_hz)
        chains, lag = np.concatenate([chains, there[None]])[:, again], lag[again]
    return chains


def _turning(heard: LoopCandidates, part: slice, turn: float, *, rate_hz: int, rules: RowRules) -> NDArray[np.bool_]:
    """Return which of a part come again with a loop of that length in samples, twice and more within four turns."""
    turns = turn * np.array([*range(-_NEAR_TURNS, 0), *range(1, _NEAR_TURNS + 1)])
    due = heard.onsets[part, None] + np.round(turns).astype(np.intp)
    there = _nearest(heard.onsets, due)
    again = np.abs(heard.onsets[there] - due) <= samples_from_ms(_SAME_LAG_MS, rate_hz)
    again &= np.abs(heard.peaks_dbfs[there] - heard.peaks_dbfs[part, None]) <= rules.loop_level_db
    again &= np.abs(heard.sounds[there] - heard.sounds[part, None]).mean(axis=2) <= rules.loop_sound_db
    sure_each_time = heard.sure[part] & (heard.sure[there] | ~again).all(axis=1)
    return np.asarray((again.sum(axis=1) >= _FEWEST_TURNS) & ~sure_each_time)


def _nearest(onsets: NDArray[np.intp], places: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return which of the onsets, ascending, is nearest to each place."""
    after = np.clip(np.searchsorted(onsets, places), 1, onsets.size - 1)
    return np.asarray(np.where(places - onsets[after - 1] <= onsets[after] - places, after - 1, after), np.intp)

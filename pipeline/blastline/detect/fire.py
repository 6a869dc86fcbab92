"""Even fire: sounds at a gun's pace, or at that of a finger, even and equally loud, judged together.

    |   |   |   |   |      one pace, within a few percent from gap to gap, peaks within 3 dB
      .       .            what sounds between, an echo or something else, does not break the row

A row is as many looks at one gun, or at one machine, so its mean odds say more than each sound's own: all of it is fire
or none, since a gun that fires on time skips no round. Somebody who fires shot by shot keeps a slower pace, at which
steps and hammers come as well: there the networks alone are asked, and have to be as sure as of a single shot. The
screen, which hears what is around, takes any such row for a machine.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..model import EvenRow
from ..ruleset import BurstRules, QualityRules, VerifyRules
from ..units import samples_from_ms
from .verify import LogOdds, log_odds_of

_MOST_IN_ROW = 256
"""A longer row is taken in pieces, which say as much: hours of a machine take no longer than they are long."""

_AT_ONCE = 1024  # sounds whose pairs are held together


@dataclass(frozen=True, eq=False)
class ScoredCandidates:
    """The candidates of a chunk or a film that the networks judged, in order: onsets, peaks, log-odds; shape (n,)."""

    onsets: NDArray[np.intp]
    peaks_dbfs: NDArray[np.float64]
    odds: LogOdds

    @classmethod
    def all_of(cls, parts: Sequence["ScoredCandidates"]) -> "ScoredCandidates":
        """Return the candidates of all of a film's chunks; at least one."""
        return cls(
            np.concatenate([part.onsets for part in parts]),
            np.concatenate([part.peaks_dbfs for part in parts]),
            LogOdds(
                np.concatenate([part.odds.by_all for part in parts]),
                np.concatenate([part.odds.by_networks for part in parts]),
            ),
        )


@dataclass(frozen=True)
class Pace:
    """What makes sounds one row: `fewest` of them, gaps in ms in a range and as even, peaks within `within_db`."""

    shortest_gap_ms: float
    longest_gap_ms: float
    unevenness: float
    fewest: int
    within_db: float


def automatic(rules: BurstRules) -> Pace:
    """Return the pace of a weapon that reloads itself and goes on."""
    return Pace(rules.shortest_gap_ms, rules.longest_gap_ms, rules.unevenness, rules.fewest_even, rules.echo_drop_db)


def shot_by_shot(tier: QualityRules) -> Pace:
    """Return the pace of somebody who pulls the trigger each time: slower than a burst, up to that of steps."""
    bursts, rows = tier.bursts, tier.rows
    return Pace(bursts.longest_gap_ms, rows.longest_gap_ms, rows.unevenness, rows.fewest, bursts.echo_drop_db)


def rows_at(
    onsets: NDArray[np.intp], peaks_dbfs: NDArray[np.float64], pace: Pace, *, rate_hz: int
) -> list[NDArray[np.intp]]:
    """Return the rows at a pace among onsets, ascending, the longest row first, as indices; no sound is in two."""
    gaps = (samples_from_ms(pace.shortest_gap_ms, rate_hz), samples_from_ms(pace.longest_gap_ms, rate_hz))
    at, loud_db = onsets.tolist(), peaks_dbfs.tolist()  # a few at a time: lists are faster than arrays
    told: set[tuple[int, int]] = set()
    rows = []
    for first, second in _beginnings(onsets, peaks_dbfs, pace, gaps):
        if (first, second) not in told:
            row = _row_on(at, loud_db, first, second, gaps=gaps, pace=pace)
            told.update(pairwise(row))
            rows.append(row[:_MOST_IN_ROW])
    free = np.ones(onsets.size, bool)
    chosen = []
    for row in sorted(rows, key=len, reverse=True):
        if len(row) >= pace.fewest and free[row].all():
            free[row] = False
            chosen.append(np.array(row, np.intp))
    return chosen


def _beginnings(
    onsets: NDArray[np.intp], peaks_dbfs: NDArray[np.float64], pace: Pace, gaps: tuple[int, int]
) -> Iterator[tuple[int, int]]:
    """Yield the pairs that a row may begin with, in order: few pairs of sounds are alike and have a third in time."""
    for start in range(0, onsets.size, _AT_ONCE):
        own = onsets[start : start + _AT_ONCE]
        firsts, stops = np.searchsorted(onsets, own + gaps[0]), np.searchsorted(onsets, own + gaps[1], side="right")
        count = np.maximum(stops - firsts, 0)  # the longest gap may be shorter than the shortest
        first = np.repeat(np.arange(start, start + own.size), count)
        second = np.arange(first.size) + np.repeat(firsts - (np.cumsum(count) - count), count)
        alike = np.abs(peaks_dbfs[second] - peaks_dbfs[first]) <= pace.within_db
        first, second = first[alike], second[alike]
        if pace.fewest > 2:
            gap = onsets[second] - onsets[first]
            late, due = np.ceil(pace.unevenness * gap).astype(np.intp), onsets[second] + gap
            third = np.searchsorted(onsets, due - late) < np.searchsorted(onsets, due + late, side="right")
            first, second = first[third], second[third]
        yield from zip(first.tolist(), second.tolist(), strict=True)


def _row_on(
    at: list[int], loud_db: list[float], first: int, second: int, *, gaps: tuple[int, int], pace: Pace
) -> list[int]:
    """Return the row that goes on from two sounds at their pace, each next one where it is due, if it is as loud.

    No gap is shorter or longer than `gaps` allow. Of a row that is taken in pieces, the next one's first sound is last.
    """
    row, due, late = [first], at[second], 0.0
    while len(row) <= _MOST_IN_ROW:
        earliest, latest = (at[row[-1]] + gap for gap in gaps)
        near = range(bisect_left(at, max(due - late, earliest)), bisect_right(at, min(due + late, latest)))
        alike = [place for place in near if abs(loud_db[place] - loud_db[first]) <= pace.within_db]
        if not alike:
            break
        row.append(min(alike, key=lambda place: abs(at[place] - due)))
        gap = at[row[-1]] - at[row[-2]]
        due, late = at[row[-1]] + gap, pace.unevenness * gap
    return row


def even_rows(scored: ScoredCandidates, *, rate_hz: int, tier: QualityRules) -> list[EvenRow | None]:
    """Return of each candidate, ascending, whether it is a round of even fire or one of a long row that is none."""
    told: list[EvenRow | None] = [None] * scored.onsets.size
    for row in rows_at(scored.onsets, scored.peaks_dbfs, automatic(tier.bursts), rate_hz=rate_hz):
        fire = _sounds_like_fire(scored.odds, row, tier.verify)
        if fire or row.size >= tier.bursts.fewest_as_one:
            for place in row.tolist():
                told[place] = "fire" if fire else "no fire"
    rounds = scored.odds.by_networks >= log_odds_of(tier.verify.round_threshold)
    for row in rows_at(scored.onsets, scored.peaks_dbfs, shot_by_shot(tier), rate_hz=rate_hz):
        if scored.odds.by_networks[row].mean() >= log_odds_of(tier.verify.threshold):
            for place in row[rounds[row]].tolist():
                told[place] = told[place] or "fire"
    return told


def _sounds_like_fire(odds: LogOdds, row: NDArray[np.intp], rules: VerifyRules) -> bool:
    """Return whether a row at the pace of automatic fire is likely enough in the mean, or so by the networks alone."""
    return bool(
        odds.by_all[row].mean() >= log_odds_of(rules.even_threshold)
        or odds.by_networks[row].mean() >= log_odds_of(rules.even_networks_threshold)
    )


def worth_a_look(
    onsets: NDArray[np.intp],
    peaks_dbfs: NDArray[np.float64],
    likely: NDArray[np.float64],
    *,
    least: float,
    rate_hz: int,
    tier: QualityRules,
) -> NDArray[np.bool_]:
    """Return which of n candidates, ascending, the screen finds likely enough to be looked at closely, shape (n,).

    That is `look_from`, and where it finds some of a row of fire so likely, `least` for the others.
    """
    passed = likely >= tier.verify.look_from
    perhaps = np.flatnonzero(likely >= least)
    for row in rows_at(onsets[perhaps], peaks_dbfs[perhaps], automatic(tier.bursts), rate_hz=rate_hz):
        passed[perhaps[row]] |= passed[perhaps[row]].any()
    return passed

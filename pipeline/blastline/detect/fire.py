"""Even fire: sounds at a gun's pace, or at that of a finger, even and equally loud, judged together.

    |   |   |   |   |      one pace, within a few percent from gap to gap, peaks within 3 dB
      .       .            what sounds between, an echo or something else, does not break the row

A row is as many looks at one gun, or at one machine, so its mean odds say more than each sound's own: all of it is fire
or none, since a gun that fires on time skips no round. Somebody who fires shot by shot keeps a slower pace, at which
steps and hammers come as well: there the networks alone are asked, and have to be as sure as of a single shot. The
screen, which hears what is around, takes any such row for a machine.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..model import EvenRow
from ..ruleset import BurstRules, QualityRules
from ..units import samples_from_ms
from .pace import automatic, evenly_placed, rows_at, shot_by_shot
from .verify import LogOdds, log_odds_of


@dataclass(frozen=True, eq=False)
class ScoredCandidates:
    """The candidates of a chunk or a film that the networks judged, in order: onsets, peaks, log-odds; shape (n,).

    What each sounds like (`backdrop.sounds`) has shape (n, LEVELS).
    """

    onsets: NDArray[np.intp]
    peaks_dbfs: NDArray[np.float64]
    odds: LogOdds
    sounds: NDArray[np.int16]

    @classmethod
    def all_of(cls, parts: Sequence["ScoredCandidates"]) -> "ScoredCandidates":
        """Return the candidates of all of a film's chunks; at least one."""
        return cls(
            np.concatenate([part.onsets for part in parts]),
            np.concatenate([part.peaks_dbfs for part in parts]),
            LogOdds(
                np.concatenate([part.odds.by_all for part in parts]),
                np.concatenate([part.odds.by_networks for part in parts]),
                np.concatenate([part.odds.as_burst for part in parts]),
            ),
            np.concatenate([part.sounds for part in parts]),
        )


def even_rows(scored: ScoredCandidates, *, rate_hz: int, tier: QualityRules) -> list[EvenRow | None]:
    """Return of each candidate, ascending, whether it is a round of even fire or one of a long row that is none."""
    told: list[EvenRow | None] = [None] * scored.onsets.size
    for row in in_long_rows(scored.onsets, scored.peaks_dbfs, rate_hz=rate_hz, rules=tier.bursts):
        if _sounds_like_sustained_fire(scored.odds, row, tier):
            for place in row.tolist():
                told[place] = "sustained fire"
    left = np.flatnonzero([each is None for each in told])
    for some in rows_at(scored.onsets[left], scored.peaks_dbfs[left], automatic(tier.bursts), rate_hz=rate_hz):
        row = left[some]
        fire = row.size <= tier.bursts.most_unsure and _sounds_like_fire(scored.odds, row, tier)
        if fire or row.size >= tier.bursts.fewest_as_one:
            for place in row.tolist():
                told[place] = "fire" if fire else "no fire"
    rounds = scored.odds.by_networks >= log_odds_of(tier.verify.round_threshold)
    for row in rows_at(scored.onsets, scored.peaks_dbfs, shot_by_shot(tier), rate_hz=rate_hz):
        gap_ms = 1e3 * float(np.median(np.diff(scored.onsets[row]))) / rate_hz
        if scored.odds.by_networks[row].mean() >= _least_odds_at(gap_ms, tier):
            for place in row[rounds[row]].tolist():
                told[place] = told[place] or "fire"
    return told


def in_long_rows(
    onsets: NDArray[np.intp], peaks_dbfs: NDArray[np.float64], *, rate_hz: int, rules: BurstRules
) -> list[NDArray[np.intp]]:
    """Return the rows as fast and even as automatic fire that last longer than the learnt bursts, as indices.

    What keeps its pace for so long is one gun or one machine, though its level may vary by more than that of a burst.
    """
    pace, fewest = replace(automatic(rules), within_db=rules.sustained_within_db), rules.fewest_sustained
    longest = (fewest - 1) * samples_from_ms(rules.longest_gap_ms, rate_hz)
    if onsets.size < fewest or (onsets[fewest - 1 :] - onsets[: onsets.size - fewest + 1]).min() > longest:
        return []  # nowhere are there so many in so short a time
    if not evenly_placed(onsets, peaks_dbfs, pace, rate_hz=rate_hz, count=fewest).any():
        return []
    paced = np.flatnonzero(evenly_placed(onsets, peaks_dbfs, pace, rate_hz=rate_hz))
    rows = rows_at(onsets[paced], peaks_dbfs[paced], pace, rate_hz=rate_hz)
    return [paced[row] for row in rows if row.size >= fewest]


def _sounds_like_fire(odds: LogOdds, row: NDArray[np.intp], tier: QualityRules) -> bool:
    """Return whether a row at the pace of automatic fire is likely enough in the mean, or so by the networks alone."""
    rules = tier.verify
    return bool(
        odds.by_all[row].mean() >= log_odds_of(rules.even_threshold)
        or odds.by_networks[row].mean() >= log_odds_of(rules.even_networks_threshold)
    )


def _sounds_like_sustained_fire(odds: LogOdds, row: NDArray[np.intp], tier: QualityRules) -> bool:
    """Return whether a row that lasts longer than the bursts that the networks have learnt from is fire.

    It gets less for going on, as machines do: as if each of its sounds were in a burst it has to be surer than a single
    shot, and as it is no less likely than what is reported.
    """
    rules = tier.verify
    return bool(
        odds.as_burst[row].mean() >= log_odds_of(rules.sustained_threshold)
        and odds.by_networks[row].mean() >= log_odds_of(rules.report_from)
    )


def _least_odds_at(gap_ms: float, tier: QualityRules) -> float:
    """Return the mean log-odds that a row needs that is slower than automatic fire: the more, the more like steps."""
    fire_ms = tier.bursts.longest_gap_ms
    steps_ms = max(fire_ms, tier.rows.shortest_gap_ms)
    least = log_odds_of(tier.verify.even_networks_threshold), log_odds_of(tier.verify.threshold)
    return float(np.interp(gap_ms, (fire_ms, steps_ms), least))


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

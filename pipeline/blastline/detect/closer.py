"""Which candidates get a closer look, and what those of long rows get beside it.

candidates ──► gate ──► screen ──► likely enough, or in a row with what is ──► onsets, networks
                          ╰─ long rows, each sound as if in a burst ─╯
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..ruleset import QualityRules
from .across import RowSounds, rows_reach
from .candidates import CandidateFeatures, describe_candidates
from .chunks import Chunk, track_peaks_dbfs
from .features import features_as_in_a_burst
from .fire import in_long_rows, worth_a_look
from .sides import are_audible
from .spectrogram import Spectrograms
from .tracks import Grid
from .verify import LogOdds, Verifier, log_odds_in


def worth_looking_at(
    chunk: Chunk, grid: Grid, tier: QualityRules, verifier: Verifier, over: Chunk | None
) -> CandidateFeatures:
    """Return the candidates that gate and screen do not find hopeless, and that no mix `over` theirs covers.

    Those beyond the core are asked about as well: rows that go on there are the same rows, whichever core they cross.
    """

    def gate(rows: NDArray[np.float64], places: NDArray[np.intp]) -> NDArray[np.bool_]:
        asked = tier.verify.gate_from
        passed = verifier.gate.probabilities(rows) >= (verifier.gate.threshold if asked is None else asked)
        if over is not None:
            passed &= are_audible(chunk, over, places, grid)
        return passed

    def screen(rows: NDArray[np.float64], places: NDArray[np.intp]) -> NDArray[np.bool_]:
        likely, peaks_dbfs = verifier.screen.probabilities(rows), track_peaks_dbfs(chunk, places, grid)
        asked = tier.verify.row_from
        least = min(verifier.screen.threshold if asked is None else asked, tier.verify.look_from)
        passed = worth_a_look(places, peaks_dbfs, likely, least=least, rate_hz=grid.rate_hz, tier=tier)
        for row in in_long_rows(places, peaks_dbfs, rate_hz=grid.rate_hz, rules=tier.bursts):
            as_burst = verifier.screen.probabilities(features_as_in_a_burst(rows[row]))
            passed[row] |= bool(np.median(as_burst) >= tier.verify.look_from)
        return passed

    reach = rows_reach(tier.bursts, grid.rate_hz)
    return describe_candidates(chunk, grid, tier, gate=gate, screen=screen, reach=reach)


def with_long_rows(
    odds: LogOdds,
    found: CandidateFeatures,
    shown: Spectrograms,
    sounds: RowSounds,
    grid: Grid,
    tier: QualityRules,
    verifier: Verifier,
) -> LogOdds:
    """Return the log-odds of candidates with those of long rows as if each sound were one of a burst.

    Screen and networks have learnt from made bursts of 3 to 12 rounds, and that what goes on for longer is a machine.
    """
    as_burst = odds.as_burst.copy()
    for row in in_long_rows(sounds.onsets, sounds.peaks_dbfs, rate_hz=grid.rate_hz, rules=tier.bursts):
        own = sounds.of_core(row)
        again = Spectrograms(shown.near[own], shown.wide[own])
        as_burst[own] = log_odds_in(verifier.verdicts(features_as_in_a_burst(found.rows[own]), again)).by_networks
    return replace(odds, as_burst=as_burst)

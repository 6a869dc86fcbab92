"""Rows of sounds that go on beyond a chunk's core: they are as long there as anywhere.

chunk  |  left  |          core          |  right  |
row                                 | | | | | | |       seen whole in both chunks; each judges its own sounds
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..ruleset import BurstRules
from ..units import samples_from_ms
from .candidates import CandidateFeatures
from .chunks import Chunk
from .fire import in_long_rows
from .pace import automatic, rows_at
from .segment import peak_dbfs


def rows_reach(rules: BurstRules, rate_hz: int) -> int:
    """Return how many samples beyond a core tell whether a row that crosses its end is a long one."""
    return (rules.fewest_sustained - 1) * samples_from_ms(rules.longest_gap_ms, rate_hz)


@dataclass(frozen=True, eq=False)
class RowSounds:
    """All sounds that a core's may be in a row with, in order of time: onsets as indices into the chunk, and peaks.

    `candidates` are their places among the core's `count` candidates, `count` and more for those beyond the core. The
    arrays have shape (sounds,).
    """

    onsets: NDArray[np.intp]
    peaks_dbfs: NDArray[np.float64]
    candidates: NDArray[np.intp]
    count: int

    @classmethod
    def around(
        cls, chunk: Chunk, found: CandidateFeatures, peaks_dbfs: NDArray[np.float64], rate_hz: int
    ) -> "RowSounds":
        """Return the candidates of a core, whose peaks are given, and those beyond it."""
        beyond_dbfs = [peak_dbfs(chunk.samples, onset, rate_hz) for onset in found.beyond.tolist()]
        onsets = np.concatenate([found.onsets, found.beyond])
        order = np.argsort(onsets, kind="stable")
        return cls(onsets[order], np.concatenate([peaks_dbfs, beyond_dbfs])[order], order, found.onsets.size)

    def of_core(self, row: NDArray[np.intp]) -> NDArray[np.intp]:
        """Return which of the core's candidates are in a row of all sounds."""
        candidates = self.candidates[row]
        return candidates[candidates < self.count]

    def going_on(self, *, rate_hz: int, rules: BurstRules) -> NDArray[np.bool_]:
        """Return which of the core's n candidates are in a row that goes on beyond it, shape (n,): it may be fire."""
        found = np.zeros(self.count, np.bool_)
        if self.count < self.onsets.size:
            for row in _rows(self.onsets, self.peaks_dbfs, rate_hz=rate_hz, rules=rules):
                own = self.of_core(row)
                found[own] |= own.size < row.size
        return found


def _rows(
    onsets: NDArray[np.intp], peaks_dbfs: NDArray[np.float64], *, rate_hz: int, rules: BurstRules
) -> list[NDArray[np.intp]]:
    """Return the rows at a gun's pace among onsets, ascending, long or not, as indices; a sound may be in two."""
    return [
        *rows_at(onsets, peaks_dbfs, automatic(rules), rate_hz=rate_hz),
        *in_long_rows(onsets, peaks_dbfs, rate_hz=rate_hz, rules=rules),
    ]

"""A lesson as the detector hears it: its candidates, their features, and which of them are shots."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..detect.candidates import describe_candidates, let_all_pass
from ..detect.chunks import chunks
from ..detect.scan import loudest_around
from ..detect.tracks import Grid, pieces
from ..model import Clip
from ..ruleset import QualityRules
from .mixes import RATE_HZ, Mix

ON_TARGET_MS, NEAR_TARGET_MS = 8.0, 20.0
"""The nearest candidate so near to a shot's onset is the shot; others, up to the second, are left out."""

SHOCK_LEAD_MS, SHOCK_ON_TARGET_MS = 60.0, 3.0
"""A shock up to so long before a shot without a candidate is its own, and so near to it a candidate stands for both."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Of n candidates: lesson, onset, largest peak around, features, whether a shot; and the shots without any.

    `rows` has shape (n, features), the others (n,). Onsets are samples of their lesson.
    """

    lesson: NDArray[np.intp]
    onsets: NDArray[np.intp]
    loudest: NDArray[np.float32]
    rows: NDArray[np.float32]
    shots: NDArray[np.bool_]
    missed: int

    def taken(self, which: NDArray[np.bool_]) -> "Candidates":
        """Return some of the candidates; a shot that is not among them counts as missed."""
        lost = int(self.shots[~which].sum())
        onsets, loudest, rows = self.onsets[which], self.loudest[which], self.rows[which]
        return Candidates(self.lesson[which], onsets, loudest, rows, self.shots[which], self.missed + lost)


def candidates(film: Mix, tier: QualityRules, lesson: int) -> Candidates:
    """Scan a mix and label its candidates: of those near a shot's onset the nearest is right, the others left out.

    Where the scan saw nothing there, because the shock of the bullet just before hides it, the shock is right.
    """
    grid = Grid(RATE_HZ)
    clip = Clip(film.samples[:, None], RATE_HZ)
    found = []
    for chunk in chunks(pieces([clip], RATE_HZ)):
        each = describe_candidates(chunk, grid, tier, gate=let_all_pass, screen=let_all_pass)
        loudest = loudest_around(chunk.peak, each.onsets // grid.step, grid=grid)
        found.append((chunk.start + each.onsets, loudest, each.rows.astype(np.float32)))
    at, loudest, rows = (np.concatenate(parts) for parts in zip(*found, strict=True))
    shots, sure, missed = _labels(at, film)
    return Candidates(np.full(int(sure.sum()), lesson), at[sure], loudest[sure], rows[sure], shots[sure], missed)


def concatenated(parts: Sequence[Candidates]) -> Candidates:
    """Return several sets of candidates as one."""
    return Candidates(
        np.concatenate([part.lesson for part in parts]),
        np.concatenate([part.onsets for part in parts]),
        np.concatenate([part.loudest for part in parts]),
        np.concatenate([part.rows for part in parts]),
        np.concatenate([part.shots for part in parts]),
        sum(part.missed for part in parts),
    )


def best_f1(score: NDArray[np.float64], held_out: Candidates) -> tuple[float, float]:
    """Return the largest F1 that a threshold on the scores gives, and that threshold; the missed count as missed."""
    order = np.argsort(-score, kind="stable")
    hits = np.cumsum(held_out.shots[order])
    taken = np.arange(1, order.size + 1)
    f1 = 2.0 * hits / (taken + int(held_out.shots.sum()) + held_out.missed)
    best = int(np.argmax(f1))
    return float(f1[best]), float(score[order[best]])


def _labels(at: NDArray[np.intp], film: Mix) -> tuple[NDArray[np.bool_], NDArray[np.bool_], int]:
    """Return which candidates are shots, which are sure to be either, and how many shots have no candidate."""
    shots = np.zeros(at.size, bool)
    places_of_interest = np.concatenate([film.onsets, film.unsure])
    if not places_of_interest.size or not at.size:
        return shots, np.ones(at.size, bool), int(film.onsets.size)
    ms = 1000.0 / RATE_HZ
    hit = np.zeros(film.onsets.size, bool)
    if film.onsets.size:
        gaps = np.abs(at[:, None] - film.onsets[None, :]) * ms
        nearest = gaps.argmin(axis=0)
        hit = gaps[nearest, np.arange(film.onsets.size)] <= ON_TARGET_MS
        shots[nearest[hit]] = True
    at_ms, onsets_ms, shocks_ms = (np.asarray(x * ms, np.float64) for x in (at, film.onsets, film.unsure))
    hit |= _label_shocks(shots, at_ms, onsets_ms[~hit], shocks_ms, onsets_ms)
    sure = shots | (np.abs(at[:, None] - places_of_interest[None, :]).min(axis=1) * ms > NEAR_TARGET_MS)
    return shots, sure, int((~hit).sum())


def _label_shocks(
    shots: NDArray[np.bool_],
    at_ms: NDArray[np.float64],
    missed_ms: NDArray[np.float64],
    shocks_ms: NDArray[np.float64],
    onsets_ms: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Label the candidates on the shocks of shots that were missed, and return which of all shots that settles."""
    settled = np.zeros(onsets_ms.size, bool)
    for onset_ms in missed_ms:
        own = shocks_ms[(shocks_ms < onset_ms) & (shocks_ms > onset_ms - SHOCK_LEAD_MS)]
        near = np.flatnonzero((np.abs(at_ms[:, None] - own[None, :]) <= SHOCK_ON_TARGET_MS).any(axis=1))
        if near.size:
            shots[near[0]] = True
            settled |= onsets_ms == onset_ms
    return settled

"""Straight lines new = scale * old + offset along which the two films may run side by side.

Segments of the old film are looked for at the speeds that films are copied at (`hits`), and lines drawn through those
that lie in a row.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from .fingerprint import Fingerprint
from .hits import (
    LINE_TOLERANCE_S,
    MAX_GAP_S,
    SEGMENTS_S,
    find_hits,
    follows,
    is_covered,
    is_lively,
    segment_centres,
)
from .search import Haystack, Hit

SPEEDS = (1.0, 25.0 / 24.0, 24.0 / 25.0)
"""How much faster a copy may run. The pull of 1001/1000 is so little that it is found with these."""

SPEED_STEP = 0.004
_OTHER_SPEEDS = tuple(float(speed) for speed in np.round(np.arange(0.9, 1.1001, SPEED_STEP), 3))
"""Tried where less than `_SETTLED_SHARE` of the film is found: a fingerprint of 8 s stands 0.4 % either way."""

_SETTLED_SHARE = 0.3  # of the old film: where so much is found at the usual speeds, no others are tried
_MIN_ROW_HITS = 4  # fewer on one line are not counted as found: a few may lie on one by chance
_PROBE_COUNT = 24  # segments that are tried at the other speeds: each is searched for at every one of these

_SURE_CORRELATION = 0.6  # a hit that is so much alike is believed without others on its line
_CHANCE_CORRELATION, _MIN_SURPLUS = 0.2, 0.5  # a row is believed for what its hits have above chance, in sum

FITTED_S = 30.0
"""From here on the slope of a run of segments tells its speed better than the speeds that were tried."""


@dataclass(frozen=True)
class Line:
    """new_s = scale * old_s + offset_s, believed between two times of the old film."""

    scale: float
    offset_s: float
    first_s: float
    last_s: float

    def at(self, old_s: float) -> float:
        """Return the time in the new film."""
        return self.scale * old_s + self.offset_s

    def back(self, new_s: float) -> float:
        """Return the time in the old film."""
        return (new_s - self.offset_s) / self.scale


def find_lines(
    old: Fingerprint, new: Fingerprint, tell: Callable[[int, int], None] | None = None, *, any_speed: bool = False
) -> list[Line]:
    """Return every line that segments of the old film give reason for, in no order.

    Unusual speeds are tried where the usual ones find too little, or where `any_speed` says so.
    """
    longest_s = max(length for length, _ in SEGMENTS_S)
    hay = Haystack(new, longest_s * 1.1 + 0.1)
    speeds: tuple[float, ...] = SPEEDS
    hits = find_hits(old, new, hay, segment_centres(old, *SEGMENTS_S[0]), SEGMENTS_S[0][0], speeds, tell)
    if any_speed or _share(hits, old) < _SETTLED_SHARE:
        length_s = SEGMENTS_S[0][0]
        probes = [at for at in segment_centres(old, length_s, length_s) if is_lively(old, at, length_s)]
        probes = probes[:: max(1, len(probes) // _PROBE_COUNT)]
        tried = _at_best_speeds(find_hits(old, new, hay, probes, length_s, _OTHER_SPEEDS))
        sure = [hit for hit in tried if hit.score >= _SURE_CORRELATION]
        others = {1.0 / hit.scale for hit in sure}
        if others:
            speeds = tuple(sorted(others))
            hits += find_hits(old, new, hay, segment_centres(old, *SEGMENTS_S[0]), length_s, speeds, tell)
    found = [1.0 / hit.scale for hit in hits if hit.score >= _SURE_CORRELATION]
    used = tuple(speed for speed in speeds if found.count(speed) >= 2) or speeds
    length_s, spacing_s = SEGMENTS_S[1]
    left = [at for at in segment_centres(old, length_s, spacing_s) if not is_covered(at, hits)]
    hits += find_hits(old, new, hay, left, length_s, used)
    return [_fitted(run) for run in _runs(_at_best_speeds(hits)) if _credible(run)]


def _at_best_speeds(hits: Iterable[Hit]) -> list[Hit]:
    """Return hits, less those of a segment that lie where it is more alike at a speed next to theirs."""
    kept: dict[float, list[Hit]] = {}
    for hit in sorted(hits, key=lambda hit: -hit.score):
        others = kept.setdefault(hit.old_s, [])
        near = (other for other in others if abs(other.new_s - hit.new_s) <= LINE_TOLERANCE_S)
        if not any(abs(other.scale / hit.scale - 1.0) < 1.5 * SPEED_STEP for other in near):
            others.append(hit)
    return [hit for hits in kept.values() for hit in hits]


def _runs(hits: Sequence[Hit]) -> list[list[Hit]]:
    """Return the hits in rows that lie on one line each, with no gap of more than two minutes."""
    runs: list[list[Hit]] = []
    active: list[list[Hit]] = []
    for hit in sorted(hits, key=lambda hit: hit.old_s):
        active = [run for run in active if hit.old_s - run[-1].old_s <= MAX_GAP_S]
        mine = [run for run in active if follows(run[-1], hit)]
        if mine:
            own = min(mine, key=lambda run: abs(run[-1].new_s + hit.scale * (hit.old_s - run[-1].old_s) - hit.new_s))
            own.append(hit)
        else:
            active.append([hit])
            runs.append(active[-1])
    return runs


def _credible(run: Sequence[Hit]) -> bool:
    surplus = sum(hit.score - _CHANCE_CORRELATION for hit in run)
    return max(hit.score for hit in run) >= _SURE_CORRELATION or surplus >= _MIN_SURPLUS


def _fitted(run: Sequence[Hit]) -> Line:
    """Return the line through a run: its own slope where it is long enough, else the speed that it was found at."""
    old_s, new_s = np.array([hit.old_s for hit in run]), np.array([hit.new_s for hit in run])
    scale = run[0].scale
    if old_s[-1] - old_s[0] >= FITTED_S:
        scale *= 1.0 + _pull(run)
    return Line(scale, float(np.median(new_s - scale * old_s)), float(old_s[0]), float(old_s[-1]))


def _pull(run: Sequence[Hit]) -> float:
    """Return by which share a row moves on slower than the speed that it was found at says."""
    old_s, new_s = np.array([hit.old_s for hit in run]), np.array([hit.new_s for hit in run])
    return float(np.polyfit(old_s - old_s.mean(), new_s, 1)[0]) / run[0].scale - 1.0


def _share(hits: Sequence[Hit], old: Fingerprint) -> float:
    """Return the share of the old film whose segments follow each other in the new one, at least four in a row.

    Rows that move on at another speed than they were found at do not count: 1 % beside its own, much of a film is alike
    enough to be believed, and too little to be placed.
    """
    rows = [run for run in _runs(hits) if len(run) >= _MIN_ROW_HITS and abs(_pull(run)) < SPEED_STEP]
    found = {hit.old_s for run in rows for hit in run if hit.score >= _SURE_CORRELATION}
    lively = [at for at in segment_centres(old, *SEGMENTS_S[0]) if is_lively(old, at, SEGMENTS_S[0][0])]
    return len(found) / max(1, len(lively))

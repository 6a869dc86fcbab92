"""Straight lines new = scale * old + offset along which the two films may run side by side.

A segment of the old film that goes on where the last one was found costs next to nothing; only where that fails is the
whole new film searched, at every speed that films are copied at.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .fingerprint import FRAME_HZ, Fingerprint
from .search import MIN_ENERGY_SHARE, Haystack, Hit

SPEEDS = (1.0, 25.0 / 24.0, 24.0 / 25.0)
"""How much faster a copy may run. The pull of 1001/1000 is so little that it is found with these."""

SPEED_STEP = 0.004
_OTHER_SPEEDS = tuple(float(speed) for speed in np.round(np.arange(0.9, 1.1001, SPEED_STEP), 3))
"""Tried where less than `_SETTLED_SHARE` of the film is found: a fingerprint of 8 s stands 0.4 % either way."""

_SETTLED_SHARE = 0.3  # of the old film: where so much is found at the usual speeds, no others are tried
_MIN_ROW_HITS = 4  # fewer on one line are not counted as found: a few may lie on one by chance
_PROBE_COUNT = 24  # segments that are tried at the other speeds: each is searched for at every one of these

_SEGMENTS_S = ((8.0, 4.0), (3.0, 1.5))
"""Length and spacing of the segments: long ones first, shorter ones where those found nothing."""

_FOLLOW_CORRELATION = 0.6  # so much alike where an earlier line goes on, a segment is not searched for elsewhere
_MIN_CORRELATION = 0.35  # what is less alike in a search of the whole film is taken for chance
_SURE_CORRELATION = 0.6  # a hit that is so much alike is believed without others on its line
_MAX_PLACES = 3  # kept of a search: a scene or its music may come again
_MAX_FOLLOWED = 4  # a segment is looked for where so many lines go on, the latest first
_FOLLOW_FRAMES = 8  # how far to either side of there, in frames of the fingerprint
_MIN_POWER = 0.05  # of a segment, per frame: less is silence, or a hum without a change
_RIVAL_SHARE = 0.7  # of the best place's correlation: others as good as that are kept
_CHANCE_CORRELATION, _MIN_SURPLUS = 0.2, 0.5  # a row is believed for what its hits have above chance, in sum
_COVERING_CORRELATION = 0.8  # a long segment so much alike was found as a whole: there is no cut in it

_LINE_TOLERANCE_S, _LINE_DRIFT = 0.04, 0.002
"""How far off a line a hit may lie, and how much more for each second of distance from the hit before."""

_MAX_GAP_S = 120.0  # over a longer gap a line is not continued

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
    longest_s = max(length for length, _ in _SEGMENTS_S)
    hay = Haystack(new, longest_s * 1.1 + 0.1)
    speeds: tuple[float, ...] = SPEEDS
    hits = _hits(old, new, hay, _segments(old, *_SEGMENTS_S[0]), _SEGMENTS_S[0][0], speeds, tell)
    if any_speed or _share(hits, old) < _SETTLED_SHARE:
        length_s = _SEGMENTS_S[0][0]
        probes = [at for at in _segments(old, length_s, length_s) if _lively(old, at, length_s)]
        probes = probes[:: max(1, len(probes) // _PROBE_COUNT)]
        tried = _at_best_speeds(_hits(old, new, hay, probes, length_s, _OTHER_SPEEDS))
        sure = [hit for hit in tried if hit.score >= _SURE_CORRELATION]
        others = {1.0 / hit.scale for hit in sure}
        if others:
            speeds = tuple(sorted(others))
            hits += _hits(old, new, hay, _segments(old, *_SEGMENTS_S[0]), length_s, speeds, tell)
    found = [1.0 / hit.scale for hit in hits if hit.score >= _SURE_CORRELATION]
    used = tuple(speed for speed in speeds if found.count(speed) >= 2) or speeds
    length_s, spacing_s = _SEGMENTS_S[1]
    left = [at for at in _segments(old, length_s, spacing_s) if not _covered(at, hits)]
    hits += _hits(old, new, hay, left, length_s, used)
    return [_fitted(run) for run in _runs(_at_best_speeds(hits)) if _credible(run)]


def _segments(old: Fingerprint, length_s: float, spacing_s: float) -> list[float]:
    """Return the centres of the segments; a film shorter than one is one segment."""
    if old.duration_s <= length_s:
        return [old.duration_s / 2.0]
    count = int((old.duration_s - length_s) / spacing_s) + 1
    centres, last = [length_s / 2.0 + n * spacing_s for n in range(count)], old.duration_s - length_s / 2.0
    return centres if centres[-1] == last else [*centres, last]


def _pattern(old: Fingerprint, centre_s: float, length_s: float, scale: float) -> tuple[NDArray[np.float32], float]:
    """Return a segment as it sounds in the new film's time, and how long before its centre it starts there."""
    length_s = min(length_s, old.duration_s)
    size = max(2, round(length_s * scale * FRAME_HZ))
    before_s = (size - 1) / 2.0 / FRAME_HZ
    times = centre_s + (np.arange(size) / FRAME_HZ - before_s) / scale
    return old.at(times), before_s


def _lively(old: Fingerprint, centre_s: float, length_s: float) -> bool:
    pattern, _ = _pattern(old, centre_s, length_s, 1.0)
    return float(np.mean(pattern.astype(np.float64) ** 2)) > _MIN_POWER


def _hits(
    old: Fingerprint,
    new: Fingerprint,
    hay: Haystack,
    centres: Iterable[float],
    length_s: float,
    speeds: Sequence[float],
    tell: Callable[[int, int], None] | None = None,
) -> list[Hit]:
    """Return where each segment lies: where it is expected to go on, or else the best places of the whole film."""
    hits: list[Hit] = []
    recent: list[Hit] = []
    for centre_s in centres:
        if tell is not None:
            tell(round(centre_s), round(old.duration_s))
        if not _lively(old, centre_s, length_s):
            continue
        here = [hit for hit in (_follow(old, new, last, centre_s, length_s) for last in recent) if hit is not None]
        if not here:
            here = _everywhere(old, hay, centre_s, length_s, speeds)
        hits += here
        recent = [*here, *(hit for hit in recent if centre_s - hit.old_s < _MAX_GAP_S)]
        recent = _distinct(recent)[:_MAX_FOLLOWED]
    return hits


def _follow(old: Fingerprint, new: Fingerprint, last: Hit, centre_s: float, length_s: float) -> Hit | None:
    """Return the hit near where the last one goes on; None where the films are not alike there."""
    pattern, before_s = _pattern(old, centre_s, length_s, last.scale)
    expected = round((last.new_s + last.scale * (centre_s - last.old_s) - before_s) * FRAME_HZ)
    first, stop = max(0, expected - _FOLLOW_FRAMES), min(expected + _FOLLOW_FRAMES, len(new) - len(pattern)) + 1
    if first >= stop:
        return None
    there = new.frames[first : stop - 1 + len(pattern)]
    own, powers = float(np.sum(pattern**2)), np.sum(there**2, axis=1, dtype=np.float64)
    sums = np.concatenate([[0.0], np.cumsum(powers)])
    energy = sums[len(pattern) :] - sums[: -len(pattern)]
    product = np.array([np.vdot(pattern, there[n : n + len(pattern)]) for n in range(stop - first)])
    score = np.where(energy > MIN_ENERGY_SHARE * own, product / np.sqrt(np.maximum(own * energy, 1e-12)), 0.0)
    at, best = first + int(np.argmax(score)), float(np.max(score))
    return Hit(centre_s, at / FRAME_HZ + before_s, last.scale, best) if best >= _FOLLOW_CORRELATION else None


def _everywhere(
    old: Fingerprint, hay: Haystack, centre_s: float, length_s: float, speeds: Sequence[float]
) -> list[Hit]:
    found = []
    for speed in speeds:
        pattern, before_s = _pattern(old, centre_s, length_s, 1.0 / speed)
        for start, score in hay.best(pattern, _MAX_PLACES):
            found.append(Hit(centre_s, start / FRAME_HZ + before_s, 1.0 / speed, score))
    found.sort(key=lambda hit: -hit.score)
    least = max(_MIN_CORRELATION, _RIVAL_SHARE * found[0].score) if found else _MIN_CORRELATION
    return [hit for hit in _distinct(found)[:_MAX_PLACES] if hit.score >= least]


def _distinct(hits: Iterable[Hit]) -> list[Hit]:
    """Return hits without those that lie on the line of an earlier one."""
    kept: list[Hit] = []
    for hit in hits:
        if not any(_follows(other, hit) or _follows(hit, other) for other in kept):
            kept.append(hit)
    return kept


def _follows(one: Hit, other: Hit) -> bool:
    gap_s = other.old_s - one.old_s
    expected = one.new_s + one.scale * gap_s
    near = abs(expected - other.new_s) <= _LINE_TOLERANCE_S + _LINE_DRIFT * abs(gap_s)
    return near and abs(one.scale / other.scale - 1.0) < _LINE_DRIFT


def _at_best_speeds(hits: Iterable[Hit]) -> list[Hit]:
    """Return hits, less those of a segment that lie where it is more alike at a speed next to theirs."""
    kept: dict[float, list[Hit]] = {}
    for hit in sorted(hits, key=lambda hit: -hit.score):
        others = kept.setdefault(hit.old_s, [])
        near = (other for other in others if abs(other.new_s - hit.new_s) <= _LINE_TOLERANCE_S)
        if not any(abs(other.scale / hit.scale - 1.0) < 1.5 * SPEED_STEP for other in near):
            others.append(hit)
    return [hit for hits in kept.values() for hit in hits]


def _runs(hits: Sequence[Hit]) -> list[list[Hit]]:
    """Return the hits in rows that lie on one line each, with no gap of more than two minutes."""
    runs: list[list[Hit]] = []
    active: list[list[Hit]] = []
    for hit in sorted(hits, key=lambda hit: hit.old_s):
        active = [run for run in active if hit.old_s - run[-1].old_s <= _MAX_GAP_S]
        mine = [run for run in active if _follows(run[-1], hit)]
        if mine:
            min(mine, key=lambda run: abs(run[-1].new_s + hit.scale * (hit.old_s - run[-1].old_s) - hit.new_s)).append(
                hit
            )
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
    lively = [at for at in _segments(old, *_SEGMENTS_S[0]) if _lively(old, at, _SEGMENTS_S[0][0])]
    return len(found) / max(1, len(lively))


def _covered(centre_s: float, hits: Sequence[Hit]) -> bool:
    """Return whether a long segment around here was found as a whole."""
    half_s = _SEGMENTS_S[0][0] / 2.0
    return any(abs(hit.old_s - centre_s) <= half_s and hit.score >= _COVERING_CORRELATION for hit in hits)

"""Where segments of the old film lie in the new one.

A segment that goes on where the last one was found costs next to nothing; only where that fails is the whole new film
searched, at every speed that is asked for.
"""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from .fingerprint import FRAME_HZ, Fingerprint
from .search import MIN_ENERGY_SHARE, Haystack, Hit

SEGMENTS_S = ((8.0, 4.0), (3.0, 1.5))
"""Length and spacing of the segments: long ones first, shorter ones where those found nothing."""

MAX_GAP_S = 120.0  # over a longer gap a line is not continued

LINE_TOLERANCE_S, LINE_DRIFT = 0.04, 0.002
"""How far off a line a hit may lie, and how much more for each second of distance from the hit before."""

_FOLLOW_CORRELATION = 0.6  # so much alike where an earlier line goes on, a segment is not searched for elsewhere
_MIN_CORRELATION = 0.35  # what is less alike in a search of the whole film is taken for chance
_MAX_PLACES = 3  # kept of a search: a scene or its music may come again
_MAX_FOLLOWED = 4  # a segment is looked for where so many lines go on, the latest first
_FOLLOW_FRAMES = 8  # how far to either side of there, in frames of the fingerprint
_MIN_POWER = 0.05  # of a segment, per frame: less is silence, or a hum without a change
_RIVAL_SHARE = 0.7  # of the best place's correlation: others as good as that are kept
_COVERING_CORRELATION = 0.8  # a long segment so much alike was found as a whole: there is no cut in it


def segment_centres(old: Fingerprint, length_s: float, spacing_s: float) -> list[float]:
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


def is_lively(old: Fingerprint, centre_s: float, length_s: float) -> bool:
    """Return whether a segment sounds and changes, so that it can be found by that."""
    pattern, _ = _pattern(old, centre_s, length_s, 1.0)
    return float(np.mean(pattern.astype(np.float64) ** 2)) > _MIN_POWER


def find_hits(
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
        if not is_lively(old, centre_s, length_s):
            continue
        here = [hit for hit in (_follow(old, new, last, centre_s, length_s) for last in recent) if hit is not None]
        if not here:
            here = _everywhere(old, hay, centre_s, length_s, speeds)
        hits += here
        recent = [*here, *(hit for hit in recent if centre_s - hit.old_s < MAX_GAP_S)]
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
        if not any(follows(other, hit) or follows(hit, other) for other in kept):
            kept.append(hit)
    return kept


def follows(one: Hit, other: Hit) -> bool:
    """Return whether the second hit lies on the line on which the first goes on."""
    gap_s = other.old_s - one.old_s
    expected = one.new_s + one.scale * gap_s
    near = abs(expected - other.new_s) <= LINE_TOLERANCE_S + LINE_DRIFT * abs(gap_s)
    return near and abs(one.scale / other.scale - 1.0) < LINE_DRIFT


def is_covered(centre_s: float, hits: Sequence[Hit]) -> bool:
    """Return whether a long segment around here was found as a whole."""
    half_s = SEGMENTS_S[0][0] / 2.0
    return any(abs(hit.old_s - centre_s) <= half_s and hit.score >= _COVERING_CORRELATION for hit in hits)

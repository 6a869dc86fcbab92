"""The moments at which segments begin and end, where the waveforms part.

line 1   ▇▇▇▇▇▇▇▇▇▇▇▇▅▃▂                 alike, in blocks of 20 ms
line 2             ▂▃▆▇▇▇▇▇▇▇▇▇▇▇
                     ^ the cut: as much as possible is alike on either side
"""

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .courses import Course
from .film import Film
from .waveform import WORK_HZ, piece

_EDGE_S = 2.0  # how far around a coarse end the exact one is looked for
_BLOCK_S = 0.02
_SHORTEST_S = 0.001  # too little to be compared
_ALIKE = 0.5  # blocks more alike than this are the same sound
_AT_ONCE = 500
"""Blocks that are compared at once: two segments may claim the same minutes, where a scene comes twice."""


def with_exact_ends(courses: Sequence[Course], old: Film, new: Film) -> list[Course]:
    """Return the courses, in the old film's order, with each end where the waveforms part.

    Where two claim the same moment of one of the films, as in a burst of one sample, each keeps the side on which it is
    more alike. What keeps its pitch has no waveform to compare, and keeps its coarse ends.
    """
    exact = [course.between(*_edges(course, old, new)) for course in courses]
    by_old = sorted(_without_contained(_real(exact)), key=lambda each: each.segment.start_s)
    for one, other in itertools.pairwise(range(len(by_old))):
        by_old[one], by_old[other] = _apart(by_old[one], by_old[other], old, new, in_old=True)
    by_new = sorted(_real(by_old), key=lambda each: each.segment.new_span_s)
    for one, other in itertools.pairwise(range(len(by_new))):
        by_new[one], by_new[other] = _apart(by_new[one], by_new[other], old, new, in_old=False)
    return sorted(_real(by_new), key=lambda each: each.segment.start_s)


def reached(course: Course, from_s: float, to_s: float, old: Film, new: Film) -> Course:
    """Return a course from one moment of the old film on, as far towards another as the waveforms are alike.

    The other moment may be earlier, for the way back.
    """
    along = course.between(*sorted((from_s, to_s)))
    end_s = _alike_until(along, from_s, to_s, old, new, way_up=_way_up(along, from_s, old, new))
    return course.between(*sorted((from_s, end_s)))


def _real(courses: Sequence[Course]) -> list[Course]:
    return [course for course in courses if course.segment.start_s < course.segment.stop_s]


def _without_contained(courses: Sequence[Course]) -> list[Course]:
    """Return the courses but those that lie within one that more anchors are on: nothing is left for them there."""
    kept: list[Course] = []
    for course in sorted(courses, key=lambda each: -each.anchors):
        own = course.segment
        if not any(other.segment.start_s <= own.start_s and own.stop_s <= other.segment.stop_s for other in kept):
            kept.append(course)
    return kept


def _edges(course: Course, old: Film, new: Film) -> tuple[float, float]:
    segment = course.segment
    if course.keeps_pitch:
        return segment.start_s, segment.stop_s
    way_up = _way_up(course, segment.start_s, old, new)
    low_s, high_s = max(0.0, segment.start_s - _EDGE_S), min(segment.start_s + _EDGE_S, segment.stop_s)
    first_s = max(0.0, segment.line.back(0.0))
    start_s = max(first_s, _alike_until(course, high_s, low_s, old, new, way_up=way_up))
    start_s = _to_end_of_film(course, start_s, first_s, old, new, way_up=way_up)
    way_up = _way_up(course, segment.stop_s, old, new)
    low_s, high_s = max(segment.stop_s - _EDGE_S, start_s), min(old.duration_s, segment.stop_s + _EDGE_S)
    last_s = min(old.duration_s, segment.line.back(new.duration_s))
    stop_s = min(last_s, _alike_until(course, low_s, high_s, old, new, way_up=way_up))
    return start_s, _to_end_of_film(course, stop_s, last_s, old, new, way_up=way_up)


def _alike_until(course: Course, from_s: float, to_s: float, old: Film, new: Film, *, way_up: float) -> float:
    """Return up to which moment, from one on towards another, the films are alike along a course."""
    reach_s = _block_count(abs(to_s - from_s)) * _BLOCK_S  # whole blocks, laid from where the films are alike
    if to_s < from_s:
        gain = _gain(course, from_s - reach_s, from_s, old, new, way_up=way_up)
        return from_s - _best_count(gain[::-1]) * _BLOCK_S
    return from_s + _best_count(_gain(course, from_s, from_s + reach_s, old, new, way_up=way_up)) * _BLOCK_S


def _to_end_of_film(course: Course, end_s: float, film_s: float, old: Film, new: Film, *, way_up: float) -> float:
    """Return where a film begins or ends if less than a block is left up to there, and that is alike or silent too."""
    low_s, high_s = sorted((end_s, film_s))
    if high_s - low_s >= _BLOCK_S:
        return end_s
    count = int(high_s - low_s > _SHORTEST_S)
    alike = way_up * _likeness_of(course, low_s, high_s - low_s, count, old, new)
    return end_s if np.any(alike <= _ALIKE) else film_s


def _way_up(course: Course, end_s: float, old: Film, new: Film) -> float:
    """Return -1 where the new film is upside down inside an end of a course, else 1: a reel may be so by itself."""
    segment = course.segment
    low_s, high_s = max(segment.start_s, end_s - _EDGE_S), min(segment.stop_s, end_s + _EDGE_S)
    return -1.0 if float(np.nansum(_likeness(course, low_s, high_s, old, new))) < 0.0 else 1.0


def _best_count(gain: NDArray[np.float64]) -> int:
    """Return how many blocks from the inside out belong to the segment."""
    return int(np.argmax(np.concatenate([[0.0], np.cumsum(gain)])))


def _gain(course: Course, low_s: float, high_s: float, old: Film, new: Film, *, way_up: float) -> NDArray[np.float64]:
    """Return of each block how much more alike the films are than different sounds; 0 of silence."""
    alike = way_up * _likeness(course, low_s, high_s, old, new)
    return np.where(np.isnan(alike), 0.0, alike - _ALIKE)


def _apart(one: Course, other: Course, old: Film, new: Film, *, in_old: bool) -> tuple[Course, Course]:
    """Return two courses that follow each other in a film, parted where together they are most alike."""
    first, second = one.segment, other.segment
    low_s, high_s = (second.start_s, first.stop_s) if in_old else (second.new_span_s[0], first.new_span_s[1])
    count = _block_count(high_s - low_s)
    if count < 1 or one.keeps_pitch or other.keeps_pitch:
        return one, other
    sides = []
    for course, end_s in ((one, first.stop_s), (other, second.start_s)):
        line = course.segment.line
        start_s, stop_s = (low_s, high_s) if in_old else (line.back(low_s), line.back(high_s))
        alike = np.nan_to_num(_likeness_of(course, start_s, stop_s - start_s, count, old, new))
        sides.append(_way_up(course, end_s, old, new) * alike)
    left, right = (np.concatenate([[0.0], np.cumsum(side)]) for side in sides)
    at_s = low_s + int(np.argmax(left - right)) / count * (high_s - low_s)
    stop_s, start_s = (at_s, at_s) if in_old else (first.line.back(at_s), second.line.back(at_s))
    stop_s, start_s = max(stop_s, first.start_s), min(start_s, second.stop_s)
    return one.between(first.start_s, stop_s), other.between(start_s, second.stop_s)


def _likeness(course: Course, low_s: float, high_s: float, old: Film, new: Film) -> NDArray[np.float64]:
    """Return the correlation of each whole block between two times of the old film; NaN where both are silent.

    It is negative where the new film is upside down.
    """
    count = _block_count(high_s - low_s)
    return _likeness_of(course, low_s, count * _BLOCK_S, count, old, new)


def _block_count(length_s: float) -> int:
    """Return how many whole blocks a length holds; one that lacks no more than a rounding is whole."""
    return int(length_s / _BLOCK_S + 1e-6)


def _likeness_of(
    course: Course, start_s: float, length_s: float, count: int, old: Film, new: Film
) -> NDArray[np.float64]:
    """Return the correlation of each of `count` equal blocks of a stretch of the old film; NaN for silence in both."""
    if count < 1:
        return np.zeros(0)
    if count > _AT_ONCE:
        edges_s = start_s + length_s / count * np.array([*range(0, count, _AT_ONCE), count])
        counts = [min(_AT_ONCE, count - first) for first in range(0, count, _AT_ONCE)]
        parts = zip(itertools.pairwise(edges_s.tolist()), counts, strict=True)
        return np.concatenate([_likeness_of(course, a_s, b_s - a_s, n, old, new) for (a_s, b_s), n in parts])
    line = course.segment.line
    ours, ours_late_s = piece(old, start_s, length_s, scale=line.scale)
    theirs, theirs_late_s = piece(new, line.at(start_s), length_s * line.scale)
    length = min(len(ours), len(theirs))
    theirs = _delayed(theirs[:length], (theirs_late_s - ours_late_s) * WORK_HZ)
    edges = np.linspace(0, length, count + 1).astype(np.intp)
    product, mine, yours = (
        np.add.reduceat(values, edges[:-1]) for values in (ours[:length] * theirs, ours[:length] ** 2, theirs**2)
    )
    scale = np.sqrt(np.maximum(mine * yours, 1e-30))
    return np.where(np.maximum(mine, yours) < 1e-12, np.nan, product / scale)


def _delayed(samples: NDArray[np.float64], by: float) -> NDArray[np.float64]:
    """Return samples later by some, as few as a fraction of one, so that two pieces lie on one grid."""
    from scipy import fft

    size = fft.next_fast_len(len(samples) + 64, real=True)
    spectrum = fft.rfft(samples, size) * np.exp(-2j * np.pi * fft.rfftfreq(size) * by)
    return np.asarray(fft.irfft(spectrum, size)[: len(samples)], dtype=np.float64)

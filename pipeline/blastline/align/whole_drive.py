"""One pass over the drive's file: its length, its peak, and what moves where there is no window."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Clip, Span

Expected = Callable[[Span], NDArray[np.float64]]

_STEP_24_BIT = 2.0**-23


@dataclass(frozen=True)
class DriveFigures:
    """The number of frames, the peak, and how many samples outside windows are not what they should be."""

    frames: int
    peak: float
    stray: int


def gaps(windows: Iterable[Span], frames: int) -> list[Span]:
    """Return what lies between windows, which may overlap, from the film's first frame to its last.

    >>> gaps([Span(2, 4), Span(3, 6)], 10)
    [Span(start=0, stop=2), Span(start=6, stop=10)]
    """
    found, free = [], 0
    for window in sorted(windows):
        if window.start > free:
            found.append(Span(free, max(free, min(window.start, frames))))
        free = max(free, window.stop)
    return [gap for gap in [*found, Span(free, max(free, frames))] if gap]


def scan(blocks: Iterable[Clip], still: Sequence[Span], *, expected: Expected | None) -> DriveFigures:
    """Return the figures of a drive that comes as clips following each other.

    `still` is sorted and disjoint. There the drive has to be 0, or to the nearest 24-bit step what `expected` returns.
    """
    frames, peak, stray, at = 0, 0.0, 0, 0
    for clip in blocks:
        frames = clip.span.stop
        loudest = max(float(clip.heard.max()), -float(clip.heard.min()))
        peak = max(peak, loudest)
        if loudest == 0.0 and expected is None:
            continue  # most of a muted drive: nothing can stray
        while at < len(still) and still[at].stop <= clip.start:
            at += 1
        for inside in _meeting(still, at, clip.span):
            stray += _strays(clip.slice(inside).heard, expected(inside) if expected else None)
    return DriveFigures(frames, peak, stray)


def _meeting(spans: Sequence[Span], first: int, clip: Span) -> Iterator[Span]:
    """Yield the part inside a clip of each span that meets it, beginning with the span at index `first`."""
    for index in range(first, len(spans)):
        if spans[index].start >= clip.stop:
            return
        yield spans[index] & clip


def _strays(samples: NDArray[np.floating], expected: NDArray[np.float64] | None) -> int:
    if expected is None:
        return int(np.count_nonzero(samples))
    playable = np.clip(expected, -1.0, 1.0 - _STEP_24_BIT)
    return int(np.count_nonzero(np.abs(samples - playable) > _STEP_24_BIT))


def moving_spans(blocks: Iterable[Clip], *, still: int) -> list[Span]:
    """Return where the drive moves: from a sample that is not 0 to the next `still` samples that are."""
    found: list[Span] = []
    for clip in blocks:
        moving = np.flatnonzero(clip.heard)
        if not moving.size:
            continue
        breaks = np.flatnonzero(np.diff(moving) > still)
        firsts = moving[np.concatenate([[0], breaks + 1])] + clip.start
        lasts = moving[np.concatenate([breaks, [moving.size - 1]])] + clip.start + 1
        for first, last in zip(firsts.tolist(), lasts.tolist(), strict=True):
            if found and first - found[-1].stop < still:
                found[-1] = Span(found[-1].start, last)
            else:
                found.append(Span(first, last))
    return found

"""One pass over the drive's file: its length, its peak, and what moves where there is no window or a window fades."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..model import Clip, Span, Window

Expected = Callable[[Span], NDArray[np.float64]]

_STEP_24_BIT = 2.0**-23
_STEP_16_BIT = 2.0**-15


@dataclass(frozen=True)
class DriveFigures:
    """The number of frames, the peak, and how many samples are not what they should be.

    `stray` lie outside windows, `unfaded` in their fades.
    """

    frames: int
    peak: float
    stray: int
    unfaded: int = 0


@dataclass(frozen=True, eq=False)
class Fade:
    """Where a window fades in or out, and the weight of its drive there, shape (frames,)."""

    span: Span
    weights: NDArray[np.float64]


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


def fades_of(windows: Iterable[Window]) -> list[Fade]:
    """Return where windows, which may be listed more than once, fade; in order."""
    found = []
    for window in sorted(set(windows)):
        if window.fits_fades:
            rising, falling = dsp.fade(window.fade_in_samples), dsp.fade(window.fade_out_samples)[::-1]
            found.append(Fade(Span(window.start, window.start + len(rising)), rising))
            found.append(Fade(Span(window.stop - len(falling), window.stop), falling))
    return sorted((fade for fade in found if fade.span), key=lambda fade: fade.span)


def scan(
    blocks: Iterable[Clip], still: Sequence[Span], *, expected: Expected | None, fades: Sequence[Fade] = ()
) -> DriveFigures:
    """Return the figures of a drive that comes as clips following each other.

    `still` is sorted and disjoint. There the drive has to be 0, or what `expected` returns, to a step of 24 bits; of 16
    where all of it is in such steps, as an editor may have saved it.
    In `fades`, sorted, it may be as far from that as a window's drive within the limit is with its weight w(n):

        |drive(n) - expected(n)| <= w(n) (1 + |expected(n)|)        to a step of 16 bits
    """
    frames, peak, unfaded, at, fade_at = 0, 0.0, 0, 0, 0
    strays, is_coarse = np.zeros(2, np.int64), True
    for clip in blocks:
        frames = clip.span.stop
        loudest = max(float(clip.heard.max()), -float(clip.heard.min()))
        peak = max(peak, loudest)
        if loudest == 0.0 and expected is None:
            continue  # most of a muted drive: nothing can stray
        while at < len(still) and still[at].stop <= clip.start:
            at += 1
        for inside in _meeting(still, at, clip.span):
            strays += _strays(clip.slice(inside).heard, expected(inside) if expected else None)
        while fade_at < len(fades) and fades[fade_at].span.stop <= clip.start:
            fade_at += 1
        for fade in islice(fades, fade_at, None):
            if fade.span.start >= clip.span.stop:
                break
            unfaded += _unfaded(clip, fade, expected)
        is_coarse = is_coarse and _is_coarse(clip.heard)
    return DriveFigures(frames, peak, int(strays[1 if is_coarse else 0]), unfaded)


def _meeting(spans: Sequence[Span], first: int, clip: Span) -> Iterator[Span]:
    """Yield the part inside a clip of each span that meets it, beginning with the span at index `first`."""
    for index in range(first, len(spans)):
        if spans[index].start >= clip.stop:
            return
        yield spans[index] & clip


def _strays(samples: NDArray[np.floating], expected: NDArray[np.float64] | None) -> tuple[int, int]:
    """Return how many samples are not what is expected, to a step of 24 bits and to one of 16."""
    if expected is None:
        return (int(np.count_nonzero(samples)),) * 2
    fine, coarse = (
        int(np.count_nonzero(np.abs(samples - np.clip(expected, -1.0, 1.0 - step)) > step))
        for step in (_STEP_24_BIT, _STEP_16_BIT)
    )
    return fine, coarse


def _is_coarse(samples: NDArray[np.floating]) -> bool:
    """Return whether all samples are in steps of 16 bits."""
    steps = samples / _STEP_16_BIT
    return bool((steps == np.round(steps)).all())


def _unfaded(clip: Clip, fade: Fade, expected: Expected | None) -> int:
    inside = fade.span & clip.span
    if not inside:
        return 0
    weights = fade.weights[inside.start - fade.span.start : inside.stop - fade.span.start]
    dry = np.clip(expected(inside), -1.0, 1.0) if expected else np.zeros(len(inside))
    beside = np.abs(clip.slice(inside).heard - dry)
    return int(np.count_nonzero(beside > weights * (1.0 + np.abs(dry)) + _STEP_16_BIT))


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

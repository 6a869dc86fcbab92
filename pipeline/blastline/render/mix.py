"""The film's drive, put together from its windows and its background in a single pass."""

from collections.abc import Iterable, Iterator

import numpy as np

from ..model import Background, Clip, Span
from .drive import RenderedWindow


def compose(blocks: Iterable[Clip], rendered: Iterable[RenderedWindow], background: Background) -> Iterator[Clip]:
    """Yield the drive in order, as clips of one float64 column.

    With background "mute" these are the windows alone, the drive between them is 0, and `blocks` are not read. With
    "direct" it is the whole film: the driving column of `blocks`, which follow one another, within the limit as the
    windows are, with these in place of it. `rendered` comes sorted and is read as the blocks reach it; memory holds one
    block and one window.
    Raises ValueError where the blocks end before the windows do.
    """
    if background == "mute":
        yield from (done.clip for done in rendered)
        return
    windows = (done.clip for done in rendered)
    window = next(windows, None)
    reached = 0
    for block in blocks:
        reached = block.span.stop
        column = np.clip(block.driving[:, None].astype(np.float64), -1.0, 1.0)  # a mix of channels may exceed 1
        while window is not None and window.start < reached:
            _replace(column, block.start, window)
            if window.span.stop > reached:
                break
            window = next(windows, None)
        yield Clip(column, block.rate_hz, block.start)
    if window is not None:
        raise ValueError(f"a window reaches to sample {window.span.stop}, the film only to {reached}")


def _replace(column: np.ndarray[tuple[int, ...], np.dtype[np.float64]], start: int, window: Clip) -> None:
    """Write the part of a window that meets the column, which begins at sample `start`, into it."""
    both = window.span & Span(start, start + len(column))
    column[both.start - start : both.stop - start] = window.slice(both).samples

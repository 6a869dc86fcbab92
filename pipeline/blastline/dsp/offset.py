"""What a film stands on: a constant that is no sound, told by what comes before, or by the film's opening."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Read = Callable[[int, int], NDArray[np.floating]]

_SILENT = 16  # so many zeros are no chance
_BLOCK_S, _FEWEST_BLOCKS = 0.05, 5
_CLEAR = 4.0  # a constant is this many times what the means of blocks differ by; less is lost in the film's own start
_OPENING_S = 1.0


def opening_frames(frames: int, rate_hz: int) -> int:
    """Return how much of a film's beginning tells what it stands on, where nothing before a window does."""
    return min(frames, round(_OPENING_S * rate_hz))


def opening_level(opening: NDArray[np.floating], rate_hz: int) -> float:
    """Return what a film stands on, of its first `opening_frames`: the median of the means of blocks of 50 ms.

    A shot is over in a few blocks, and hardly moves it. A film that begins in silence stands on 0; so does one where
    those means differ by as much, and one of less than five blocks: there, sound cannot be told from a constant.
    """
    if not opening[:_SILENT].any():
        return 0.0
    block = _block(rate_hz)
    means = opening[: len(opening) // block * block].reshape(-1, block).mean(axis=1, dtype=np.float64)
    if len(means) < _FEWEST_BLOCKS:
        return 0.0
    level = float(np.median(means))
    return level if abs(level) > _CLEAR * float(np.median(np.abs(means - level))) else 0.0


def level_at(window_start: int, read: Read, *, preroll: int, frames: int, rate_hz: int) -> float:
    """Return what a film of so many frames stands on at a window: the level that its pre-roll tells.

    `read` returns the film's samples from one up to another. From rest, a filter hears a constant as a step, and rings
    with that still when its pre-roll is over; where the film ends, what it stands on is a step for a band that runs
    backwards, however the film came there. So who makes a drive and who checks it have to ask here, both. A pre-roll
    that begins with the film tells less than the film's opening.
    """
    if window_start <= preroll:
        return opening_level(read(0, opening_frames(frames, rate_hz)), rate_hz)
    return _level_before(read(window_start - preroll, window_start), rate_hz)


def _level_before(told: NDArray[np.floating], rate_hz: int) -> float:
    """Return the level of what is before a window. Less than five blocks tell no more than their mean.

    The mean of more would take a shot in there for a constant, and leave a step of that where the film ends.
    """
    if len(told) < _FEWEST_BLOCKS * _block(rate_hz):
        return float(told.mean(dtype=np.float64)) if told[:_SILENT].any() else 0.0
    return opening_level(told, rate_hz)


def _block(rate_hz: int) -> int:
    return max(1, round(_BLOCK_S * rate_hz))

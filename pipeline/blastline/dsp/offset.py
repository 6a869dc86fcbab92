"""What a film stands on: a constant that is no sound, told by what comes before, or by the film's opening."""

import numpy as np
from numpy.typing import NDArray

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


def without_offset(samples: NDArray[np.float64], before: int, rate_hz: int) -> NDArray[np.float64]:
    """Return samples less what they stand on, as the first `before` tell, in which filters settle.

    From rest, a filter hears a constant as a step, and rings with that still when its pre-roll is over. A mean would
    take a shot in there for one, and leave a step of that where the film ends. Less than five blocks tell no more.
    """
    told = samples[:before]
    if len(told) < _FEWEST_BLOCKS * _block(rate_hz):
        return samples - told.mean() if told[:_SILENT].any() else samples
    return samples - opening_level(told, rate_hz)


def _block(rate_hz: int) -> int:
    return max(1, round(_BLOCK_S * rate_hz))

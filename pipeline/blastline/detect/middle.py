"""What the middle does not drown: of a row of sounds that the mains hear as the sides do, their verdict counts alone.

mains  ~~~~~~~~~|\\/\\/\\~~~~     the dialogue in the middle goes on through the shot: it rises less, or is another wave
sides  _________|\\/\\_____     a shot beside it: only they can tell
"""

import numpy as np
from numpy.typing import NDArray

from ..ruleset import BurstRules
from ..units import gain_from_db, samples_from_ms
from .gather import gather
from .rows import runs_of
from .segment import BACKGROUND_MS

_BEGINNING_MS, _GUARD_MS = 10.0, 1.0
_DROWNED_DB = 2.0
"""Where a sound rises by so much more in the sides, over what was before it, the middle takes something of it away;
where it rises by so much less, they have only what is left there of something in the middle."""

_ALIKE = 0.8
"""Where it does not, but the waves of both mixes are less alike than that, something in the middle began with it."""

_TOGETHER_MS = 400.0
_SHARE = 0.75
"""What goes on in turns is one gun or one machine, which stands or falls as a whole: it is the mains' where so much of
it is."""


def left_to_mains(
    heard: NDArray[np.bool_], onsets: NDArray[np.intp], *, rate_hz: int, rules: BurstRules
) -> NDArray[np.bool_]:
    """Return which of n sounds of the sides, ascending, the mains can judge, shape (n,), of which `heard` tells each.

    Those are in rows of `fewest_even` and more. What stands alone, or nearly so, has a second chance in the sides: each
    mix may be wrong about it by itself, but a row is many looks at one sound.
    """
    left = np.zeros(onsets.size, np.bool_)
    for row in runs_of(onsets, samples_from_ms(_TOGETHER_MS, rate_hz)):
        left[row] = row.size >= rules.fewest_even and heard[row].mean() >= _SHARE
    return left


def heard_as_well(
    sides: NDArray[np.float32], mains: NDArray[np.float32], onsets: NDArray[np.intp], rate_hz: int
) -> NDArray[np.bool_]:
    """Return which of n sounds of the sides, at indices into both mixes, the mains hear as the sides do, shape (n,)."""
    in_sides, in_mains = (_Beginnings(mix, onsets, rate_hz) for mix in (sides, mains))
    sides_rise, mains_rise = in_sides.peak * in_mains.before, in_mains.peak * in_sides.before  # times both befores
    # what was silent before rises without end, and as much where it was in both
    ratio = np.divide(sides_rise, mains_rise, out=np.where(sides_rise > 0.0, np.inf, 1.0), where=mains_rise > 0.0)
    product = np.abs(np.sum(in_sides.wave * in_mains.wave, axis=1))
    most = np.sqrt(np.sum(in_sides.wave**2, axis=1) * np.sum(in_mains.wave**2, axis=1))
    alike = (product >= _ALIKE * most) & (most > 0.0)  # where the mains are still they hear nothing
    return np.asarray((ratio < gain_from_db(-_DROWNED_DB)) | (alike & (ratio < gain_from_db(_DROWNED_DB))), np.bool_)


class _Beginnings:
    """The first 10 ms of n sounds of a mix, shape (n, frames), their peaks, and the rms before them, shape (n,).

    All is held against the constant that the mix stands on there.
    """

    def __init__(self, mix: NDArray[np.float32], onsets: NDArray[np.intp], rate_hz: int) -> None:
        """Measure the sounds that begin at indices into the mix."""
        frames, reach, guard = (samples_from_ms(ms, rate_hz) for ms in (_BEGINNING_MS, BACKGROUND_MS, _GUARD_MS))
        before = gather(mix, onsets - reach, reach - guard).astype(np.float64)
        constant = before.mean(axis=1, keepdims=True)
        self.wave = gather(mix, onsets, frames).astype(np.float64) - constant
        self.peak = np.max(np.abs(self.wave), axis=1, initial=0.0)
        self.before = np.sqrt(np.mean(np.square(before - constant), axis=1))

"""Samples that are no sound: NaN, infinite, or so large that squaring them would overflow; and those far too loud."""

import math
from dataclasses import dataclass

import numpy as np

from ..errors import SoundtrackError
from .decode import MAX_FAILED_SHARE
from .track import Samples

LIMIT = 1e9
"""180 dB above full scale: beyond any recording, and its square still fits a float32."""

LOUD = 100.0
"""40 dB above full scale: no mix is so loud, but whole numbers stored as floats are, or what a damaged bit made."""


@dataclass(frozen=True, eq=False)
class Mended:
    """Samples without unusable ones, shape (frames, channels): how many are set to 0, and in which frame the first is.

    Where none had to be, `first` is 0. `peak` is the largest magnitude among those that are left.
    """

    samples: Samples
    count: int
    first: int
    peak: float


def mended(samples: Samples) -> Mended:
    """Return the samples with the unusable ones set to 0.

    Sound without any, which is nearly all sound, costs two scans and no copy.
    """
    if samples.size == 0:
        return Mended(samples, 0, 0, 0.0)
    low, high = float(samples.min()), float(samples.max())
    if low > -LIMIT and high < LIMIT:
        return Mended(samples, 0, 0, max(-low, high))
    usable = np.abs(samples) < LIMIT  # False for NaN
    first = int(np.argmin(usable.all(axis=1)))
    count = int(usable.size - np.count_nonzero(usable))
    whole = np.where(usable, samples, np.float32(0.0))
    return Mended(whole, count, first, float(np.abs(whole).max()))


def require_usable(count: int, samples: int) -> None:
    """Raise SoundtrackError where more of a file's samples had to be set to 0 than packets may be lost."""
    if count > MAX_FAILED_SHARE * samples:
        raise SoundtrackError(f"{count} of {samples} samples are NaN, infinite or beyond 1e9; expected sound")


def repair_warning(count: int, first: int) -> str:
    """Return the line for the user."""
    samples, were = ("sample", "was") if count == 1 else ("samples", "were")
    return f"{count} {samples} {were} NaN, infinite or beyond 1e9, and {were} set to 0, first at sample {first}"


def loud_warning(peak: float, first: int) -> str:
    """Return the line for the user where samples are beyond `LOUD`, the first of them in that frame."""
    above_db = 20.0 * math.log10(peak)
    return (
        f"samples reach {peak:.6g}, {above_db:.0f} dB above full scale; expected -1 to 1: the scale is another, or "
        f"samples are damaged, first at sample {first}"
    )

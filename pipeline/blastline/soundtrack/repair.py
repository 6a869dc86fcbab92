"""Samples that are no sound: NaN, infinite, or so large that squaring them would overflow."""

from dataclasses import dataclass

import numpy as np

from ..errors import SoundtrackError
from .decode import MAX_FAILED_SHARE
from .track import Samples

LIMIT = 1e9
"""180 dB above full scale: beyond any recording, and its square still fits a float32."""


@dataclass(frozen=True, eq=False)
class Mended:
    """Samples without unusable ones, shape (frames, channels): how many are set to 0, and in which frame the first is.

    Where none had to be, `first` is 0.
    """

    samples: Samples
    count: int
    first: int


def mended(samples: Samples) -> Mended:
    """Return the samples with the unusable ones set to 0.

    Sound without any, which is nearly all sound, costs two scans and no copy.
    """
    if samples.size == 0 or (samples.min() > -LIMIT and samples.max() < LIMIT):
        return Mended(samples, 0, 0)
    usable = np.abs(samples) < LIMIT  # False for NaN
    first = int(np.argmin(usable.all(axis=1)))
    count = int(usable.size - np.count_nonzero(usable))
    return Mended(np.where(usable, samples, np.float32(0.0)), count, first)


def require_usable(count: int, samples: int) -> None:
    """Raise SoundtrackError where more of a file's samples had to be set to 0 than packets may be lost."""
    if count > MAX_FAILED_SHARE * samples:
        raise SoundtrackError(f"{count} of {samples} samples are NaN, infinite or beyond 1e9; expected sound")


def repair_warning(count: int, first: int) -> str:
    """Return the line for the user."""
    samples, were = ("sample", "was") if count == 1 else ("samples", "were")
    return f"{count} {samples} {were} NaN, infinite or beyond 1e9, and {were} set to 0, first at sample {first}"

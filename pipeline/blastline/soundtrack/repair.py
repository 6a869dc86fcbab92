"""Samples that are no sound: NaN, infinite, or so large that squaring them would overflow."""

import numpy as np

from ..errors import SoundtrackError
from .decode import MAX_FAILED_SHARE
from .track import Samples

LIMIT = 1e9
"""180 dB above full scale: beyond any recording, and its square still fits a float32."""


def mended(samples: Samples) -> tuple[Samples, int, int]:
    """Return the samples with the unusable ones set to 0, how many there were, and the first frame that had one.

    Sound without any, which is nearly all sound, costs two scans and no copy; its first frame is given as 0.
    """
    if samples.size == 0 or (samples.min() > -LIMIT and samples.max() < LIMIT):
        return samples, 0, 0
    usable = np.abs(samples) < LIMIT  # False for NaN
    first = int(np.argmin(usable.all(axis=1)))
    return np.where(usable, samples, np.float32(0.0)), int(usable.size - np.count_nonzero(usable)), first


def require_usable(count: int, samples: int) -> None:
    """Raise SoundtrackError where more of a file's samples had to be set to 0 than packets may be lost."""
    if count > MAX_FAILED_SHARE * samples:
        raise SoundtrackError(f"{count} of {samples} samples are NaN, infinite or beyond 1e9; expected sound")


def repair_warning(count: int, first: int) -> str:
    """Return the line for the user."""
    samples, were = ("sample", "was") if count == 1 else ("samples", "were")
    return f"{count} {samples} {were} NaN, infinite or beyond 1e9, and {were} set to 0, first at sample {first}"

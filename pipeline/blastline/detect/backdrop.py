"""What is heard just before a candidate and of itself, in short: in a loop both come again, elsewhere they do not.

The backdrop is a 50-bit audio fingerprint (Haitsma and Kalker 2002) of the 120 ms that end 10 ms before the onset. A
bit says whether the step from one band to the next one above grows from one frame to the next. Noise is another one
each time: two backdrops of different moments differ by half of their bits, 25 and seldom fewer than 13; of one moment
in two turns of a loop they differ by few, whatever their levels.

Its own sound are 25 levels of its first 15 ms. Two turns of a loop, with noise 10 dB below, are 1.4 dB apart in the
median and in nine of ten cases less than 2.4; different guns are 4 dB and more, but for one pair in ten.
"""

import numpy as np
from numpy.typing import NDArray

from .spectrogram import Spectrograms

BITS = 50
_FRAMES, _BANDS, _JOINED = 11, 6, 5  # until 10 ms before the onset; the bands of the wide spectrogram five by five
_STILL_DB = 0.05
_OWN, _OWN_FRAMES, _OWN_BANDS = slice(5, 20), 5, 5  # the near spectrogram's first 15 ms from the onset, three by four
LEVELS = _OWN_FRAMES * _OWN_BANDS
_LONGEST_PERIOD, _PERIODIC = 5, 0.2
"""In frames: a hum of 50 or 60 Hz repeats itself after 20 or 50 ms, and up to so much of its bits is something else."""


def backdrops(shown: Spectrograms) -> list[int | None]:
    """Return the fingerprint of what is before each candidate; None where it tells nothing.

    That is where half of it and more is silence or does not change, and where it repeats itself: a hum is the same at
    any time, with no loop.
    """
    before = shown.wide[:, :_FRAMES, : _BANDS * _JOINED]
    levels = before.reshape(-1, _FRAMES, _BANDS, _JOINED).mean(axis=3)
    growth = np.diff(np.diff(levels, axis=2), axis=1)
    bits = growth > 0.0
    numbers = bits.reshape(-1, BITS) @ (1 << np.arange(BITS, dtype=np.int64))
    told = 2 * (np.abs(growth) > _STILL_DB).sum(axis=(1, 2)) > BITS
    for period in range(1, _LONGEST_PERIOD + 1):
        told &= (bits[:, period:] != bits[:, :-period]).mean(axis=(1, 2)) > _PERIODIC
    return [number if known else None for number, known in zip(numbers.tolist(), told.tolist(), strict=True)]


def sounds(shown: Spectrograms) -> NDArray[np.int16]:
    """Return the sound of each of n candidates itself, shape (n, LEVELS).

    Levels in dB against its attack, `_OWN_BANDS` at each moment.
    """
    own = shown.near[:, _OWN]
    count, frames, bands = own.shape
    parts = own.reshape(count, _OWN_FRAMES, frames // _OWN_FRAMES, _OWN_BANDS, bands // _OWN_BANDS)
    return np.asarray(np.round(parts.mean(axis=(2, 4))).reshape(count, LEVELS), np.int16)


def hamming_distance(first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the number of bits by which fingerprints differ, of the shape that both broadcast to."""
    return np.asarray(np.bitwise_count(first ^ second), np.int64)

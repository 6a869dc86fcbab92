"""Coded data among samples (SMPTE 337M, IEC 61937): Dolby E, AC-3 and others, carried in bursts where PCM is expected.

A burst begins with two sync words, Pa and Pb, left-justified in the samples of a pair or of one channel. Either is a
usual sample, and both in a row are one place in 10^9 of loud sound: four such places at equal distances are no sound.
"""

import numpy as np
from numpy.typing import NDArray

from .track import Samples

_WORDS = ((16, 0xF872, 0x4E1F), (20, 0x6F872, 0x54E1F), (24, 0x96F872, 0xA54E1F))
"""Bits of a word, Pa and Pb."""

_SHORTEST, _ALIKE = 256, 2
"""Frames: no burst lasts less than the first, and distances that differ by the second are equal, since those of Dolby E
at 29.97 frames a second are 1601 and 1602 in turn. None lasts more than a quarter of a piece."""


def _as_sample(word: int, bits: int) -> np.float32:
    """Return a word as the sample that it is read as; float32 holds 24 bits exactly."""
    return np.float32((word - (1 << bits) if word >> (bits - 1) else word) / (1 << (bits - 1)))


_SYNCS = tuple((_as_sample(first, bits), _as_sample(second, bits)) for bits, first, second in _WORDS)


def first_burst(samples: Samples, heard: NDArray[np.bool_]) -> int | None:
    """Return the first frame of bursts of coded data in channels that are heard; None where there are none.

    `samples` has shape (frames, channels), `heard` (channels,).
    """
    channels = samples.shape[1]
    row = samples.reshape(-1)
    for first, second in _SYNCS:
        places = np.flatnonzero(row == first)
        of_pair = places[(places % channels % 2 == 0) & (places % channels + 1 < channels)]
        for starts, apart in ((of_pair, 1), (places, channels)):
            inside = starts[starts + apart < len(row)]
            synced = inside[row[inside + apart] == second]
            for channel in np.unique(synced % channels):
                found = _regular(synced[synced % channels == channel] // channels)
                if found is not None and (heard[channel] or heard[(channel + apart) % channels]):
                    return found
    return None


def _regular(frames: NDArray[np.int64]) -> int | None:
    """Return the first of four places at equal distances; two bursts may take turns, as with SMPTE 339M time stamps."""
    for step in (1, 2):
        distances = frames[step:] - frames[:-step]
        if len(distances) <= 2 * step:
            continue
        three = np.stack([distances[: -2 * step], distances[step:-step], distances[2 * step :]])
        regular = np.flatnonzero((np.ptp(three, axis=0) <= _ALIKE) & (np.min(three, axis=0) >= _SHORTEST))
        if regular.size:
            return int(frames[regular[0]])
    return None

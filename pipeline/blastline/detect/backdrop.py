"""What is heard just before a candidate, as a number of 50 bits: in a loop it comes again, elsewhere it does not.

A bit says whether the step from one band to the next one above grows from one frame to the next (Haitsma and Kalker
2002, who recognise recordings so). Noise is another one each time: two backdrops of different moments differ by half of
their bits, 25 and seldom fewer than 13; of one moment in two turns of a loop they differ by few, whatever their levels.
"""

import numpy as np
from numpy.typing import NDArray

from .picture import Pictures

BITS = 50
_FRAMES, _BANDS, _JOINED = 11, 6, 5  # until 10 ms before the onset; the bands of the wide picture five by five
_STILL_DB = 0.05


def backdrops(shown: Pictures) -> list[int | None]:
    """Return the backdrop of each candidate, and None where half of it and more is silence or does not change."""
    before = shown.wide[:, :_FRAMES, : _BANDS * _JOINED]
    levels = before.reshape(-1, _FRAMES, _BANDS, _JOINED).mean(axis=3)
    growth = np.diff(np.diff(levels, axis=2), axis=1).reshape(-1, BITS)
    numbers = (growth > 0.0) @ (1 << np.arange(BITS, dtype=np.int64))
    told = 2 * (np.abs(growth) > _STILL_DB).sum(axis=1) > BITS
    return [number if known else None for number, known in zip(numbers.tolist(), told.tolist(), strict=True)]


def bits_apart(first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return by how many bits backdrops differ."""
    return np.asarray(np.bitwise_count(first ^ second), np.int64)

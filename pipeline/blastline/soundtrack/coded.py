"""Coded data among samples, carried where PCM is expected: Dolby E, AC-3 and others (SMPTE 337M, IEC 61937), and DTS.

A burst of SMPTE 337M begins with two sync words, Pa and Pb, left-justified in the samples of a pair or of one channel.
Either is a usual sample, and both in a row are one place in 10^9 of loud sound: four such places at equal distances are
no sound. A frame of DTS (ETSI TS 102 114), as music CDs carry it in a pair, begins with two words and part of a third.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .track import Samples

_WORDS = ((16, 0xF872, 0x4E1F), (20, 0x6F872, 0x54E1F), (24, 0x96F872, 0xA54E1F))
"""Bits of a word, Pa and Pb."""

_DTS_WORDS = (
    (0x1FFF, 0xE800, 0xFFF0, 0x07F0),
    (0x7FFE, 0x8001, 0xFC00, 0xFC00),
    (0xFF1F, 0x00E8, 0xF0FF, 0xF007),
    (0xFE7F, 0x0180, 0x00FC, 0x00FC),
)
"""Two words of 16 bits, which bits of the third are known, and these: of 14 and of 16 bits, then with bytes swapped."""

_SHORTEST, _ALIKE = 256, 2
"""Frames: no burst lasts less than the first, and distances that differ by the second are equal, since those of Dolby E
at 29.97 frames a second are 1601 and 1602 in turn. None lasts more than a quarter of a piece."""


@dataclass(frozen=True)
class Coded:
    """Bursts of coded data: the first frame of them, and what they are called."""

    frame: int
    kind: str


def _as_sample(word: int, bits: int) -> np.float32:
    """Return a word as the sample that it is read as; float32 holds 24 bits exactly."""
    return np.float32((word - (1 << bits) if word >> (bits - 1) else word) / (1 << (bits - 1)))


_SYNCS = tuple((_as_sample(first, bits), _as_sample(second, bits)) for bits, first, second in _WORDS)
_DTS_SYNCS = tuple(
    (np.array([_as_sample(left, 16), _as_sample(right, 16)]).view(np.int64)[0], mask, third)
    for left, right, mask, third in _DTS_WORDS
)


def first_burst(samples: Samples, heard: NDArray[np.bool_]) -> Coded | None:
    """Return where bursts of coded data in channels that are heard begin; None where there are none.

    `samples` has shape (frames, channels), `heard` (channels,).
    """
    channels = samples.shape[1]
    for synced, apart in _synced(samples.reshape(-1), channels):
        for channel in np.unique(synced % channels):
            found = _regular(synced[synced % channels == channel] // channels)
            if found is not None and (heard[channel] or heard[(channel + apart) % channels]):
                return Coded(found, "SMPTE 337M, as of Dolby E or AC-3")
    found = _regular(_dts_frames(samples)) if channels == 2 and np.any(heard) else None
    return None if found is None else Coded(found, "DTS")


def _synced(row: NDArray[np.float32], channels: int) -> Iterator[tuple[NDArray[np.int64], int]]:
    """Yield the places of sync words among all samples in a row, and how far apart the two words are."""
    for first, second in _SYNCS:
        places = np.flatnonzero(row == first)
        of_pair = places[(places % channels % 2 == 0) & (places % channels + 1 < channels)]
        for starts, apart in ((of_pair, 1), (places, channels)):
            inside = starts[starts + apart < len(row)]
            yield inside[row[inside + apart] == second], apart


def _dts_frames(samples: Samples) -> NDArray[np.int64]:
    """Return where frames of DTS begin in a pair of channels, by the first of its forms that has any."""
    pairs = np.ascontiguousarray(samples, np.float32).view(np.int64)[:-1, 0]  # as fast as to compare one channel
    for pair, mask, third in _DTS_SYNCS:
        places = np.flatnonzero(pairs == pair)
        places = places[np.abs(samples[places + 1, 0]) <= 1.0]  # a damaged float is no word, be it NaN or too large
        words = np.rint(samples[places + 1, 0] * np.float32(1 << 15)).astype(np.int64)
        found: NDArray[np.int64] = places[words & mask == third]
        if len(found) > 3:
            return found
    return np.zeros(0, np.int64)


def _regular(frames: NDArray[np.int64]) -> int | None:
    """Return the first of four places at equal distances; two bursts may take turns, as with SMPTE 339M time stamps."""
    for step in (1, 2):
        distances = frames[step:] - frames[:-step]
        three = np.stack([distances[: -2 * step], distances[step:-step], distances[2 * step :]])
        regular = np.flatnonzero((np.ptp(three, axis=0) <= _ALIKE) & (np.min(three, axis=0) >= _SHORTEST))
        if regular.size:
            return int(frames[regular[0]])
    return None

"""The channels of what was decoded last, for those who look back a little: half precision is enough for levels."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from ..model import Span
from .track import Samples


class Recent:
    """A window of all channels that moves along while a film is decoded, in 16 bits a sample."""

    def __init__(self, frames: int) -> None:
        """Keep at least so many of the last frames."""
        self._frames = frames
        self._pieces: deque[tuple[int, NDArray[np.float16]]] = deque()
        self._stop = 0

    def append(self, samples: Samples) -> None:
        """Add the samples that follow, shape (frames, channels), and let go of those that are too old."""
        self._pieces.append((self._stop, np.clip(samples, -_LARGEST, _LARGEST).astype(np.float16)))
        self._stop += samples.shape[0]
        while len(self._pieces) > 1 and self._pieces[1][0] <= self._stop - self._frames:
            self._pieces.popleft()

    def read(self, span: Span) -> Samples | None:
        """Return the samples of a span, or None where they are no longer, or not yet, here."""
        if not self._pieces or span.start < self._pieces[0][0] or span.stop > self._stop or not span:
            return None
        parts = [
            piece[max(0, span.start - start) : max(0, span.stop - start)]
            for start, piece in self._pieces
            if start < span.stop
        ]
        return np.concatenate(parts).astype(np.float32)


_LARGEST = float(np.finfo(np.float16).max)

"""Where sound breaks off into zeros and comes back as abruptly, as where a copy of a file lacks some of its blocks."""

import numpy as np

from .track import Samples

SHORTEST_S, LONGEST_S = 0.005, 3.0
"""Blocks of storage are 4 KiB and more: 5 ms of six channels, 24 bits and 48 kHz. Longer silences are meant."""

_ABRUPT = 10.0**-2.0
"""Sound that is faded, or stops where it crosses zero, is softer than -40 dBFS beside the zeros."""


class Dropouts:
    """What has been seen so far of such places in a track."""

    def __init__(self, rate_hz: int) -> None:
        """Begin before the first frame."""
        self._shortest, self._longest = round(SHORTEST_S * rate_hz), round(LONGEST_S * rate_hz)
        self._every = max(1, self._shortest // 2)  # a frame in so many is looked at first: a lost block has some
        self._frames, self._last_peak = 0, 0.0
        self._since: int | None = None  # where the zeros began that go on at the end of what was seen
        self.count, self.first = 0, 0

    def hear(self, samples: Samples) -> None:
        """Note the next frames, all channels of them, shape (frames, channels)."""
        if not len(samples):
            return
        if self._since is not None or not samples[:: self._every].any(axis=1).all() or not samples[-1].any():
            self._look(samples)
        self._frames += len(samples)
        self._last_peak = float(np.abs(samples[-1]).max())

    def _look(self, samples: Samples) -> None:
        """Find the stretches of zeros; one at the end may go on in the next frames."""
        still = np.asarray(~samples.any(axis=1), np.bool_)
        edges = np.flatnonzero(np.diff(np.concatenate([[self._since is not None], still])))
        for edge in edges.tolist():
            if still[edge]:
                before = float(np.abs(samples[edge - 1]).max()) if edge else self._last_peak
                self._since = self._frames + edge if before >= _ABRUPT else None
            elif self._since is not None:
                length = self._frames + edge - self._since
                if self._shortest <= length <= self._longest and np.abs(samples[edge]).max() >= _ABRUPT:
                    self.first = self.first if self.count else self._since
                    self.count += 1
                self._since = None

"""Where sound breaks off into zeros and comes back as abruptly, as where a copy of a file lacks some of its blocks."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

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
        # frames that far apart are looked at first: a lost block silences so many in a row, soft sound hardly ever does
        self._every = max(1, self._shortest // 4)
        self._in_a_row = max(1, self._shortest // self._every)
        self._frames, self._last_peak = 0, 0.0
        self._since: int | None = None  # where the zeros began that go on at the end of what was seen
        self.count, self.first = 0, 0

    def hear(self, samples: Samples) -> None:
        """Note the next frames, all channels of them, shape (frames, channels)."""
        if not len(samples):
            return
        if self._since is not None or not samples[-1].any() or self._may_hold_one(samples):
            self._look(samples)
        self._frames += len(samples)
        self._last_peak = float(np.abs(samples[-1]).max())

    def _may_hold_one(self, samples: Samples) -> bool:
        """Return whether zeros may begin and end in these frames."""
        still = ~samples[:: self._every].any(axis=1)
        if np.count_nonzero(still) < self._in_a_row:
            return False
        return bool(sliding_window_view(still, self._in_a_row).all(axis=1).any())

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

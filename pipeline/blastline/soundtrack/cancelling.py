"""Where the channels of a mix cancel each other: what they play there is lost in the mix."""

import numpy as np
from numpy.typing import NDArray

from .track import Samples

_STRETCH_S = 0.05
_EVERY = 16
"""One frame in so many is enough for the power of a stretch, and costs next to nothing."""

_LOST = 0.01
"""A mix of channels that have nothing in common has their power in sum; one with less than this share has lost it."""

_LEAST_POWER = 10.0**-5.0  # -50 dBFS: what is softer nobody misses


class Cancelling:
    """What has been seen so far of the channels of one mix, given by their weights, shape (channels,)."""

    def __init__(self, weights: NDArray[np.float32], rate_hz: int) -> None:
        """Begin before the first frame."""
        self._power_weights = weights**2
        self._rate_hz, self._length = rate_hz, max(1, round(_STRETCH_S * rate_hz / _EVERY))
        self._frames, self._stretches, self._lost = 0, 0, 0
        self._left = np.zeros((2, 0), np.float32)
        self._first = 0

    @property
    def lost_s(self) -> float:
        """Return for how long the mix lost what its channels play."""
        return self._lost * self._stretch_s

    @property
    def first_s(self) -> float:
        """Return where it first did."""
        return self._first * self._stretch_s

    def hear(self, samples: Samples, mix: NDArray[np.float32]) -> None:
        """Note the next frames: all channels, shape (frames, channels), and the mix, shape (frames,)."""
        chosen = slice(-self._frames % _EVERY, None, _EVERY)
        self._frames += len(mix)
        frames = samples[chosen]
        powers = np.concatenate([self._left, [(frames * frames) @ self._power_weights, np.square(mix[chosen])]], axis=1)
        whole = powers.shape[1] // self._length * self._length
        self._left = powers[:, whole:]
        channels, mixed = powers[:, :whole].reshape(2, -1, self._length).sum(axis=2)
        lost = np.flatnonzero((mixed < _LOST * channels) & (channels >= _LEAST_POWER * self._length))
        if lost.size and not self._lost:
            self._first = self._stretches + int(lost[0])
        self._lost += lost.size
        self._stretches += len(mixed)

    @property
    def _stretch_s(self) -> float:
        return self._length * _EVERY / self._rate_hz

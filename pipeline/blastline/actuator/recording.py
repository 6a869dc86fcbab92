"""A recording of a measurement: one column of sound that can be read anywhere, with what its levels tell of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import SoundtrackError
from ..model import SoundFile, Span

_SAME = 1e-6
"""Samples this near to the peak, relative to it, stand at the peak: equal in 16 bits and in 24."""

_SILENCE = 1e-7


@dataclass(frozen=True, eq=False)
class Recording:
    """A track that has been heard to its end.

    `mean` is its constant part; `highest` and `lowest` are its peaks above zero and below, 0 where there is none;
    `at_peak` is the share of its samples that stand at either: a stop, or an amplifier with an offset, cuts off one
    side alone.
    """

    name: str
    track: SoundFile
    frames: int
    highest: float
    lowest: float
    mean: float
    at_peak: float

    @property
    def rate_hz(self) -> int:
        """Return the sample rate."""
        return self.track.rate_hz

    @property
    def peak(self) -> float:
        """Return the magnitude of the higher of its peaks."""
        return max(self.highest, -self.lowest)

    def read(self, start: int, frames: int) -> NDArray[np.float64]:
        """Return samples without the constant part, shape (frames,); zeros where the recording does not reach."""
        samples = np.zeros(frames)
        inside = Span(start, start + frames) & Span(0, self.frames)
        if inside:
            samples[inside.start - start : inside.stop - start] = self.track.read(inside).heard - self.mean
        return samples

    def stand_at_peak(self, samples: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which samples, as `read` returns them, stand at a peak."""
        heard = samples + self.mean
        high = (heard >= self.highest * (1.0 - _SAME)) & (heard > 0.0)
        return np.asarray(high | ((heard <= self.lowest * (1.0 - _SAME)) & (heard < 0.0)))


def record(name: str, track: SoundFile) -> Recording:
    """Hear a track to its end and return it as a recording.

    Raises SoundtrackError where it is silent: a constant, or nothing above 1e-7 of full scale.
    """
    frames = 0
    total = squares = 0.0
    upper, lower = _Side(), _Side()
    for block in track.blocks():
        samples = block.heard.astype(np.float64)
        frames += len(samples)
        total += float(np.sum(samples))
        squares += float(np.sum(samples**2))
        upper.hear(samples)
        lower.hear(-samples)
    peak = max(upper.peak, lower.peak)
    deviation = float(np.sqrt(max(squares / frames - (total / frames) ** 2, 0.0)))
    if deviation <= max(_SILENCE, _SAME * peak):
        raise SoundtrackError(f"{name}: is silent; expected a recording of a measurement")
    at_peak = (upper.at_peak + lower.at_peak) / frames
    return Recording(name, track, frames, upper.peak, -lower.peak, total / frames, at_peak)


@dataclass
class _Side:
    """The peak of what lies on one side of zero, and how many samples stand at it."""

    peak: float = 0.0
    at_peak: int = 0

    def hear(self, samples: NDArray[np.float64]) -> None:
        """Take in samples, those on this side positive."""
        highest = float(np.max(samples))
        if highest > self.peak * (1.0 + _SAME):
            self.at_peak = 0
        self.peak = max(self.peak, highest)
        if self.peak > 0.0:
            self.at_peak += int(np.count_nonzero(samples >= self.peak * (1.0 - _SAME)))

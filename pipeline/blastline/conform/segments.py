"""What a path is made of: segments of the old film along lines of the new one, and how alike the films are there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .lines import Line

STEP = 10
"""Frames between two steps of the path: a tenth of a second. Cuts are put to 20 ms afterwards."""

CHANCE_LIKENESS = 0.35
"""How alike two films are by chance: a line gains only what it is more."""


@dataclass(frozen=True)
class MatchedSegment:
    """A piece of the old film, in seconds, that runs along a line of the new one; `alike` is how well, 0 to 1."""

    line: Line
    start_s: float
    stop_s: float
    alike: float

    @property
    def new_span_s(self) -> tuple[float, float]:
        """Return where it lies in the new film."""
        return self.line.at(self.start_s), self.line.at(self.stop_s)

    def outside_s(self, old_s: float) -> float:
        """Return how far outside a moment of the old film is: 0 inside, a hair on the end, which is the next one's."""
        if self.start_s <= old_s < self.stop_s:
            return 0.0
        return max(self.start_s - old_s, old_s - self.stop_s, 1e-9)


@dataclass(frozen=True, eq=False)
class Lane:
    """A line with how alike the films are along it at every step from `first` on, not far from where it was found.

    `likeness`, shape (steps,), is a correlation.
    """

    line: Line
    first: int
    likeness: NDArray[np.float32]

    @property
    def gain(self) -> NDArray[np.float32]:
        """Return how much more alike than by chance the films are, shape (steps,)."""
        return self.likeness - np.float32(CHANCE_LIKENESS)

"""Frames with time stamps, and what may have to be done before one of them: silence filled in, or its front cut off."""

from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol, TypeVar


class Stamped(Protocol):
    """What placement looks at in a frame."""

    @property
    def samples(self) -> int:
        """Return how many samples per channel it has."""

    @property
    def pts(self) -> int | None:
        """Return its time stamp, in units of `time_base`."""

    @property
    def time_base(self) -> Fraction | None:
        """Return the seconds per unit."""


FrameT = TypeVar("FrameT", bound=Stamped)


@dataclass(frozen=True)
class Gap:
    """Samples that the file has lost, to be replaced by silence."""

    samples: int


@dataclass(frozen=True)
class Overlap:
    """The first samples of the next frame, fewer than it has, which the stamps say have been played already."""

    samples: int

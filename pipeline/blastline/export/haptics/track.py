"""What a haptic format is written from: pulses and segments of vibration, on the film's samples."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...model import Span
from .curve import Curve

DriveReader = Callable[[Span], NDArray[np.float64]]
"""Returns the drive over a span of the film that lies inside it, shape (frames,)."""


@dataclass(frozen=True)
class Pulse:
    """A shot or an echo, at its start: the peak of the drive's attack against the limit, and its frequency.

    `event` names the shot; `burst` tells that it is one of automatic fire.
    """

    sample: int
    amplitude: float
    frequency_hz: float
    event: str
    is_echo: bool = False
    burst: bool = False


@dataclass(frozen=True, eq=False)
class VibrationSegment:
    """A time of vibration: its amplitude, from 0 or from the film's first frame to 0, and its frequency in Hz.

    Both begin and end together. The points are as dense as they were read; each format reduces them.
    """

    amplitude: Curve
    frequency_hz: Curve

    @property
    def span(self) -> Span:
        """Return the range from the first to the last point."""
        return Span(int(self.amplitude.samples[0]), int(self.amplitude.samples[-1]))


@dataclass(frozen=True, eq=False)
class HapticTrack:
    """The vibration of a film; pulses and segments in order, segments apart.

    `low_hz` and `high_hz` bound the actuator's band. `silent` names the shots for which the drive is at rest.
    """

    rate_hz: int
    frames: int
    title: str
    actuator: str
    low_hz: float
    high_hz: float
    pulses: tuple[Pulse, ...]
    segments: tuple[VibrationSegment, ...]
    amplitude_error: float
    frequency_error: float
    reel_s: float
    silent: tuple[str, ...] = ()


def ms_gap(rate_hz: int) -> int:
    """Return the least number of samples that last a millisecond: points so far apart never share one.

    >>> ms_gap(48_000), ms_gap(44_100)
    (48, 45)
    """
    return -(-rate_hz // 1000)

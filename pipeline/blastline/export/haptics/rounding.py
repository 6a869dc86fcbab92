"""What a file cannot hold exactly, measured on what was written."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .curve import Curve


@dataclass(frozen=True)
class Rounding:
    """The largest errors of a format's files against the drive's envelope, and how much they hold.

    `time_ms` is of any point or pulse; `amplitude` (1 is the actuator's limit) and `frequency_hz` are of the lines
    between the points against the curves as read, times apart. `notes` tell what else an author has to know.
    """

    time_ms: float = 0.0
    amplitude: float = 0.0
    frequency_hz: float = 0.0
    pulses: int = 0
    points: int = 0
    notes: tuple[str, ...] = ()

    def __or__(self, other: "Rounding") -> "Rounding":
        """Return the rounding of both together."""
        return Rounding(
            max(self.time_ms, other.time_ms),
            max(self.amplitude, other.amplitude),
            max(self.frequency_hz, other.frequency_hz),
            self.pulses + other.pulses,
            self.points + other.points,
            tuple(dict.fromkeys([*self.notes, *other.notes])),
        )

    def __str__(self) -> str:
        """Return one line for people."""
        errors = f"times within {self.time_ms:.2g} ms, amplitudes within {self.amplitude:.2g} of the limit"
        holds = f"{self.pulses} pulses, {self.points} points"
        return "; ".join([f"{holds}: {errors}, frequencies within {self.frequency_hz:.2g} Hz", *self.notes])


def off(dense: Curve, written: Curve) -> float:
    """Return how far the lines between the points that were written are from the curve at most, at its own points."""
    return float(np.max(np.abs(written.at(dense.samples) - dense.values)))


def clipped(frequencies_hz: NDArray[np.float64], low_hz: float, high_hz: float) -> tuple[str, ...]:
    """Return the note that a format's range of frequencies was left, if it was."""
    if np.all((frequencies_hz >= low_hz) & (frequencies_hz <= high_hz)):
        return ()
    return (f"frequencies outside {low_hz:.0f} to {high_hz:.0f} Hz are written as the nearer of these",)


def late_ms(exact_s: NDArray[np.float64], written_s: NDArray[np.float64]) -> float:
    """Return how far times are from where they should be at most, in milliseconds."""
    return float(np.max(np.abs(written_s - exact_s), initial=0.0)) * 1000.0

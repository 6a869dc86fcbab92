"""What a file cannot hold exactly, measured on what was written."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...plurals import counted
from .curve import Curve


@dataclass(frozen=True)
class Rounding:
    """The largest errors of a format's files against the drive's envelope, and how much they hold.

    `time_ms` is of any point or pulse; `amplitude` (1 is the actuator's limit) and `frequency` (a part of it) are of
    the lines between the points against the curves as read, times apart. `notes` are what else an author has to know.
    """

    time_ms: float = 0.0
    amplitude: float = 0.0
    frequency: float = 0.0
    pulses: int = 0
    points: int = 0
    notes: tuple[str, ...] = ()

    def __or__(self, other: "Rounding") -> "Rounding":
        """Return the rounding of both together."""
        return Rounding(
            max(self.time_ms, other.time_ms),
            max(self.amplitude, other.amplitude),
            max(self.frequency, other.frequency),
            self.pulses + other.pulses,
            self.points + other.points,
            tuple(dict.fromkeys([*self.notes, *other.notes])),
        )

    def __str__(self) -> str:
        """Return one line for people."""
        told = (
            f"{counted(self.pulses, 'pulse')}, {counted(self.points, 'point')}: times within {self.time_ms:.2g} ms, "
            f"amplitudes within {self.amplitude:.2g} of the limit, frequencies within {100.0 * self.frequency:.2g} %"
        )
        return "; ".join([told, *self.notes])


def off(dense: Curve, written: Curve) -> float:
    """Return how far the lines between the points that were written are from the curve at most, at its own points."""
    return float(np.max(np.abs(written.at(dense.samples) - dense.values)))


def within(curve: Curve, low_hz: float, high_hz: float) -> tuple[Curve, tuple[str, ...]]:
    """Return frequencies within the range that a format has for them, and the note that some were not."""
    inside = np.clip(curve.values, low_hz, high_hz)
    if np.array_equal(inside, curve.values):
        return curve, ()
    return curve.with_values(inside), (f"frequencies outside {low_hz:.0f} to {high_hz:.0f} Hz are put at its ends",)


def mistuned(dense: Curve, written: Curve) -> float:
    """Return how far written frequencies are from a curve at most, as a part of it."""
    return float(np.max(np.abs(written.at(dense.samples) / dense.values - 1.0)))


def late_ms(exact_s: NDArray[np.float64], written_s: NDArray[np.float64]) -> float:
    """Return how far times are from where they should be at most, in milliseconds."""
    return float(np.max(np.abs(written_s - exact_s), initial=0.0)) * 1000.0

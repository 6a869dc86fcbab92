"""A quantity over time as points with straight lines between them, and fewer points within a stated error."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Curve:
    """Points in order of time: `samples` are frames of the film, strictly ascending; `values` one for each."""

    samples: NDArray[np.int64]
    values: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.samples)

    def at(self, samples: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the values at any frames: on the lines between the points, level before and after all of them."""
        return np.asarray(np.interp(samples, self.samples, self.values), dtype=np.float64)

    def with_values(self, values: NDArray[np.float64]) -> "Curve":
        """Return the curve with other values at the same times."""
        return Curve(self.samples, values)

    def part(self, start: int, stop: int) -> "Curve":
        """Return the curve from one frame to another, with a point at both."""
        inside = (self.samples > start) & (self.samples < stop)
        samples = np.concatenate([[start], self.samples[inside], [stop]])
        return Curve(samples, self.at(samples))


def reduced(curve: Curve, tolerance: float) -> Curve:
    """Return some of the points of a curve, first and last among them, whose lines pass all others within `tolerance`.

    The farthest point is kept and the same is asked on both its sides (Ramer 1972, Douglas and Peucker 1973, with the
    distance in the value alone, as time is exact).
    """
    samples, values = curve.samples.astype(np.float64), curve.values
    kept = {0, len(curve) - 1}
    open_ranges = [(0, len(curve) - 1)]
    while open_ranges:
        first, last = open_ranges.pop()
        if last - first < 2:
            continue
        slope = (values[last] - values[first]) / (samples[last] - samples[first])
        line = values[first] + slope * (samples[first + 1 : last] - samples[first])
        off = np.abs(values[first + 1 : last] - line)
        farthest = int(np.argmax(off))
        if off[farthest] > tolerance:
            middle = first + 1 + farthest
            kept.add(middle)
            open_ranges += [(first, middle), (middle, last)]
    chosen = np.array(sorted(kept))
    return Curve(curve.samples[chosen], curve.values[chosen])

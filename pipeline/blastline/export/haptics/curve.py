"""A quantity over time as points with straight lines between them, and fewer points within a stated error."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Curve:
    """Points in order of time: `samples` are frames of the film, strictly ascending, `values` one for each."""

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
        first, last = np.searchsorted(self.samples, start, "right"), np.searchsorted(self.samples, stop)
        samples = np.concatenate([[start], self.samples[first:last], [stop]])
        return Curve(samples, self.at(samples))


def reduced(curve: Curve, tolerance: float, *, relative: bool = False) -> Curve:
    """Return some of the points of a curve, first and last among them, whose lines pass all others within `tolerance`.

    From a point kept, the lines that pass within the tolerance of each point after it lie in a cone that narrows from
    point to point; the last point that lies in its own cone is the next to keep, so that one pass is enough. A relative
    tolerance is a part of each value, all above 0.
    """
    samples, values = curve.samples.tolist(), curve.values.tolist()
    margins = (tolerance * curve.values if relative else np.full(len(values), tolerance)).tolist()
    kept = [0]
    while kept[-1] < len(samples) - 1:
        start, value = samples[kept[-1]], values[kept[-1]]
        low, high, best = -math.inf, math.inf, kept[-1] + 1
        for at in range(kept[-1] + 1, len(samples)):
            time, rise = samples[at] - start, values[at] - value
            slope = rise / time
            if low <= slope <= high:
                best = at
            low, high = max(low, (rise - margins[at]) / time), min(high, (rise + margins[at]) / time)
            if low > high:
                break
        kept.append(best)
    chosen = np.array(kept)
    return Curve(curve.samples[chosen], curve.values[chosen])

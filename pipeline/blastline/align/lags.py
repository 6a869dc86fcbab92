"""By how many samples a drive is late at each of its shots, and the line through that over the film."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..medians import weighted_median
from .sounds import TimeMap

_STEADY = 0.1
"""So many samples, in the median, the exact lags of one drive lie beside their line; where they scatter more, the drive
is not what was rendered, and no lag of it is exact: one that was made louder and clipped seemed to drift by 78."""

_LEAST_EXACT = 0.25
"""The share of the shots found that has to have an exact lag, or their line says nothing of the film."""

_MOST_LAGS = 400
"""About so many lags are compared, each with each."""


@dataclass(frozen=True)
class ShotLag:
    """A sample of the film, most often a shot's onset, and by how many samples later the drive holds it."""

    sample: float
    lag: float


def line_through(found: Sequence[ShotLag]) -> TimeMap:
    """Return the line through the lags by Theil and Sen: the median slope of all pairs, which strays ignore.

    Each pair weighs as much as its shots are apart (Jaeckel 1972): those of a burst tell little of a film's slope.
    """
    spread = found[:: max(1, len(found) // _MOST_LAGS)]
    samples = np.array([each.sample for each in spread], dtype=np.float64)
    lags = np.array([each.lag for each in spread], dtype=np.float64)
    first, second = np.triu_indices(len(samples), k=1)
    apart = samples[second] - samples[first]
    first, second, apart = first[apart > 0], second[apart > 0], apart[apart > 0]
    slopes = (lags[second] - lags[first]) / apart
    slope = weighted_median(slopes, apart) if len(slopes) else 0.0
    return TimeMap(1.0 + slope, float(np.median(lags - slope * samples)))


def line_through_exact(exact: Sequence[ShotLag], found: Sequence[ShotLag], *, bend: float) -> TimeMap | None:
    """Return the line through exact lags; None where they are too few of all those found, or do not lie on one.

    Those from less than half of the film tell its place, but no slope: the others have to bear it out, but for what
    the limit may bend them by.
    """
    if len(exact) < max(1, _LEAST_EXACT * len(found)):
        return None
    wide = 2 * (exact[-1].sample - exact[0].sample) >= found[-1].sample - found[0].sample
    line = line_through(exact) if wide else TimeMap(1.0, float(np.median([each.lag for each in exact])))
    steady = _scatter(exact, line) <= _STEADY and (wide or _scatter(found, line) <= bend)
    return line if steady else None


def _scatter(found: Sequence[ShotLag], line: TimeMap) -> float:
    """Return how far lags lie from a line, in the median."""
    return float(np.median([abs(each.lag - line.lag(each.sample)) for each in found]))

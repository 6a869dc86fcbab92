"""What the skin makes of a vibration: H_m = (1 / T)^2, eq. (1) of the paper, from a table of thresholds T."""

import numpy as np
from numpy.typing import NDArray

from ..ruleset import PerceptionCurve

Values = NDArray[np.float64]


def sensitivity_db(curve: PerceptionCurve, frequencies_hz: Values) -> Values:
    """Return the level of H_m = (1 / T)^2, 0 dB at the table's most sensitive frequency.

    Between its rows T follows a monotone cubic, in dB over log frequency (Fritsch and Carlson 1980), which has neither
    corners nor bumps of its own; beyond them the curve does not hold, and the result is NaN.
    """
    from scipy.interpolate import PchipInterpolator

    table_db = np.asarray(curve.threshold_db)
    at_db = PchipInterpolator(np.log(np.asarray(curve.frequencies_hz)), table_db, extrapolate=False)(
        np.log(frequencies_hz)
    )
    return np.asarray(-2.0 * (at_db - np.min(table_db)), dtype=np.float64)

"""The inverse of a model, and the band filters that keep it from gaining without bound."""

import math

import numpy as np

from ..ruleset import FitRules, HighPass, LowPass
from .rational import Model, level_db
from .target import FitTarget

_LEAST_LOWPASS, _MOST_HIGHPASS = 3, 4  # orders
_BEYOND = 10.0  # times the band's ends: farther out the band filters make the compensator fall
_POINTS = 2000


def band_filters(model: Model, target: FitTarget, *, rules: FitRules) -> tuple[LowPass, HighPass]:
    """Return the filters that a model's inverse needs.

    The low-pass is at `band_hz`, or where what is known ends, and of one order more than the inverse rises; the
    high-pass at the lowest frequency that is known, and of the order in which the model falls there.
    """
    low_hz, high_hz = target.band_hz
    rumble_hz = max(rules.rumble_hz, low_hz)
    low = LowPass(
        source=f"{rules.band_hz:g} Hz, or where the fit ends; one order more than the compensator rises",
        corner_hz=_rounded(min(rules.band_hz, high_hz)),
        order=max(_LEAST_LOWPASS, model.poles - model.zeros + 1),
    )
    high = HighPass(
        source=f"{rules.rumble_hz:g} Hz, or where the fit begins; of the order in which the response falls there",
        corner_hz=_rounded(rumble_hz),
        order=_fall(model, rumble_hz),
    )
    return low, high


def inversion_db(model: Model, target: FitTarget, *, rules: FitRules) -> float:
    """Return how much more the inverse, with its band filters, gains at its worst frequency than at its best.

    The best is sought where the model was fitted, the worst from a tenth of the lowest frequency to ten times the
    highest.
    """
    low, high = band_filters(model, target, rules=rules)
    frequencies_hz = np.geomspace(target.band_hz[0] / _BEYOND, target.band_hz[1] * _BEYOND, _POINTS)
    gain_db = -level_db(model, frequencies_hz)
    gain_db -= 10.0 * np.log10(1.0 + (frequencies_hz / low.corner_hz) ** (2 * low.order))
    gain_db -= 10.0 * np.log10(1.0 + (high.corner_hz / frequencies_hz) ** (2 * high.order))
    return float(np.max(gain_db) + np.max(level_db(model, np.geomspace(*target.band_hz, _POINTS))))


def peak(model: Model, band_hz: tuple[float, float]) -> tuple[float, float]:
    """Return the frequency in Hz and the level in dB at which a model is strongest in a band."""
    frequencies_hz = np.geomspace(*band_hz, 2 * _POINTS)
    levels = level_db(model, frequencies_hz)
    place = int(np.argmax(levels))
    return float(frequencies_hz[place]), float(levels[place])


def _fall(model: Model, frequency_hz: float) -> int:
    """Return by how many orders the response falls towards low frequencies, at least 1."""
    near = level_db(model, np.array([0.5 * frequency_hz, frequency_hz]))
    orders = float(near[1] - near[0]) / (20.0 * math.log10(2.0))
    return min(max(round(orders), 1), _MOST_HIGHPASS)


def _rounded(frequency_hz: float) -> float:
    return float(f"{frequency_hz:.4g}")

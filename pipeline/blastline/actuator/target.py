"""What a model is fitted to: the actuator's response times the skin's, where both are known."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import RuleError
from ..ruleset import FitRules, PerceptionCurve
from ..units import levels_db
from .measured import MeasuredResponse
from .thresholds import sensitivity_db

Values = NDArray[np.float64]

_STEPS_PER_OCTAVE = 48
_LEAST_OCTAVES = 1.0
_HANN_BANDWIDTH = 1.5
"""Over how many rows of its spectrum a Hann segment spreads noise: that many rows err alike."""

_FEWEST_POINTS = 8


@dataclass(frozen=True, eq=False)
class FitTarget:
    """Felt levels in dB over frequency, shape (points,) each, from the first to the last that the inverse may reach.

    `target_db` is actuator times skin, with notches filled up to the bound of the inverse. `error_db` is the standard
    error of what was measured; `weights` are the shares of the octaves that the points stand for, of sum 1.
    """

    frequencies_hz: Values
    target_db: Values
    error_db: Values
    weights: Values

    @property
    def band_hz(self) -> tuple[float, float]:
        """Return the lowest and the highest frequency."""
        return float(self.frequencies_hz[0]), float(self.frequencies_hz[-1])


def fit_target(
    measured: MeasuredResponse, perception: PerceptionCurve | None, *, rules: FitRules, name: str
) -> FitTarget:
    """Return the product of actuator and skin at no more than 48 points in an octave.

    Raises RuleError where actuator and curve have less than an octave in common, or too few points in it.
    """
    low_hz, high_hz = max(measured.band_hz[0], rules.rumble_hz), min(measured.band_hz[1], rules.highest_hz)
    if perception is not None:
        low_hz, high_hz = max(low_hz, perception.frequencies_hz[0]), min(high_hz, perception.frequencies_hz[-1])
    inside = measured.within(low_hz, high_hz)
    _require_enough(len(inside.frequencies_hz), low_hz, high_hz, name=name, rules=rules)
    frequencies_hz, gain_db, error_db = _grouped(inside)
    felt_db = gain_db if perception is None else gain_db + sensitivity_db(perception, frequencies_hz)
    floor_db = float(np.max(felt_db)) - rules.largest_gain_db
    strong = np.flatnonzero(felt_db >= floor_db)
    ends = slice(int(strong[0]), int(strong[-1]) + 1)
    _require_enough(len(frequencies_hz[ends]), *frequencies_hz[ends][[0, -1]], name=name, rules=rules)
    weights = np.gradient(np.log(frequencies_hz[ends]))
    return FitTarget(
        frequencies_hz[ends],
        np.maximum(felt_db[ends], floor_db),
        error_db[ends],
        weights / np.sum(weights),
    )


def _grouped(measured: MeasuredResponse) -> tuple[Values, Values, Values]:
    """Return frequencies, gains in dB and their standard errors, averaged where rows are denser than needed.

    Within a group all rows count alike: a row that noise has raised also seems to be known better. Noise adds its own
    power to a gain's, which is taken off.
    """
    _, group = np.unique(np.floor(np.log2(measured.frequencies_hz) * _STEPS_PER_OCTAVE), return_inverse=True)
    count = np.bincount(group)
    frequencies_hz = np.exp(np.bincount(group, np.log(measured.frequencies_hz)) / count)
    noise = np.bincount(group, measured.noise_power) / count
    raw = np.bincount(group, measured.gain**2) / count
    power = np.maximum(raw - noise, 0.1 * raw)
    relative = np.sqrt(0.5 * noise / np.maximum(power, 1e-300) * np.minimum(count, _HANN_BANDWIDTH) / count)
    return frequencies_hz, levels_db(np.sqrt(power)), np.asarray(20.0 / math.log(10.0) * relative, dtype=np.float64)


def _require_enough(points: int, low_hz: float, high_hz: float, *, name: str, rules: FitRules) -> None:
    if points < _FEWEST_POINTS or high_hz < low_hz * 2.0**_LEAST_OCTAVES:
        where = f"{points} points from {low_hz:.4g} to {high_hz:.4g} Hz" if high_hz > low_hz else "nothing"
        raise RuleError(
            f"{name}: {where} to fit: what is known of actuator and skin, no weaker than {rules.largest_gain_db:g} dB "
            f"below the peak; expected at least {_FEWEST_POINTS} points over an octave"
        )

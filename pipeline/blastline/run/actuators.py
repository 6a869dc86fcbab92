"""An actuator's figures."""

from pathlib import Path

import numpy as np

from ..dsp import compensator, felt_response
from ..ruleset import load_actuator
from ..units import levels_db

_TABLE_HZ = (1.0, 3.18, 10.0, 20.0, 31.5, 50.0, 80.0, 100.0, 150.0, 200.0, 292.0, 400.0, 500.0, 700.0, 1000.0, 2000.0)


def actuator_table(name: str, rules: Path | None = None) -> list[tuple[float, float, float, float]]:
    """Return rows of frequency in Hz, level and phase (degrees) of what is felt, and level of the compensator, in dB.

    Raises RuleError for a profile that does not exist or does not fit.
    """
    profile, _ = load_actuator(name, rules)
    frequencies_hz = np.array(_TABLE_HZ)
    felt = felt_response(profile).at(frequencies_hz)
    drive = compensator(profile).at(frequencies_hz)
    columns = (frequencies_hz, levels_db(np.abs(felt)), np.degrees(np.angle(felt)), levels_db(np.abs(drive)))
    return [(float(f), float(level), float(phase), float(gain)) for f, level, phase, gain in zip(*columns, strict=True)]

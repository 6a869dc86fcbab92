"""The step down the slope of |H u - t| that tells a best drive: however sharply a seat rings, it never overshoots."""

from pathlib import Path

import numpy as np
import pytest

from align_films import RATE_HZ, RULES, Held
from blastline import dsp
from blastline.align.comparison import Comparison, compare
from blastline.align.sounds import Sound
from blastline.ruleset import load_actuator
from checked_films import seat


def shared_with(path: Path, resonance_hz: float, q: float) -> Comparison:
    silence = Sound(Held(np.zeros(RATE_HZ), RATE_HZ), RATE_HZ)
    return compare(
        silence,
        silence,
        profile=load_actuator(seat(path, resonance_hz, q))[0],
        rules=RULES,
        lead_ms=1.0,
        preroll_ms=600.0,
        phase="causal",
        background="mute",
        level_db=0.0,
        corner_ms=0.25,
    )


@pytest.mark.parametrize(("resonance_hz", "q"), [(292.0, 5.0), (292.0, 300.0), (1003.0, 1000.0), (2998.0, 1500.0)])
def test_a_step_down_the_slope_takes_a_drive_nearer_to_what_is_wanted(
    tmp_path: Path, resonance_hz: float, q: float
) -> None:
    """The worst drive for that is the resonance itself, of which a step changes most."""
    shared = shared_with(tmp_path / "seat.toml", resonance_hz, q)
    sounds = np.repeat([1.0, 0.0], RATE_HZ)  # H rings on, and is at rest again at the end
    drive = sounds * np.sin(2.0 * np.pi * resonance_hz * np.arange(2 * RATE_HZ) / RATE_HZ)
    apart = dsp.run_filter(shared.felt, drive)
    stepped = dsp.run_filter(shared.felt, drive - sounds * shared.step * shared.adjoint(apart))
    assert np.sum(stepped**2) < np.sum(apart**2)

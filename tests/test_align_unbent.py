"""The lag that the actuator's limit cannot bend is told where what is felt tells it, and nowhere else."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.align.found import _unbent
from blastline.units import samples_from_ms

RATE_HZ, BEND_MS = 48_000, 0.1
PATTERN = slice(100, 100 + RATE_HZ // 50)
SHARED = SimpleNamespace(
    bend=RATE_HZ * BEND_MS / 1000.0, bend_ms=BEND_MS, samples=lambda ms: samples_from_ms(ms, RATE_HZ)
)


def lag(intended: NDArray[np.float64], felt: NDArray[np.float64]) -> float | None:
    """Return by how many samples a drive that is free everywhere is told to be late, None where nothing tells."""
    adjoints = SimpleNamespace(intended=intended, felt=felt)
    read = SimpleNamespace(adjoints=adjoints, felt=SimpleNamespace(free=np.ones(intended.size, bool)))
    found = _unbent(cast("Any", SHARED), cast("Any", read), PATTERN)
    return None if found is None else found.lag


def sound(rng: np.random.Generator, slowness: int) -> NDArray[np.float64]:
    """Return noise up to about twice the rate over `slowness`."""
    return np.convolve(rng.standard_normal(PATTERN.stop + 200), np.hanning(slowness), "same")


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("late", [-3, 0, 2])
@pytest.mark.parametrize("slowness", [20, 60, 200])
def test_what_is_felt_as_it_was_intended_tells_its_lag_and_what_has_nothing_of_it_tells_none(
    seed: int, late: int, slowness: int
) -> None:
    rng = np.random.default_rng(seed)
    intended, other = sound(rng, slowness), sound(rng, slowness)
    felt = np.roll(intended, late)
    assert lag(intended, felt + 0.002 * other) == pytest.approx(late, abs=0.2)
    assert lag(intended, other) is None
    assert lag(intended, -felt) is None

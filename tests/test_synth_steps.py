"""What walks: a floor that gives way is heard as a soft, low blow that is soon over."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.synth.steps import footsteps, hooves, soft_step

RATE_HZ = 48_000
Maker = Callable[[np.random.Generator, int], NDArray[np.float64]]


def share_above(samples: NDArray[np.float64], hz: float) -> float:
    """Return how much of the energy lies above a frequency."""
    energy = np.abs(np.fft.rfft(samples, RATE_HZ)) ** 2
    return float(energy[round(hz) :].sum() / energy.sum())


@pytest.mark.parametrize("seed", range(40))
def test_a_soft_step_lacks_the_highs_and_is_soon_over(seed: int) -> None:
    samples = soft_step(np.random.default_rng(seed), RATE_HZ)
    assert np.abs(samples).max() == pytest.approx(1.0)
    assert share_above(samples, 6_000.0) < 0.2
    energy = np.cumsum(samples**2) / np.sum(samples**2)
    assert np.argmax(energy > 0.95) < 0.25 * RATE_HZ


def test_most_soft_steps_take_milliseconds_to_rise() -> None:
    rises_ms = [
        np.argmax(np.abs(soft_step(np.random.default_rng(seed), RATE_HZ)) >= 0.5) * 1e3 / RATE_HZ for seed in range(100)
    ]
    assert np.percentile(rises_ms, 10) > 1.0
    assert np.max(rises_ms) < 20.0


@pytest.mark.parametrize("make", [footsteps, hooves, soft_step])
@pytest.mark.parametrize("seed", range(5))
def test_another_rate_walks_the_same_way(make: Maker, seed: int) -> None:
    lengths_s = [len(make(np.random.default_rng(seed), rate_hz)) / rate_hz for rate_hz in (44_100, 96_000)]
    assert lengths_s[0] == pytest.approx(lengths_s[1], abs=0.01)


def test_who_walks_keeps_a_pace_of_some_tenths_of_a_second() -> None:
    lengths_s = [len(footsteps(np.random.default_rng(seed), RATE_HZ)) / RATE_HZ for seed in range(60)]
    assert max(lengths_s) < 7 * 1.2 + 3.0
    assert np.median(lengths_s) > 0.5

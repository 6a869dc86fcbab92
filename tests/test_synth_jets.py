"""Guns of much gas: no two rounds are alike, and they fire in ones, twos and bursts, and again after a rest."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.synth import jet_shot, outdoor_shot

RATE_HZ = 48_000


def rounds_alike(samples: NDArray[np.float64], onsets: tuple[int, ...]) -> float:
    """Return how alike the first two rounds of a gun are in their first 10 ms."""
    first, second = (samples[at : at + RATE_HZ // 100] for at in onsets[:2])
    return float(abs(first @ second) / np.sqrt((first @ first) * (second @ second)))


@pytest.mark.parametrize("seed", range(30))
def test_a_firing_has_a_peak_of_one_and_rounds_where_it_says(seed: int) -> None:
    samples, onsets = jet_shot(np.random.default_rng(seed), RATE_HZ)
    again, same = jet_shot(np.random.default_rng(seed), RATE_HZ)
    assert np.array_equal(samples, again)
    assert onsets == same
    assert np.isfinite(samples).all()
    assert np.abs(samples).max() == pytest.approx(1.0)
    assert onsets[0] == 0
    assert (np.diff(onsets) > 0.035 * RATE_HZ).all()
    assert onsets[-1] < len(samples) <= 6 * RATE_HZ
    for onset in onsets:
        assert np.abs(samples[onset : onset + RATE_HZ // 20]).max() > 0.005


def test_another_rate_fires_at_the_same_times() -> None:
    for seed in range(20):
        _, onsets = jet_shot(np.random.default_rng(seed), RATE_HZ)
        _, others = jet_shot(np.random.default_rng(seed), 44_100)
        assert np.array(others) / 44_100 == pytest.approx(np.array(onsets) / RATE_HZ, abs=1 / 44_100)


def test_singles_pairs_and_bursts_come_and_many_fire_again_after_a_rest() -> None:
    firings = [np.diff(jet_shot(np.random.default_rng(seed), RATE_HZ)[1]) / RATE_HZ for seed in range(300)]
    single = np.mean([gaps.size == 0 for gaps in firings])
    pair = np.mean([gaps.size == 1 and gaps[0] < 0.45 for gaps in firings])
    again = np.mean([(gaps > 0.46).any() for gaps in firings])
    assert single > 0.15
    assert pair > 0.15
    assert again > 0.1
    assert max(gaps.size for gaps in firings) > 12


def test_rounds_are_less_alike_than_those_whose_wave_is_louder_than_their_gas() -> None:
    def alike(shot: Callable[..., tuple[Any, ...]]) -> list[float]:
        fired = (shot(np.random.default_rng(seed), RATE_HZ)[:2] for seed in range(150))
        return [rounds_alike(*each) for each in fired if len(each[1]) > 1 and each[1][1] > 0.08 * RATE_HZ]

    jets, waves = alike(jet_shot), alike(outdoor_shot)
    assert np.median(jets) < 0.4
    assert np.median(jets) < 0.7 * np.median(waves)

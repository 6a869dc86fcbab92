"""Sounds as designers build them: shots rise at once, are copied or made anew; what resembles them does not rise so."""

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.synth import designed_negative, designed_shot
from blastline.synth.designed import backwards, fired_in_a_row, layered_round, played_by_sampler, staged_round, swell

RATE_HZ = 48_000


def rise_ms(samples: NDArray[np.float64]) -> float:
    """Return how long the envelope over 1 ms takes from a tenth of its top to nine tenths of it."""
    smooth = np.convolve(np.abs(samples), np.ones(48) / 48, "full")
    top = smooth[: RATE_HZ // 4].max()
    return float(np.argmax(smooth >= 0.9 * top) - np.argmax(smooth >= 0.1 * top)) * 1000 / RATE_HZ


@pytest.mark.parametrize("seed", range(40))
def test_a_shot_has_a_peak_of_one_and_is_the_same_each_time(seed: int) -> None:
    samples, onsets = designed_shot(np.random.default_rng(seed), RATE_HZ)
    again, same = designed_shot(np.random.default_rng(seed), RATE_HZ)
    assert np.array_equal(samples, again)
    assert onsets == same
    assert onsets[0] == 0
    assert np.abs(samples).max() == pytest.approx(1.0)


@pytest.mark.parametrize("seed", range(40))
def test_the_rounds_of_a_burst_come_as_fast_as_guns_fire(seed: int) -> None:
    samples, onsets = designed_shot(np.random.default_rng(seed), RATE_HZ)
    gaps_ms = np.diff(onsets) * 1000 / RATE_HZ
    assert ((gaps_ms > 37) & (gaps_ms < 180)).all()
    for onset in onsets:  # every round begins where it is said to
        assert np.abs(samples[onset : onset + RATE_HZ // 50]).max() > 0.005


def test_layers_begin_within_some_milliseconds_and_rise_faster_than_a_swell() -> None:
    shots = [rise_ms(layered_round(np.random.default_rng(seed), RATE_HZ)) for seed in range(60)]
    swells = [rise_ms(swell(np.random.default_rng(seed), RATE_HZ)) for seed in range(60)]
    assert np.median(shots) < 8.0
    assert np.median(swells) > 3.0 * np.median(shots)


def test_a_shot_in_stages_is_often_loudest_long_after_it_began() -> None:
    """And each stage is of its own kind: it is no copy of the beginning, as a round of a burst is."""
    loudest_ms = []
    for seed in range(60):
        power = np.convolve(np.square(staged_round(np.random.default_rng(seed), RATE_HZ)), np.ones(240), "valid")
        assert power[: RATE_HZ // 50].max() > 1e-4 * power.max()
        loudest_ms.append(float(np.argmax(power)) * 1000 / RATE_HZ)
    assert 0.3 < np.mean(np.array(loudest_ms) > 12.0) < 0.9
    assert max(loudest_ms) < 300.0


def test_rounds_of_one_sample_are_copies_of_it_but_for_their_level() -> None:
    one = layered_round(np.random.default_rng(4), RATE_HZ)[: RATE_HZ // 40]  # over before the next
    row, places = fired_in_a_row(np.random.default_rng(5), [one] * 6, RATE_HZ)
    for at in places:
        heard = row[at : at + one.size]
        assert abs(np.corrcoef(heard, one)[0, 1]) > 0.999


def test_backwards_the_end_is_the_loudest() -> None:
    for seed in range(20):
        power = np.square(backwards(np.random.default_rng(seed), RATE_HZ))
        assert power[power.size // 2 :].sum() > power[: power.size // 2].sum()


def test_a_sampler_of_few_bits_says_few_values() -> None:
    tone = np.sin(2 * np.pi * 440 * np.arange(RATE_HZ // 4) / RATE_HZ)
    played = [played_by_sampler(np.random.default_rng(seed), tone, RATE_HZ) for seed in range(20)]
    values = [np.unique(np.round(each, 9)).size for each in played]
    assert min(values) <= 2 * 2**7 + 1
    assert max(values) > 1_000  # behind a filter


def test_negatives_are_sound_and_the_same_each_time() -> None:
    for seed in range(60):
        samples = designed_negative(np.random.default_rng(seed), RATE_HZ)
        assert np.isfinite(samples).all()
        assert np.abs(samples).max() == pytest.approx(1.0)
        assert np.array_equal(samples, designed_negative(np.random.default_rng(seed), RATE_HZ))

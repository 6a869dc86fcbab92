"""Guns near a microphone outdoors: next to nothing between the blast and what comes back; and what hands do there."""

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.synth import handling, outdoor_shot, random_shot

RATE_HZ = 48_000
SEEDS = range(60)


def dry_db(samples: NDArray[np.float64], onset: int, *, from_ms: float, to_ms: float) -> float:
    """Return the energy of a stretch after the onset against that of the first 25 ms."""
    first, start, stop = (onset + round(each * RATE_HZ / 1000) for each in (25.0, from_ms, to_ms))
    attack, later = np.sum(samples[onset:first] ** 2), np.sum(samples[start:stop] ** 2)
    return float(10.0 * np.log10(later / attack + 1e-9))


@pytest.mark.parametrize("seed", range(30))
def test_a_shot_has_a_peak_of_one_and_begins_where_it_says(seed: int) -> None:
    samples, onsets, _ = outdoor_shot(np.random.default_rng(seed), RATE_HZ)
    again, same, _ = outdoor_shot(np.random.default_rng(seed), RATE_HZ)
    assert np.array_equal(samples, again)
    assert onsets == same
    assert np.isfinite(samples).all()
    assert np.abs(samples).max() == pytest.approx(1.0)
    gaps_ms = np.diff(onsets) * 1000 / RATE_HZ
    assert ((gaps_ms > 35.0) & (gaps_ms < 175.0)).all()
    for onset in onsets:
        assert np.abs(samples[onset : onset + RATE_HZ // 50]).max() > 0.02


def test_nothing_is_heard_before_the_blast_but_a_bullets_shock() -> None:
    early = []
    for seed in range(150):
        samples, onsets, shock = outdoor_shot(np.random.default_rng(seed), RATE_HZ)
        assert shock == ((0,) if onsets[0] else ())
        if onsets[0]:
            early.append(onsets[0] / RATE_HZ)
        else:
            assert np.abs(samples[:480]).max() > 0.0
    assert 0.04 < len(early) / 150 < 0.18
    assert min(early) > 0.007
    assert max(early) < 0.26


def test_near_a_gun_there_is_less_between_the_blast_and_its_return_than_in_a_film() -> None:
    """Recorded near and outdoors 50-100 ms after the onset are 25 to 50 dB under the first 25; in films' places 10."""
    outdoors, films = [], []
    for seed in range(80):
        samples, onsets, _ = outdoor_shot(np.random.default_rng(seed), RATE_HZ)
        if len(onsets) == 1:
            outdoors.append(dry_db(samples, onsets[0], from_ms=50.0, to_ms=100.0))
        if seed < 40:
            film, onset, _ = random_shot(np.random.default_rng(seed), RATE_HZ)
            films.append(dry_db(film, onset, from_ms=50.0, to_ms=100.0))
    assert np.median(outdoors) < np.median(films) - 8.0
    assert np.quantile(outdoors, 0.1) < -25.0


def test_a_click_of_hands_is_short_and_often_one_of_several() -> None:
    loud_ms = []
    for seed in SEEDS:
        samples = handling(np.random.default_rng(seed), RATE_HZ)
        assert np.isfinite(samples).all()
        assert np.abs(samples).max() == pytest.approx(1.0)
        assert np.array_equal(samples, handling(np.random.default_rng(seed), RATE_HZ))
        top = int(np.argmax(np.abs(samples)))
        loud_ms.append(np.count_nonzero(np.abs(samples[top : top + RATE_HZ // 20]) > 0.1) * 1000 / RATE_HZ)
    assert np.median(loud_ms) < 10.0

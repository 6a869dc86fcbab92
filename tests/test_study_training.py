"""Networks learn from examples. PyTorch comes with the extra `train`; without it there is nothing to test."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect.contrast import contrasts
from blastline.detect.network import NetworkFile, network_from, network_log_odds
from blastline.detect.spectrogram import NEAR, WIDE, Spectrograms
from blastline.study.networks import SIZES, between, size_of
from blastline.study.training import FINE_TUNING, SETTINGS, Examples, fine_tune, fit_network

pytest.importorskip("torch")

QUICK = replace(SETTINGS, epochs=5, batch=32)
FEATURES = 6


def examples(count: int, seed: int, *, late_in: str = "near") -> Examples:
    """Return examples of which the shots are louder late in one spectrogram and in their third feature."""
    rng = np.random.default_rng(seed)
    shots = rng.random(count) < 0.5
    near, wide = (rng.normal(-20.0, 6.0, (count, r.frames, r.bands)) for r in (NEAR, WIDE))
    late = near if late_in == "near" else wide
    late[shots, 12:] += 9.0
    rows = rng.normal(40.0, 5.0, (count, FEATURES))
    rows[shots, 2] += 5.0
    return Examples(near.astype(np.float16), wide.astype(np.float16), rows.astype(np.float32), shots)


@pytest.mark.parametrize(("averaged", "size"), [(False, "small"), (True, "small"), (False, "large")])
def test_a_network_tells_what_it_was_taught_from_what_it_was_not_shown(averaged: bool, size: str) -> None:
    network = fit_network(examples(600, 1), 3, averaged=averaged, size=size, settings=QUICK)
    assert size_of(network) == SIZES[size]
    fresh = examples(300, 2)
    assert np.mean((said(network, fresh) > 0) == fresh.shots) > 0.95


def said(network: NetworkFile, of: Examples) -> NDArray[np.float64]:
    spectrograms = Spectrograms(of.near.astype(np.float32), of.wide.astype(np.float32))
    return network_log_odds(network_from(network), of.rows.astype(np.float64), contrasts(spectrograms))


@pytest.mark.parametrize(("averaged", "size"), [(False, "small"), (True, "small"), (False, "large")])
def test_fine_tuning_at_no_learning_rate_changes_little(averaged: bool, size: str) -> None:
    """Only the normalisations look: what was folded away is there again and is folded away once more."""
    known, fresh = examples(600, 1), examples(300, 2)
    network = fit_network(known, 3, averaged=averaged, size=size, settings=QUICK)
    still = replace(FINE_TUNING, epochs=1, learning_rate=0.0, batch=600)
    same = fine_tune(network, known, 4, settings=still)
    odds = said(network, fresh)
    assert np.corrcoef(said(same, fresh), odds)[0, 1] > 0.98
    assert np.mean((said(same, fresh) > 0) == (odds > 0)) > 0.97
    assert same.means == network.means


@pytest.mark.parametrize("averaged", [False, True])
def test_a_fine_tuned_network_knows_the_old_and_the_new(averaged: bool) -> None:
    first = fit_network(examples(600, 1), 3, averaged=averaged, settings=QUICK)
    old, new = examples(300, 2), examples(300, 3, late_in="wide")
    assert np.mean((said(first, new) > 0) == new.shots) < 0.8
    more = [examples(600, 5), examples(600, 6, late_in="wide")]
    both = Examples(*(np.concatenate([getattr(m, f) for m in more]) for f in ("near", "wide", "rows", "shots")))
    tuned = fine_tune(first, both, 3, settings=QUICK)
    for each in (old, new):
        assert np.mean((said(tuned, each) > 0) == each.shots) > 0.93


def test_between_two_networks_lie_both_and_the_way_back_is_the_same() -> None:
    first, second = (
        fit_network(examples(100, 1), seed, averaged=False, settings=replace(QUICK, epochs=1)) for seed in (3, 4)
    )
    assert between(first, second, 0.0) == first
    assert between(first, second, 1.0) == second
    assert between(first, second, 0.25) == between(second, first, 0.75)
    both = [network.head[0].weights for network in (first, second)]
    mean = 0.75 * np.array(both[0]) + 0.25 * np.array(both[1])
    assert np.allclose(between(first, second, 0.25).head[0].weights, mean, rtol=1e-4)


def test_the_same_seed_gives_the_same_network_and_another_one_another() -> None:
    first, again, other = (
        fit_network(examples(100, 1), seed, averaged=True, settings=replace(QUICK, epochs=1)) for seed in (3, 3, 4)
    )
    assert first == again
    assert first.head[-1].weights != other.head[-1].weights

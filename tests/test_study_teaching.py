"""Networks learn from examples. PyTorch comes with the extra `train`; without it there is nothing to test."""

import numpy as np
import pytest

from blastline.detect.network import log_odds, wired
from blastline.detect.picture import NEAR, WIDE, Pictures
from blastline.study.teaching import SETTINGS, Examples, fit_network

pytest.importorskip("torch")

QUICK = SETTINGS | {"epochs": 5, "batch": 32}
FEATURES = 6


def examples(count: int, seed: int) -> Examples:
    """Return examples of which the shots are louder late in the near picture and in their third feature."""
    rng = np.random.default_rng(seed)
    shots = rng.random(count) < 0.5
    near, wide = (rng.normal(-20.0, 6.0, (count, r.frames, r.bands)) for r in (NEAR, WIDE))
    near[shots, 12:] += 9.0
    rows = rng.normal(40.0, 5.0, (count, FEATURES))
    rows[shots, 2] += 5.0
    return Examples(near.astype(np.float16), wide.astype(np.float16), rows.astype(np.float32), shots)


@pytest.mark.parametrize("averaged", [False, True])
def test_a_network_tells_what_it_was_taught_from_what_it_was_not_shown(averaged: bool) -> None:
    network = wired(fit_network(examples(600, 1), 3, averaged=averaged, settings=QUICK))
    fresh = examples(300, 2)
    odds = log_odds(
        network, fresh.rows.astype(np.float64), Pictures(*(p.astype(np.float32) for p in (fresh.near, fresh.wide)))
    )
    assert np.mean((odds > 0) == fresh.shots) > 0.95


def test_the_same_seed_teaches_the_same_and_another_one_something_else() -> None:
    first, again, other = (
        fit_network(examples(100, 1), seed, averaged=True, settings=QUICK | {"epochs": 1}) for seed in (3, 3, 4)
    )
    assert first == again
    assert first.head[-1].weights != other.head[-1].weights

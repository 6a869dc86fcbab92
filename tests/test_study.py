"""Scores: counted as mir_eval counts them."""

from itertools import permutations

import mir_eval
import numpy as np
import pytest

from blastline.study.matching import Counts, count, match


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("window_ms", [2.0, 10.0, 50.0])
def test_matching_is_as_large_as_mir_evals(seed: int, window_ms: float) -> None:
    rng = np.random.default_rng(seed)
    true_ms = np.sort(rng.uniform(0.0, 2000.0, 40))
    found_ms = np.sort(np.concatenate([true_ms[::2] + rng.normal(0.0, 8.0, 20), rng.uniform(0.0, 2000.0, 25)]))
    pairs = match(found_ms, true_ms, window_ms)
    reference = mir_eval.util.match_events(true_ms / 1000.0, found_ms / 1000.0, window_ms / 1000.0)
    assert len(pairs) == len(reference)
    assert len({found for found, _ in pairs}) == len({true for _, true in pairs}) == len(pairs)
    f1, precision, recall = mir_eval.onset.f_measure(true_ms / 1000.0, found_ms / 1000.0, window=window_ms / 1000.0)
    counts = count(found_ms, true_ms, window_ms)
    assert (counts.f1, counts.precision, counts.recall) == pytest.approx((f1, precision, recall))


def test_nothing_to_find_and_nothing_found_is_perfect() -> None:
    empty = np.empty(0)
    assert count(empty, empty, 10.0) == Counts(0, 0, 0)
    assert count(empty, empty, 10.0).f1 == 1.0
    assert count(np.array([1.0]), empty, 10.0).precision == 0.0
    assert count(np.array([1.0]), empty, 10.0).error_rate is None


@pytest.mark.parametrize("seed", range(5))
def test_the_error_rate_is_that_of_its_definition(seed: int) -> None:
    """Mesaros et al. 2016, for events of one kind: no substitutions, (deletions + insertions) / events."""
    rng = np.random.default_rng(seed)
    true_ms = np.sort(rng.uniform(0.0, 30_000.0, 12))
    found_ms = np.sort(np.concatenate([true_ms[::2] + rng.uniform(-600.0, 600.0, 6), rng.uniform(0.0, 30_000.0, 9)]))
    near = mir_eval.util.match_events(true_ms, found_ms, 500.0)
    deletions, insertions = true_ms.size - len(near), found_ms.size - len(near)
    assert count(found_ms, true_ms, 500.0).error_rate == pytest.approx((deletions + insertions) / true_ms.size)


def test_what_is_forgiven_is_neither_right_nor_wrong() -> None:
    counts = count(np.array([100.0, 108.8, 500.0]), np.array([108.8]), 2.0, forgiven_ms=[100.0])
    assert counts == Counts(hits=1, false=1, missed=0)


@pytest.mark.parametrize("seed", range(10))
def test_of_all_largest_matchings_the_nearest_is_taken(seed: int) -> None:
    """Against every order of pairing, with places besides the first."""
    rng = np.random.default_rng(seed)
    true_ms = np.sort(rng.uniform(0.0, 200.0, 4))
    others = [tuple(true_ms[shot] - rng.uniform(5.0, 40.0, rng.integers(0, 3))) for shot in range(4)]
    found_ms = np.sort(rng.uniform(-20.0, 220.0, 6))

    def cost(found: int, shot: int) -> tuple[bool, float]:
        """Return whether a shot's own place is out of reach, and how far away the nearest in reach is."""
        away_ms = [abs(float(found_ms[found]) - place) for place in (float(true_ms[shot]), *others[shot])]
        return away_ms[0] > 30.0, away_ms[0] if away_ms[0] <= 30.0 else min(away_ms)

    def rank(pairs: list[tuple[int, int]]) -> tuple[int, int, float]:
        costs = [cost(*pair) for pair in pairs]
        return len(pairs), -sum(aside for aside, _ in costs), -sum(away for _, away in costs)

    every = [[(found, shot) for shot, found in enumerate(order)] for order in permutations(range(6), 4)]
    best = max(rank([pair for pair in pairs if cost(*pair)[1] <= 30.0]) for pairs in every)
    assert rank(match(found_ms, true_ms, 30.0, others)) == pytest.approx(best)


def test_a_shot_is_met_at_its_shock_only_by_what_is_left() -> None:
    found_ms, true_ms = np.array([900.0, 1015.0]), np.array([1000.0, 1060.0])
    assert match(found_ms, true_ms, 50.0, [(), (900.0,)]) == [(1, 0), (0, 1)]
    assert count(found_ms, true_ms, 50.0, alternatives_ms=[(), (900.0,)]) == Counts(2, 0, 0)
    late = count(np.array([900.0, 1000.0, 1060.0]), true_ms, 50.0, alternatives_ms=[(), (900.0,)])
    assert late == Counts(2, 0, 0)  # the shock of a shot that was found is neither right nor wrong

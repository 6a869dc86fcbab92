"""Loops in films with many candidates."""

import tracemalloc

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect.backdrop import LEVELS
from blastline.detect.loops import LoopCandidates, in_loops
from blastline.ruleset import load_rules

RATE_HZ = 48_000
RULES = load_rules("standard").tier.rows


def candidates(onsets: NDArray[np.intp], seed: int) -> LoopCandidates:
    """Return candidates that are like no other."""
    rng, number = np.random.default_rng(seed), onsets.size
    sounds = rng.normal(-20.0, 10.0, (number, LEVELS))
    return LoopCandidates(
        onsets, np.full(number, -6.0), np.zeros(number, bool), rng.integers(0, 1 << 50, number), sounds
    )


def test_a_loop_is_found_wherever_among_many_candidates_it_lies() -> None:
    rng = np.random.default_rng(1)
    others = np.unique(rng.integers(0, 600 * RATE_HZ, 900))
    for at_s in (0, 150, 280, 500, 590):
        turns = at_s * RATE_HZ + np.arange(4) * 2 * RATE_HZ + 777
        onsets = np.union1d(others, turns)
        heard, its = candidates(onsets, seed=2), np.isin(onsets, turns)
        heard.backdrops[its], heard.sounds[its] = 0b1011, -12.0
        assert in_loops(heard, rate_hz=RATE_HZ, rules=RULES).tolist() == its.tolist()


@pytest.mark.parametrize(("backdrop", "is_loop"), [(0, True), ((1 << 50) - 1, True), (-1, False)])
def test_a_backdrop_that_tells_nothing_tells_of_no_loop(backdrop: int, *, is_loop: bool) -> None:
    """-1 stands for silence and hums, which are before any sound alike."""
    turns = np.arange(4) * 2 * RATE_HZ + 777
    heard = candidates(turns, seed=4)
    heard.backdrops[:], heard.sounds[:] = backdrop, -12.0
    assert in_loops(heard, rate_hz=RATE_HZ, rules=RULES).tolist() == [is_loop] * turns.size


def test_a_machine_of_ten_minutes_takes_less_than_a_kilobyte_for_each_blow() -> None:
    blows = 20 * 600
    heard = candidates(np.arange(blows) * RATE_HZ // 20, seed=3)
    tracemalloc.start()
    try:
        in_loops(heard, rate_hz=RATE_HZ, rules=RULES)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 1024 * blows

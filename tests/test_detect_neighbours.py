"""How a candidate stands among its neighbours, against the same told one by one in plain Python."""

import numpy as np
import pytest

from blastline.detect.bandshape import ATTACK, LOWEST_DB, SEGMENTS_MS
from blastline.detect.neighbours import (
    ALIKE_DB,
    BURST_MS,
    BURST_ROUNDS,
    FARTHEST_DB,
    FUTURE_MS,
    LEVEL_STEPS_DB,
    PAST_MS,
    RIVAL_DB,
    RUN_GAP_MS,
    SHAPE_SEGMENTS,
    as_in_a_burst,
    neighbourhood,
    neighbourhood_names,
)
from blastline.detect.tracks import BANDS

RATE_HZ = 48_000
SHAPE = BANDS + 1, len(SEGMENTS_MS)


def told_one_by_one(times_ms: list[float], levels: np.ndarray, own: int) -> list[float]:
    """The definitions, candidate by candidate."""
    loud = levels[:, -1, ATTACK]
    shape = np.maximum(levels[:, :-1, ATTACK : ATTACK + SHAPE_SEGMENTS] - loud[:, None, None], LOWEST_DB)
    gap = [time - times_ms[own] for time in times_ms]
    level = [other - loud[own] for other in loud]
    apart = [float(np.sqrt(np.mean((shape[other] - shape[own]) ** 2))) for other in range(len(gap))]
    past = [other for other in range(len(gap)) if -PAST_MS <= gap[other] < 0.0]
    future = [other for other in range(len(gap)) if 0.0 < gap[other] <= FUTURE_MS]
    like = [other for other in past + future if apart[other] < ALIKE_DB and abs(level[other]) < RIVAL_DB]
    previous = max((other for other in past if level[other] >= -RIVAL_DB), default=None)
    following = min((other for other in future if level[other] >= -RIVAL_DB), default=None)
    run = sorted([*like, own])
    gaps = np.diff([times_ms[other] for other in run])
    before, after = gaps[: run.index(own)][::-1], gaps[run.index(own) :]

    def lasting(steps: np.ndarray) -> float:
        long = np.flatnonzero(steps > RUN_GAP_MS)
        return float(steps[: long[0] if long.size else None].sum())

    return [
        max((level[other] for other in past), default=LOWEST_DB),
        max((level[other] for other in future), default=LOWEST_DB),
        PAST_MS if previous is None else -gap[previous],
        FUTURE_MS if following is None else gap[following],
        LOWEST_DB if previous is None else level[previous],
        LOWEST_DB if following is None else level[following],
        FARTHEST_DB if previous is None else apart[previous],
        *(sum(level[other] >= bound for other in side) for side in (past, future) for bound in LEVEL_STEPS_DB),
        sum(other in past for other in like),
        sum(other in future for other in like),
        min(2.0, float(gaps.std() / gaps.mean())) if gaps.size >= 3 else 2.0,
        min(RUN_GAP_MS, before[0]) if before.size else RUN_GAP_MS,
        min(RUN_GAP_MS, after[0]) if after.size else RUN_GAP_MS,
        lasting(before),
        lasting(after),
    ]


@pytest.mark.parametrize("count", [1, 2, 40, 400])
def test_it_stands_among_them_as_told_one_by_one(count: int) -> None:
    random = np.random.default_rng(count)
    places = np.cumsum(random.integers(RATE_HZ // 50, RATE_HZ // 3, count)) + 7
    kinds = random.uniform(-50.0, 0.0, (3, *SHAPE))
    levels = kinds[random.integers(0, 3, count)] + random.normal(0.0, 3.0, (count, 1, 1))
    levels += random.normal(0.0, 1.0, levels.shape)
    wanted = np.flatnonzero(random.random(count) < 0.7) if count > 1 else np.array([0])
    rows = neighbourhood(places, levels, wanted, RATE_HZ)
    assert rows.shape == (wanted.size, len(neighbourhood_names()))
    times_ms = (places / RATE_HZ * 1000.0).tolist()
    for row, own in zip(rows, wanted.tolist(), strict=True):
        np.testing.assert_allclose(row, told_one_by_one(times_ms, levels, own), rtol=1e-9, atol=1e-9)


def test_none_wanted_is_no_row() -> None:
    assert neighbourhood(np.zeros(0, np.intp), np.zeros((0, *SHAPE)), np.zeros(0, np.intp), RATE_HZ).shape[0] == 0


@pytest.mark.parametrize("count", [BURST_ROUNDS, 40])
def test_what_goes_on_for_longer_is_as_in_a_burst_and_a_burst_is_what_it_is(count: int) -> None:
    places = np.round(np.arange(count) * (BURST_MS - 1.0) / (BURST_ROUNDS - 1) * RATE_HZ / 1000.0).astype(np.intp)
    rows = neighbourhood(places, np.full((count, *SHAPE), -20.0), np.arange(count), RATE_HZ)
    capped = as_in_a_burst(rows)
    changed = {name for name, same in zip(neighbourhood_names(), (capped == rows).all(axis=0), strict=True) if not same}
    sides = {f"{side}_within{level:g}dB" for side in ("past", "future") for level in LEVEL_STEPS_DB}
    going_on = {"like_past", "like_future", "run_before_ms", "run_after_ms"} | sides
    assert changed == (set() if count == BURST_ROUNDS else going_on)
    assert capped[:, [name.startswith("run_") for name in neighbourhood_names()]].max() <= BURST_MS

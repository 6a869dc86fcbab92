"""The line through a drive's lags: what strays, bursts and bent lags must not do to it."""

from collections.abc import Iterable

import numpy as np
import pytest

from blastline.align.lags import ShotLag, line_through, line_through_exact

SPAN = 6_000_000
BURST = [SPAN - 20_000 + 4_000 * n for n in range(6)]
BENT = [-0.9, -0.6, 0.2, -0.4, 0.4, 0.6]
"""Lags of a burst whose drive was made louder and clipped: none is exact, though each looks so."""


def lags_of(pairs: Iterable[tuple[float, float]]) -> list[ShotLag]:
    return [ShotLag(sample, lag) for sample, lag in pairs]


@pytest.mark.parametrize("scale", [1.0, 1.0 + 1e-6, 0.999, 25 / 24])
def test_strays_do_not_move_the_line(scale: float) -> None:
    rng = np.random.default_rng(4)
    samples = np.sort(rng.integers(0, SPAN, 60))
    lags = (scale - 1.0) * samples + 7.0
    lags[rng.choice(60, 20, replace=False)] += rng.uniform(-4000.0, 4000.0, 20)
    line = line_through(lags_of(zip(samples.tolist(), lags.tolist(), strict=True)))
    assert line.scale == pytest.approx(scale, abs=1e-9)
    assert line.lag(SPAN / 2) == pytest.approx((scale - 1.0) * SPAN / 2 + 7.0, abs=1e-2)


def test_a_burst_of_bent_lags_does_not_turn_the_line() -> None:
    found = lags_of([(0, 0.1), (SPAN / 3, -0.2), *zip(BURST, BENT, strict=True)])
    line = line_through(found)
    assert abs(line.lag(0)) < 1.0
    assert abs(line.lag(SPAN)) < 1.0


def test_lags_that_are_few_or_scatter_tell_of_no_whole_film() -> None:
    places = range(0, SPAN, SPAN // 10)
    straight = [ShotLag(sample, 1e-6 * sample + 0.02 * (-1) ** n) for n, sample in enumerate(places)]
    scattered = [ShotLag(each.sample, each.lag + 0.5 * (-1) ** n) for n, each in enumerate(straight)]
    burst = [ShotLag(sample, 0.0) for sample in BURST]
    for exact in (straight, straight[::3]):
        line = line_through_exact(exact, straight, bend=4.8)
        assert line is not None
        assert line.lag(SPAN) == pytest.approx(6.0, abs=0.05)
    assert line_through_exact(straight[:2], straight, bend=4.8) is None
    assert line_through_exact(scattered, scattered, bend=4.8) is None
    assert line_through_exact([], burst, bend=4.8) is None


def test_exact_lags_from_one_place_tell_no_slope_and_count_where_the_others_agree() -> None:
    near = [ShotLag(sample, 7.0) for sample in BURST]
    far = lags_of([(0, 7.5), (SPAN / 4, 4.0), (SPAN / 2, 9.0)])
    line = line_through_exact(near, [*far, *near], bend=4.8)
    assert line is not None
    assert (line.lag(0), line.scale) == (7.0, 1.0)
    drifting = [ShotLag(sample, 1e-3 * (sample - SPAN)) for sample in range(0, SPAN, SPAN // 10)]
    assert line_through_exact(near[:4], [*drifting, *near[:4]], bend=4.8) is None
    assert line_through_exact(lags_of(zip(BURST, BENT, strict=True)), [*far, *near], bend=4.8) is None

"""The line through a drive's lags: what strays, bursts and bent lags must not do to it."""

import numpy as np
import pytest

from blastline.align.timing import _exact_line, _line

SPAN = 6_000_000
BURST = [SPAN - 20_000 + 4_000 * n for n in range(6)]
BENT = [-0.9, -0.6, 0.2, -0.4, 0.4, 0.6]
"""Lags of a burst whose drive was made louder and clipped: none is exact, though each looks so."""


@pytest.mark.parametrize("scale", [1.0, 1.0 + 1e-6, 0.999, 25 / 24])
def test_strays_do_not_move_the_line(scale: float) -> None:
    rng = np.random.default_rng(4)
    samples = np.sort(rng.integers(0, SPAN, 60))
    lags = (scale - 1.0) * samples + 7.0
    lags[rng.choice(60, 20, replace=False)] += rng.uniform(-4000.0, 4000.0, 20)
    line = _line(list(zip(samples.tolist(), lags.tolist(), strict=True)))
    assert line.scale == pytest.approx(scale, abs=1e-9)
    assert line.lag(SPAN / 2) == pytest.approx((scale - 1.0) * SPAN / 2 + 7.0, abs=1e-2)


def test_a_burst_of_bent_lags_does_not_turn_the_line() -> None:
    found = [(0, 0.1), (SPAN / 3, -0.2), *zip(BURST, BENT, strict=True)]
    line = _line(found)
    assert abs(line.lag(0)) < 1.0
    assert abs(line.lag(SPAN)) < 1.0


def test_lags_that_are_few_or_scatter_tell_of_no_whole_film() -> None:
    straight = [(sample, 1e-6 * sample + 0.02 * (-1) ** n) for n, sample in enumerate(range(0, SPAN, SPAN // 10))]
    scattered = [(sample, lag + 0.5 * (-1) ** n) for n, (sample, lag) in enumerate(straight)]
    burst = [(float(sample), 0.0) for sample in BURST]
    for exact in (straight, straight[::3]):
        line = _exact_line(exact, straight, bend=4.8)
        assert line is not None
        assert line.lag(SPAN) == pytest.approx(6.0, abs=0.05)
    assert _exact_line(straight[:2], straight, bend=4.8) is None
    assert _exact_line(scattered, scattered, bend=4.8) is None
    assert _exact_line([], burst, bend=4.8) is None


def test_exact_lags_from_one_place_tell_no_slope_and_count_where_the_others_agree() -> None:
    near, far = ([(sample, 7.0) for sample in BURST], [(0, 7.5), (SPAN / 4, 4.0), (SPAN / 2, 9.0)])
    line = _exact_line(near, [*far, *near], bend=4.8)
    assert line is not None
    assert (line.lag(0), line.scale) == (7.0, 1.0)
    drifting = [(sample, 1e-3 * (sample - SPAN)) for sample in range(0, SPAN, SPAN // 10)]
    assert _exact_line(near[:4], [*drifting, *near[:4]], bend=4.8) is None
    assert _exact_line(list(zip(BURST, BENT, strict=True)), [*far, *near], bend=4.8) is None

"""The line through a drive's lags: what strays, bursts and bent lags must not do to it."""

import numpy as np
import pytest

from blastline.align.timing import _is_line, _line

SPAN = 6_000_000
BURST = [SPAN - 20_000 + 4_000 * n for n in range(6)]
BENT = [-0.9, -0.6, 0.2, -0.4, 0.4, 0.6]
"""Lags of a burst whose drive was made louder and clipped: none is exact, though each looks so."""


@pytest.mark.parametrize("stretch", [1.0, 1.0 + 1e-6, 0.999, 25 / 24])
def test_strays_do_not_move_the_line(stretch: float) -> None:
    rng = np.random.default_rng(4)
    samples = np.sort(rng.integers(0, SPAN, 60))
    lags = (stretch - 1.0) * samples + 7.0
    lags[rng.choice(60, 20, replace=False)] += rng.uniform(-4000.0, 4000.0, 20)
    line = _line(list(zip(samples.tolist(), lags.tolist(), strict=True)))
    assert line.stretch == pytest.approx(stretch, abs=1e-9)
    assert line.lag(SPAN / 2) == pytest.approx((stretch - 1.0) * SPAN / 2 + 7.0, abs=1e-2)


def test_a_burst_of_bent_lags_does_not_turn_the_line() -> None:
    found = [(0, 0.1), (SPAN / 3, -0.2), *zip(BURST, BENT, strict=True)]
    line = _line(found)
    assert abs(line.lag(0)) < 1.0
    assert abs(line.lag(SPAN)) < 1.0


def test_lags_that_scatter_or_lie_in_one_place_tell_of_no_whole_film() -> None:
    straight = [(sample, 1e-6 * sample + 0.02 * (-1) ** n) for n, sample in enumerate(range(0, SPAN, SPAN // 10))]
    scattered = [(sample, lag + 0.5 * (-1) ** n) for n, (sample, lag) in enumerate(straight)]
    burst = [(sample, 0.0) for sample in BURST]
    assert _is_line(straight, of=straight)
    assert _is_line(straight[::3], of=straight)
    assert _is_line(burst[:1], of=burst[:1])
    assert not _is_line(straight[:2], of=straight)
    assert not _is_line(scattered, of=scattered)
    assert not _is_line(burst, of=[(0, 0.0), *burst])
    assert not _is_line([], of=burst)

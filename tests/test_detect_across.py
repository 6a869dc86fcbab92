"""A row of sounds that crosses the end of a chunk's core is seen whole there."""

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect.across import RowSounds, rows_reach
from blastline.model import Span
from blastline.ruleset import load_rules

RATE_HZ = 48_000
TIER = load_rules("standard").tier
BURSTS = TIER.bursts
GAP = RATE_HZ // 10
CORE = Span(4 * RATE_HZ, 8 * RATE_HZ)


def sounds(
    own: NDArray[np.intp], beyond: NDArray[np.intp], peaks_dbfs: NDArray[np.float64] | float = -6.0
) -> RowSounds:
    """Return a core's sounds and those beyond it."""
    onsets = np.concatenate([own, beyond])
    order = np.argsort(onsets, kind="stable")
    return RowSounds(onsets[order], np.broadcast_to(peaks_dbfs, onsets.shape), order, own.size)


def going_on(heard: RowSounds) -> list[bool]:
    return [bool(each) for each in heard.going_on(rate_hz=RATE_HZ, rules=BURSTS)]


@pytest.mark.parametrize("own", [1, 2, 5])
@pytest.mark.parametrize("after", [True, False])
def test_a_row_goes_on_where_some_of_it_is_beyond(own: int, *, after: bool) -> None:
    row = CORE.stop + GAP * (np.arange(6) - own) if after else CORE.start + GAP * (np.arange(6) - 6 + own)
    inside = (row >= CORE.start) & (row < CORE.stop)
    assert inside.sum() == own
    assert going_on(sounds(row[inside], row[~inside])) == [True] * own


def test_a_row_of_the_core_alone_and_what_is_in_none_do_not_go_on() -> None:
    row, alone = CORE.start + RATE_HZ + GAP * np.arange(6), np.array([CORE.stop - 100])
    far = CORE.stop + np.array([RATE_HZ, 2 * RATE_HZ])
    assert going_on(sounds(np.concatenate([row, alone]), far)) == [False] * 7
    assert going_on(sounds(row, far[:0])) == [False] * 6


def test_a_long_row_goes_on_though_its_level_varies_by_more_than_that_of_a_burst() -> None:
    """By more than `echo_drop_db` from one to the next: no four of them are a burst."""
    row = CORE.stop + GAP * (np.arange(BURSTS.fewest_sustained + 3) - 9)
    within_db = 0.5 * (BURSTS.echo_drop_db + BURSTS.sustained_within_db)
    peaks_dbfs = np.where(np.arange(row.size) % 2, -6.0, -6.0 - within_db)
    assert going_on(sounds(row[:9], row[9:], peaks_dbfs)) == [True] * 9
    assert going_on(sounds(row[:9], row[9:18], peaks_dbfs[:18])) == [False] * 9


def test_a_row_is_followed_beyond_the_core_for_as_long_as_it_takes_to_be_a_long_one() -> None:
    slowest = round(0.99 * BURSTS.longest_gap_ms * RATE_HZ / 1000.0)
    row = CORE.stop - 10 + slowest * np.arange(-1, BURSTS.fewest_sustained - 1)
    assert rows_reach(BURSTS, RATE_HZ) >= row[-1] - CORE.stop

"""What the middle does not drown is left to the mains: laws of two mixes of one sound."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from blastline.detect.middle import heard_as_well, left_to_mains
from blastline.ruleset import load_rules

Samples = NDArray[np.float32]

RATE_HZ = 48_000
BURSTS = load_rules("standard").tier.bursts
_APART_MS = 90.0


def rounds(count: int, *, start_s: float = 1.0, seconds: float = 3.0) -> tuple[Samples, NDArray[np.intp]]:
    """Return noise that dies away, again and again over soft noise, and where each begins."""
    rng = np.random.default_rng(count)
    sound = 1e-3 * rng.standard_normal(round(seconds * RATE_HZ))
    onsets = np.array([round((start_s + number * _APART_MS / 1e3) * RATE_HZ) for number in range(count)], np.intp)
    decay = np.exp(-np.arange(2_000) / 300.0)
    for onset in onsets:
        sound[onset : onset + decay.size] += 0.1 * decay * rng.standard_normal(decay.size)
    return sound.astype(np.float32), onsets


def middle_over(sides: Samples, spans: list[tuple[int, int]], level: float = 0.1) -> Samples:
    """Return the mains: the sides, and dialogue in the middle over some spans."""
    mains = sides.copy()
    rng = np.random.default_rng(7)
    for start, stop in spans:
        mains[start:stop] += (level * rng.standard_normal(stop - start)).astype(np.float32)
    return mains


def left(sides: Samples, mains: Samples, onsets: NDArray[np.intp], fewest: int = 1) -> list[bool]:
    rules = msgspec.structs.replace(BURSTS, fewest_even=fewest)
    heard = heard_as_well(sides, mains, onsets, RATE_HZ)
    found: list[bool] = left_to_mains(heard, onsets, rate_hz=RATE_HZ, rules=rules).tolist()
    return found


@given(
    gains=st.tuples(*[st.sampled_from((0.01, 0.5, 1.0, 20.0))] * 2),
    signs=st.tuples(*[st.sampled_from((-1.0, 1.0))] * 2),
    offsets=st.tuples(*[st.sampled_from((-0.2, 0.0, 0.05))] * 2),
    drowned=st.booleans(),
)
def test_levels_polarities_and_constants_of_the_mixes_change_nothing(
    gains: tuple[float, float], signs: tuple[float, float], offsets: tuple[float, float], drowned: bool
) -> None:
    sides, onsets = rounds(1)
    mains = middle_over(sides, [(0, sides.size)] if drowned else [])
    both = [
        (np.float32(sign * gain) * mix + np.float32(offset)).astype(np.float32)
        for mix, gain, sign, offset in zip((sides, mains), gains, signs, offsets, strict=True)
    ]
    assert left(both[0], both[1], onsets) == [not drowned]


@pytest.mark.parametrize(("first", "last", "level"), [(-48_000, -48, 0.1), (-48_000, 9_600, 0.3), (-48, 9_600, 0.06)])
def test_what_the_middle_drowns_before_or_during_a_sound_is_not_left_to_the_mains(
    first: int, last: int, level: float
) -> None:
    sides, onsets = rounds(1)
    onset = int(onsets[0])
    assert left(sides, middle_over(sides, [(onset + first, onset + last)], level), onsets) == [False]


def test_what_the_middle_plays_after_the_beginning_of_a_sound_takes_nothing_of_it() -> None:
    sides, onsets = rounds(1)
    assert left(sides, middle_over(sides, [(int(onsets[0]) + 480, sides.size)], 0.2), onsets) == [True]


def test_what_rises_less_in_the_sides_than_in_the_mains_is_left_to_them() -> None:
    sides, onsets = rounds(1)
    assert left(middle_over(sides, [(0, sides.size)], 0.06), sides, onsets) == [True]


@pytest.mark.parametrize(("drowned", "expected"), [(0, True), (2, True), (3, False), (8, False)])
def test_what_goes_on_in_turns_stands_or_falls_as_a_whole(drowned: int, expected: bool) -> None:
    sides, onsets = rounds(8)
    mains = sides.copy()
    for at in onsets[:drowned].tolist():
        mains[at + 1 : at + 2_000 : 2] *= -1.0  # as loud, but another wave
    assert left(sides, mains, onsets) == [expected] * 8


@pytest.mark.parametrize(("count", "expected"), [(1, False), (3, False), (4, True), (9, True)])
def test_only_rows_are_left_to_the_mains(count: int, expected: bool) -> None:
    sides, onsets = rounds(count)
    assert left(sides, sides, onsets, fewest=4) == [expected] * count


def test_what_stands_apart_is_judged_by_itself() -> None:
    sides, onsets = rounds(2, seconds=4.0)
    sides[onsets[1] - 500 :] = 0.0
    later = np.array([onsets[0], onsets[0] + RATE_HZ])
    sides[later[1] :][:4_000] = sides[later[0] :][:4_000]
    mains = middle_over(sides, [(int(later[1]) - 9_600, int(later[1]) + 4_000)], 0.3)
    assert left(sides, mains, later) == [True, False]


def test_silence_before_a_sound_in_both_mixes_leaves_it_to_the_mains() -> None:
    sides, onsets = rounds(1)
    sides[: onsets[0]] = 0.0
    assert left(sides, sides, onsets) == [True]
    assert left(sides, middle_over(sides, [(0, sides.size)], 1e-3), onsets) == [False]
    assert left(sides, np.zeros_like(sides), onsets) == [False]
    assert left(sides, sides, onsets[:0]) == []

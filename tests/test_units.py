"""Conversions agree with exact arithmetic and undo each other."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from blastline.units import (
    SILENCE_DB,
    db_from_gain,
    gain_from_db,
    levels_db,
    ms_from_samples,
    samples_from_ms,
    samples_from_s,
)

RATES = st.sampled_from([8_000, 44_100, 48_000, 96_000, 192_000])
FOUR_HOURS_AT_192_KHZ = 4 * 3600 * 192_000
SAMPLES = st.integers(-48_000, FOUR_HOURS_AT_192_KHZ)


@given(SAMPLES, RATES)
def test_samples_survive_seconds_and_milliseconds_to_the_end_of_a_long_film(samples: int, rate_hz: int) -> None:
    assert samples_from_s(samples / rate_hz, rate_hz) == samples
    assert samples_from_ms(ms_from_samples(samples, rate_hz), rate_hz) == samples


@given(st.integers(-(10**6), 10**6), st.integers(0, 6), RATES)
def test_rounding_is_to_the_nearest_and_halves_go_up(numerator: int, exponent: int, rate_hz: int) -> None:
    """Fractions of a power of two are exact in floating point, so that exact arithmetic is the judge."""
    exact = Fraction(numerator, 2**exponent)
    assert samples_from_s(float(exact), rate_hz) == math.floor(exact * rate_hz + Fraction(1, 2))


@given(st.integers(-(2**30), 2**30), st.integers(0, 17))
def test_a_half_goes_up_whether_the_sample_is_even_or_odd(sample: int, exponent: int) -> None:
    """At a rate that is a power of two the half sample is exact."""
    assert samples_from_s((sample + 0.5) / 2**exponent, 2**exponent) == sample + 1


@given(st.floats(-1e4, 1e4), SAMPLES, RATES)
def test_a_whole_number_of_seconds_later_is_that_many_samples_later(
    duration_s: float, whole: int, rate_hz: int
) -> None:
    seconds = whole % 10_000
    apart = samples_from_s(duration_s + seconds, rate_hz) - samples_from_s(duration_s, rate_hz)
    assert abs(apart - seconds * rate_hz) <= 1  # the sum itself rounds


@given(st.floats(SILENCE_DB, 200.0))
def test_level_and_gain_undo_each_other(level_db: float) -> None:
    assert db_from_gain(gain_from_db(level_db)) == pytest.approx(level_db, abs=1e-9)


@given(st.floats(-100.0, 100.0), st.floats(-100.0, 100.0))
def test_levels_add_where_gains_multiply(first_db: float, second_db: float) -> None:
    assert gain_from_db(first_db + second_db) == pytest.approx(gain_from_db(first_db) * gain_from_db(second_db))


@given(st.lists(st.floats(0.0, 1e12)))
def test_levels_of_an_array_are_those_of_its_elements(gains: list[float]) -> None:
    np.testing.assert_allclose(levels_db(np.array(gains)), [db_from_gain(gain) for gain in gains], atol=1e-9)


@pytest.mark.parametrize("gain", [0.0, -0.0, -1.0, 5e-324, 1e-13])
def test_silence_and_less_has_a_finite_level(gain: float) -> None:
    assert db_from_gain(gain) == SILENCE_DB
    assert levels_db(np.array([gain])) == [SILENCE_DB]

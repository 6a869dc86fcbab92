"""The filters: eq. (2) and its inverse as analogue filters, and how near their digital sections come to them."""

import math
import tracemalloc

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.signal import freqz_sos, sos2zpk, sosfilt

from blastline import dsp
from render_signals import PROFILE

RATES_HZ = (8_000, 11_025, 16_000, 22_050, 32_000, 44_056, 44_100, 48_000, 88_200, 96_000, 176_400, 192_000, 384_000)
COMPENSATOR = dsp.discretise(dsp.compensator(PROFILE), 48_000)


def paper_h(frequencies_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Eq. (2), written out."""
    s = 2j * np.pi * frequencies_hz
    return 2.44e6 * (s + 20.0) / (s + 1400.0) ** 3


def error_db(analogue: dsp.Analogue, rate_hz: int, up_to_hz: float, *, lean: bool = False) -> float:
    """Return the largest complex error of the digital response, relative to the analogue peak below 2 kHz."""
    frequencies = np.unique(np.concatenate([np.geomspace(1.0, up_to_hz, 400), np.linspace(1.0, up_to_hz, 400)]))
    wanted = analogue.at(frequencies)
    _, found = freqz_sos(dsp.discretise(analogue, rate_hz, lean=lean), frequencies, fs=rate_hz)
    peak = np.max(np.abs(wanted[frequencies <= 2000.0]))
    return 20.0 * math.log10(float(np.max(np.abs(found - wanted)) / peak))


def test_felt_response_is_equation_2() -> None:
    frequencies = np.geomspace(0.1, 20_000.0, 200)
    np.testing.assert_allclose(dsp.felt_response(PROFILE).at(frequencies), paper_h(frequencies), rtol=1e-12)
    gains = np.abs(dsp.felt_response(PROFILE).at(np.array([10.0, 100.0, 200.0, 1000.0])))
    np.testing.assert_allclose(gains, [0.0585, 0.4245, 0.4606, 0.0575], atol=5e-5)


def test_compensator_undoes_the_felt_response_in_the_band() -> None:
    frequencies = np.geomspace(0.5, 20_000.0, 200)
    series = dsp.compensator(PROFILE) * dsp.felt_response(PROFILE)
    np.testing.assert_allclose(series.at(frequencies), dsp.band(PROFILE).at(frequencies), rtol=1e-9)


def test_band_is_3_db_down_at_its_corners() -> None:
    corners = np.array([PROFILE.highpass.corner_hz, PROFILE.lowpass.corner_hz])
    np.testing.assert_allclose(np.abs(dsp.band(PROFILE).at(corners)), math.sqrt(0.5), rtol=1e-4)


@pytest.mark.parametrize("order", range(1, 13))
def test_half_band_twice_is_3_db_down_at_the_same_corners(order: int) -> None:
    profile = msgspec.structs.replace(PROFILE, lowpass=msgspec.structs.replace(PROFILE.lowpass, order=order))
    corners = np.array([profile.highpass.corner_hz, profile.lowpass.corner_hz])
    np.testing.assert_allclose(np.abs(dsp.half_band(profile).at(corners)) ** 2, math.sqrt(0.5), rtol=1e-4)
    steep = np.abs(dsp.half_band(profile).at(np.array([4000.0, 8000.0]))) ** 2
    assert 20.0 * math.log10(steep[0] / steep[1]) >= 6.0 * order - 0.5, "falls at least as fast as the band"
    driving = np.abs((dsp.inverse(profile) * dsp.half_band(profile)).at(np.array([2e5, 4e5])))
    fall_db = 20.0 * math.log10(driving[0] / driving[1])
    assert fall_db >= 11.5, "two orders steeper than the compensator rises, or its digital filter is off by 25 dB"


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_digital_filters_follow_the_analogue_ones(rate_hz: int) -> None:
    top = min(2000.0, 0.4 * rate_hz)
    bars = (-108.0, -125.0, -75.0) if rate_hz >= 44_000 else (-64.0, -72.0, -41.0)
    for analogue, bar in zip(
        (dsp.felt_response(PROFILE), dsp.band(PROFILE), dsp.compensator(PROFILE)), bars, strict=True
    ):
        assert error_db(analogue, rate_hz, top) <= bar


@pytest.mark.parametrize("rate_hz", [rate_hz for rate_hz in RATES_HZ if rate_hz >= 44_000])
def test_lean_filters_take_half_the_sections_and_are_near_enough(rate_hz: int) -> None:
    for analogue in (dsp.compensator(PROFILE), dsp.inverse(PROFILE) * dsp.half_band(PROFILE)):
        lean, full = (dsp.discretise(analogue, rate_hz, lean=lean) for lean in (True, False))
        assert len(lean) <= 0.65 * len(full)
        assert error_db(analogue, rate_hz, 2000.0, lean=True) <= -65.0


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_compensator_does_not_gain_close_to_half_the_rate(rate_hz: int) -> None:
    sections = dsp.discretise(dsp.compensator(PROFILE), rate_hz)
    _, low = freqz_sos(sections, np.geomspace(1.0, 2000.0, 200), fs=rate_hz)
    _, high = freqz_sos(sections, np.linspace(0.4, 0.5, 200) * rate_hz, fs=rate_hz)
    assert np.max(np.abs(high)) <= 1.2 * np.max(np.abs(low))


@pytest.mark.parametrize("rate_hz", RATES_HZ)
def test_digital_filters_are_stable_and_pass_no_dc(rate_hz: int) -> None:
    for analogue in (dsp.felt_response(PROFILE), dsp.compensator(PROFILE), dsp.band(PROFILE)):
        assert np.max(np.abs(sos2zpk(dsp.discretise(analogue, rate_hz))[1])) < 1.0
    _, at_dc = freqz_sos(dsp.discretise(dsp.compensator(PROFILE), rate_hz), np.zeros(1))
    assert abs(at_dc[0]) < 1e-6


@pytest.mark.parametrize(
    ("corner_rad_s", "bar"), [(0.01, 1e-3), (1.0, 1e-3), (1400.0, 1e-3), (0.9 * math.pi * 48_000, 1e-2)]
)
def test_single_poles_from_very_slow_to_nearly_half_the_rate(corner_rad_s: float, bar: float) -> None:
    slow = dsp.Analogue(np.array([], complex), np.array([complex(-corner_rad_s)]), corner_rad_s)
    frequencies = np.geomspace(1e-3, 2000.0, 300)
    _, found = freqz_sos(dsp.discretise(slow, 48_000), frequencies, fs=48_000)
    assert np.max(np.abs(found - slow.at(frequencies))) < bar


@pytest.mark.parametrize("rate_hz", [48_000, 192_000])
def test_the_order_in_which_poles_and_zeros_are_listed_changes_no_filter(rate_hz: int) -> None:
    rng, pair = np.random.default_rng(1), np.array([1.0j, -1.0j])
    poles = np.concatenate([377.0 * pair - 19.0, 1900.0 * pair - 60.0, [-300.0, -1400.0]])
    felt = dsp.Analogue(np.concatenate([300.0 * pair - 50.0, [-20.0]]), poles, 1e9)
    for analogue in (felt, dsp.compensator(PROFILE)):
        sections = dsp.discretise(analogue, rate_hz)
        for _ in range(8):
            mixed = dsp.Analogue(rng.permutation(analogue.zeros), rng.permutation(analogue.poles), analogue.gain)
            np.testing.assert_allclose(dsp.discretise(mixed, rate_hz), sections, rtol=1e-7, atol=1e-7)


def test_resonance_rings_as_its_analogue_does() -> None:
    pole = complex(-60.0, 2.0 * math.pi * 300.0)
    analogue = dsp.Analogue(np.array([], complex), np.array([pole, pole.conjugate()]), abs(pole) ** 2)
    rate_hz = 48_000
    found = dsp.run_filter(dsp.discretise(analogue, rate_hz), np.concatenate([[1.0], np.zeros(4799)]))
    time_s = np.arange(4800) / rate_hz
    wanted = abs(pole) ** 2 / pole.imag * np.exp(pole.real * time_s) * np.sin(pole.imag * time_s) / rate_hz
    # a sampled impulse is a band-limited one: its first samples hold what the analogue response has not yet
    assert np.max(np.abs(found - wanted)) < 5e-3 * np.max(np.abs(wanted))
    assert np.max(np.abs(found - wanted)[200:]) < 1e-5 * np.max(np.abs(wanted))


def test_improper_filter_is_refused() -> None:
    with pytest.raises(ValueError, match="improper filter: 3 zeros over 1 poles"):
        dsp.discretise(dsp.inverse(PROFILE), 48_000)


@given(st.lists(st.tuples(st.booleans(), st.integers(1, 20_000)), max_size=5), st.booleans())
def test_sound_and_silence_run_as_if_nothing_were_cut(parts: list[tuple[bool, int]], begun: bool) -> None:
    """The reference hears all in one: what decays in so short a silence is far from denormal."""
    rng = np.random.default_rng(len(parts))
    samples = np.concatenate([np.zeros(0), *(rng.standard_normal(n) if sounds else np.zeros(n) for sounds, n in parts)])
    state = rng.standard_normal((len(COMPENSATOR), 2)) if begun else np.zeros((len(COMPENSATOR), 2))
    whole = sosfilt(COMPENSATOR, samples, zi=state)[0] if len(samples) else samples
    np.testing.assert_array_equal(dsp.run_filter(COMPENSATOR, samples, state=state if begun else None), whole)


@pytest.mark.parametrize("sounding", [0, 1, 480_000])
def test_what_comes_of_a_filter_is_all_the_memory_that_it_asks_for(sounding: int) -> None:
    """Memory that is new costs as much as filtering it: with twice as much, silence cost more than noise."""
    samples = np.zeros(480_000)
    samples[:sounding] = np.random.default_rng(4).standard_normal(sounding)
    dsp.run_filter(COMPENSATOR, samples[:10])
    tracemalloc.start()
    try:
        dsp.run_filter(COMPENSATOR, samples)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 1.25 * samples.nbytes


@given(st.integers(0, 200), st.integers(1, 100), st.floats(-30, 30))
def test_filter_is_linear_and_delays_with_its_input(delay: int, length: int, exponent: float) -> None:
    sections = COMPENSATOR
    samples = np.random.default_rng(length).standard_normal(length)
    once = dsp.run_filter(sections, samples)
    late = dsp.run_filter(sections, np.concatenate([np.zeros(delay), samples]))
    assert np.array_equal(late[delay:], once)
    assert not np.any(late[:delay])
    scale = 10.0**exponent
    np.testing.assert_allclose(dsp.run_filter(sections, scale * samples), scale * once, rtol=1e-6, atol=1e-9 * scale)


@pytest.mark.parametrize("samples", [0, 1, 2, 5, 240, 4800])
def test_fades_sum_to_one(samples: int) -> None:
    rising = dsp.fade(samples)
    assert len(rising) == samples
    np.testing.assert_allclose(rising + rising[::-1], 1.0, rtol=0, atol=1e-15)
    assert np.all(np.diff(rising) > 0.0)
    assert np.all((rising > 0.0) & (rising < 1.0))


@given(st.integers(0, 2**32 - 1))
def test_fading_a_signal_into_itself_changes_nothing(seed: int) -> None:
    random = np.random.default_rng(seed)
    samples = random.standard_normal(64) * 10.0 ** random.uniform(-30, 30, 64)
    assert np.array_equal(dsp.cross_fade(samples, samples, random.uniform(0, 1, 64)), samples)
    other = random.standard_normal(64) * 1e30
    assert np.array_equal(dsp.cross_fade(samples, other, np.zeros(64)), samples)
    assert np.array_equal(dsp.cross_fade(samples, other, np.ones(64)), other)


@pytest.mark.parametrize("slowest", [3.0, 40.0, 4_000.0])
def test_filters_settle_until_nothing_of_their_slowest_ring_is_left(slowest: float) -> None:
    fast = dsp.Analogue(np.zeros(0, np.complex128), np.array([-5_000.0 + 0j]), 5_000.0)
    slow = dsp.Analogue(np.zeros(0, np.complex128), np.array([-slowest + 0j]), slowest)
    assert math.exp(-slowest * dsp.settle_s(fast, slow)) < 1e-6


@pytest.mark.parametrize("q", [0.8, 3.0, 30.0, 300.0, 3_000.0])
def test_the_frequencies_that_tell_a_response_hold_its_peak_however_sharp(q: float) -> None:
    """A second-order low-pass peaks at Q / sqrt(1 - 1 / 4 Q^2)."""
    for resonance_hz in np.geomspace(40.0, 5_000.0, 23):
        pole = 2.0 * math.pi * resonance_hz * complex(-0.5 / q, math.sqrt(1.0 - 0.25 / q**2))
        response = dsp.Analogue(np.zeros(0, np.complex128), np.array([pole, pole.conjugate()]), abs(pole) ** 2)
        frequencies_hz = dsp.telling_hz(response, 1.0, 20_000.0, 500)
        assert np.all(np.diff(frequencies_hz) >= 0.0)
        assert (frequencies_hz[0], frequencies_hz[-1]) == pytest.approx((1.0, 20_000.0), rel=1e-12)
        peak = q / math.sqrt(1.0 - 0.25 / q**2)
        assert np.max(np.abs(response.at(frequencies_hz))) == pytest.approx(peak, rel=0.01)


def test_what_resonates_beyond_the_frequencies_asked_for_is_left_out() -> None:
    response = dsp.Analogue(np.zeros(0, np.complex128), np.array([-1.0 + 9e4j, -1.0 - 9e4j, -1.0 + 3j, -1.0 - 3j]), 1.0)
    np.testing.assert_allclose(dsp.telling_hz(response, 1.0, 1_000.0, 4), [1.0, 10.0, 100.0, 1_000.0])

"""Where one signal lies in another."""

import numpy as np
import pytest

from align_films import Samples
from blastline.correlate import (
    lag_of_product,
    lag_uncertainty,
    match_template,
    normalised_product,
    parabolic_offsets,
)


def rumble(seed: int, samples: int) -> Samples:
    """Return noise below a tenth of the Nyquist frequency, exact at any fraction of a sample by its Fourier series."""
    rng = np.random.default_rng(seed)
    spectrum = np.zeros(samples // 2 + 1, complex)
    spectrum[1 : samples // 20] = rng.standard_normal(samples // 20 - 1) + 1j * rng.standard_normal(samples // 20 - 1)
    return np.fft.irfft(spectrum, samples)


def later(signal: Samples, by: float) -> Samples:
    phase = np.exp(-2j * np.pi * np.fft.rfftfreq(len(signal)) * by)
    return np.fft.irfft(np.fft.rfft(signal) * phase, len(signal))


@pytest.mark.parametrize("by", [0.0, 1.0, -3.0, 0.25, 17.6, -49.5])
def test_a_delay_is_found_to_a_fraction_of_a_sample(by: float) -> None:
    signal = rumble(1, 4000)
    match = match_template(signal[1000:3000], later(signal, by)[900:3100])
    assert match.lag == pytest.approx(by, abs=0.03)
    assert match.correlation == pytest.approx(1.0, abs=0.01)


def test_the_correlation_is_the_textbook_one() -> None:
    pattern, other = rumble(2, 500), rumble(3, 500)
    assert match_template(pattern, other).correlation == pytest.approx(
        float(np.dot(pattern, other) / np.linalg.norm(pattern) / np.linalg.norm(other))
    )


def test_level_does_not_matter_and_inversion_shows() -> None:
    signal = rumble(4, 4000)
    match = match_template(signal[1000:3000], -1e-6 * later(signal, 5)[950:3050])
    assert match.lag == pytest.approx(5.0, abs=1e-3)
    assert match.correlation == pytest.approx(-1.0)


def test_samples_that_do_not_count_cannot_mislead() -> None:
    signal = rumble(5, 4000)
    moving = later(signal, 8)
    mask = np.ones(4000, bool)
    mask[1500:2300] = False
    spoilt = np.where(mask, moving, 100.0 * rumble(6, 4000))
    match = match_template(signal[1000:3000], spoilt[950:3050], mask[950:3050])
    assert match.lag == pytest.approx(8.0, abs=0.03)
    assert match.correlation == pytest.approx(1.0, abs=1e-3)
    assert abs(match_template(signal[1000:3000], spoilt[950:3050]).correlation) < 0.5


def test_too_little_to_compare_is_no_match() -> None:
    signal = rumble(7, 400)
    few = np.zeros(440, bool)
    few[200:205] = True
    padded = np.pad(signal, 20)
    assert match_template(signal, padded, few).correlation == 0.0
    for pattern, moving in ((signal, np.zeros(440)), (np.zeros(400), padded)):
        match = match_template(pattern, moving)
        assert np.isnan(match.lag)
        assert match.correlation == 0.0


def test_beside_a_lag_at_which_too_little_counts_there_is_no_peak() -> None:
    """The true place is hidden by the mask, and what is left beside it only leads up to it."""
    pattern = np.exp(-0.5 * ((np.arange(101) - 50.0) / 1.5) ** 2)
    moving = np.concatenate([np.zeros(13), pattern, np.zeros(7)])  # 3 samples late
    mask = np.ones(len(moving), bool)
    mask[13 + 50 - 6 : 13 + 50 + 3] = False
    assert np.isnan(match_template(pattern, moving, mask).lag)


@pytest.mark.parametrize("beside", [-0.5, -0.3, 0.0, 0.2, 0.5])
def test_the_vertex_of_a_parabola_is_found_exactly(beside: float) -> None:
    at = np.arange(9.0)
    values = np.stack([5.0 - (at - peak - beside) ** 2 for peak in (3, 6)]).max(axis=0)
    np.testing.assert_allclose(parabolic_offsets(values, np.array([3, 6])), [beside, beside], atol=1e-12)


def test_a_peak_without_a_neighbour_or_a_bend_is_its_own_vertex() -> None:
    assert parabolic_offsets(np.array([3.0, 2.0, 0.0]), np.array([0, 2])).tolist() == [0.0, 0.0]
    assert parabolic_offsets(np.array([1.0, 1.0, 1.0]), np.array([1])).tolist() == [0.0]
    assert parabolic_offsets(np.array([0.0, 1.0, 2.0]), np.array([], np.intp)).tolist() == []


@pytest.mark.parametrize("by", [-7, 0, 3])
def test_a_tone_that_dies_away_is_found_in_its_own_place_and_not_a_period_later(by: int) -> None:
    """There it is as like itself, only softer; half a period later as like its opposite."""
    time = np.arange(2_400)
    tone = np.sin(2.0 * np.pi * time / 240.0) * np.exp(-time / 1_000.0)
    moving = np.zeros(2_400 + 2 * 300)
    moving[300 + by : 300 + by + 2_400] = np.sin(2.0 * np.pi * time / 240.0) * np.exp(-time / 1_000.0)
    moving[300 + by : 300 + by + 120] *= 0.5
    assert abs(match_template(tone, moving).lag - by) > 100.0
    assert lag_of_product(tone, moving) == pytest.approx(by, abs=3.0)


def test_what_never_agrees_has_no_lag() -> None:
    assert lag_of_product(np.ones(10), -np.ones(30)) == 0.0


def spoilt(signal: Samples, by: float, share: float, seed: int) -> Samples:
    """Return a signal later by so much, with something else of a share of its strength put to it."""
    other = rumble(seed, len(signal))
    return later(signal, by) + share * np.linalg.norm(signal) / np.linalg.norm(other) * other


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("share", [0.003, 0.03, 0.1])
def test_what_is_unlike_moves_a_lag_by_no_more_than_its_uncertainty(seed: int, share: float) -> None:
    signal = rumble(seed, 4000)
    by = float(np.random.default_rng(seed).uniform(-8, 8))
    moving = spoilt(signal, by, share, seed + 1000)[980:3020]
    match = match_template(signal[1000:3000], moving)
    uncertainty = lag_uncertainty(signal[1000:3000], match, len(moving))
    assert abs(match.lag - by) <= uncertainty + 0.03
    assert uncertainty < 40.0 * share


@pytest.mark.parametrize("slower", [2, 4])
def test_the_slower_a_sound_the_less_it_tells_a_lag(slower: int) -> None:
    fast = rumble(1, 4000)
    slow = np.interp(np.arange(4000) / slower, np.arange(4000), fast)

    def uncertainty(signal: Samples, seed: int) -> float:
        moving = spoilt(signal, 0.0, 0.01, seed)[980:3020]
        match = match_template(signal[1000:3000], moving)
        return lag_uncertainty(signal[1000:3000], match, len(moving))

    ratios = [uncertainty(slow, seed) / uncertainty(fast, seed) for seed in range(50, 60)]
    assert float(np.median(ratios)) == pytest.approx(slower, rel=0.3)


def test_less_than_half_a_period_tells_no_lag() -> None:
    tone = np.cos(2.0 * np.pi * np.arange(3000) / 1000.0)
    for length, known in ((250, False), (2000, True)):
        match = match_template(tone[100 : 100 + length], tone[80 : 120 + length])
        assert np.isfinite(lag_uncertainty(tone[100 : 100 + length], match, length + 40)) == known


@pytest.mark.parametrize(
    ("one", "other", "alike"), [(0.0, 0.0, 1.0), (0.0, 0.3, 0.0), (0.3, 0.0, 0.0), (1e-9, 0.3, 1.0)]
)
def test_silence_is_like_silence_and_like_nothing_else(one: float, other: float, alike: float) -> None:
    sound = np.random.default_rng(8).standard_normal(300)
    assert normalised_product(one * sound, other * sound) == pytest.approx(alike, abs=1e-12)

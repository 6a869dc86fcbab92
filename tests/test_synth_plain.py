"""Sounds as textbooks draw them: what a blast is, and what it is not."""

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.synth import plain_bed, plain_negative, plain_shot
from blastline.synth.plain import hit, sloped_noise, swell, thud, tick
from blastline.synth.plain_beds import babble, chords, hum

RATE_HZ = 48_000


def share(samples: NDArray[np.float64], low_hz: float, high_hz: float) -> float:
    """Return how much of the energy lies from one frequency to another."""
    count = max(len(samples), RATE_HZ)
    energy = np.abs(np.fft.rfft(samples, count)) ** 2
    hz = np.fft.rfftfreq(count, 1.0 / RATE_HZ)
    return float(energy[(hz >= low_hz) & (hz < high_hz)].sum() / energy.sum())


@pytest.mark.parametrize("seed", range(40))
def test_a_blast_begins_with_its_first_sample_and_rises_within_a_few_milliseconds(seed: int) -> None:
    samples, onsets = plain_shot(np.random.default_rng(seed), RATE_HZ)
    assert onsets[0] == 0
    assert list(onsets) == sorted(onsets)
    assert np.isfinite(samples).all()
    assert np.abs(samples).max() == pytest.approx(1.0)
    first = np.abs(samples[: RATE_HZ // 33])  # 30 ms: nothing fires again sooner
    assert np.argmax(first >= 0.5 * first.max()) < 0.012 * RATE_HZ


@pytest.mark.parametrize("seed", range(40))
def test_bursts_fire_as_fast_as_guns_do(seed: int) -> None:
    _, onsets = plain_shot(np.random.default_rng(seed), RATE_HZ)
    gaps_ms = np.diff(onsets) * 1000 / RATE_HZ
    assert ((gaps_ms > 40) & (gaps_ms < 170)).all()


@pytest.mark.parametrize("seed", range(40))
def test_a_blast_fills_the_band_and_what_is_none_does_not(seed: int) -> None:
    samples, _ = plain_shot(np.random.default_rng(seed), RATE_HZ)
    assert share(samples, 0.0, 400.0) > 0.005
    assert share(samples, 800.0, RATE_HZ) > 1e-4
    assert share(thud(np.random.default_rng(seed), RATE_HZ), 6_000.0, RATE_HZ) < 0.2
    assert share(hit(np.random.default_rng(seed), RATE_HZ), 0.0, 100.0) < 0.05


@pytest.mark.parametrize("seed", range(40))
def test_a_tick_is_over_before_a_blast_has_turned(seed: int) -> None:
    samples = np.abs(tick(np.random.default_rng(seed), RATE_HZ))
    assert np.flatnonzero(samples > 0.05).max() < 0.006 * RATE_HZ
    assert share(samples, 0.0, 300.0) < 0.25


@pytest.mark.parametrize("seed", range(40))
def test_a_swell_takes_its_time(seed: int) -> None:
    samples = np.abs(swell(np.random.default_rng(seed), RATE_HZ))
    smooth = np.convolve(samples, np.ones(96) / 96, "same")
    assert np.argmax(smooth >= 0.7 * smooth.max()) > 0.002 * RATE_HZ


def test_negatives_and_beds_are_sound_of_the_asked_length_and_the_same_each_time() -> None:
    for seed in range(60):
        samples = plain_negative(np.random.default_rng(seed), RATE_HZ)
        assert np.isfinite(samples).all()
        assert np.abs(samples).max() == pytest.approx(1.0)
        assert np.array_equal(samples, plain_negative(np.random.default_rng(seed), RATE_HZ))
    for seed in range(6):
        bed = plain_bed(np.random.default_rng(seed), RATE_HZ, 2.5)
        assert bed.shape == (120_000,)
        assert np.isfinite(bed).all()
        assert np.array_equal(bed, plain_bed(np.random.default_rng(seed), RATE_HZ, 2.5))


def test_a_bed_of_steeper_noise_has_less_treble() -> None:
    def treble(power: float) -> float:
        spectrum = np.abs(np.fft.rfft(sloped_noise(np.random.default_rng(3), RATE_HZ, power))) ** 2
        return float(spectrum[8_000:].sum() / spectrum.sum())

    assert treble(0.0) == pytest.approx(2 / 3, abs=0.02)
    assert treble(0.0) > treble(-1.0) > treble(-2.0)


@pytest.mark.parametrize("seed", range(12))
def test_a_bed_is_as_loud_as_a_bed_may_be(seed: int) -> None:
    bed = plain_bed(np.random.default_rng(seed), RATE_HZ, 5.0)
    assert -60.0 <= 10.0 * np.log10(np.mean(bed**2)) <= -25.0


@pytest.mark.parametrize("seed", range(12))
def test_chords_and_hum_are_tones_and_babble_comes_and_goes(seed: int) -> None:
    """Of tones half the power lies in some hundredth of the spectrum; syllables are tens of decibels over pauses."""
    for tones in (chords, hum):
        power = np.sort(np.abs(np.fft.rfft(tones(np.random.default_rng(seed), RATE_HZ, 4 * RATE_HZ))) ** 2)
        assert power[-len(power) // 100 :].sum() > 0.5 * power.sum()
    voice = babble(np.random.default_rng(seed), RATE_HZ, 4 * RATE_HZ)
    levels_db = 10.0 * np.log10(np.mean(voice.reshape(-1, RATE_HZ // 50) ** 2, axis=1))
    assert np.ptp(np.percentile(levels_db, [5, 95])) > 8.0

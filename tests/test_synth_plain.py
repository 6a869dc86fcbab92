"""Sounds as textbooks draw them: what a blast is, and what it is not."""

import numpy as np
import pytest

from blastline.synth import plain_bed, plain_negative, plain_shot
from blastline.synth.plain import swell

RATE_HZ = 48_000


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
        assert np.sqrt(np.mean(bed**2)) > 0


def test_a_bed_of_steeper_noise_has_less_treble() -> None:
    def treble(power: float) -> float:
        from blastline.synth.plain import sloped_noise

        spectrum = np.abs(np.fft.rfft(sloped_noise(np.random.default_rng(3), RATE_HZ, power))) ** 2
        return float(spectrum[8_000:].sum() / spectrum.sum())

    assert treble(0.0) == pytest.approx(2 / 3, abs=0.02)
    assert treble(0.0) > treble(-1.0) > treble(-2.0)

"""Beds and negatives: every kind sounds, is finite, repeats exactly and varies with its seed."""

import itertools

import numpy as np
import pytest

from blastline.synth import BED_KINDS, NEGATIVE_KINDS, BedKind, NegativeKind, random_bed, random_negative
from blastline.synth.bed_loop import bed_loop
from blastline.synth.chance import generator
from blastline.synth.impacts import modes
from blastline.synth.noises import coloured, smooth_through
from blastline.synth.tone import peak, rms

RATE_HZ = 24_000


@pytest.mark.parametrize("kind", [*NEGATIVE_KINDS, "explosion"])
def test_a_negative_has_a_peak_of_one_and_starts_where_it_says(kind: NegativeKind) -> None:
    for seed in range(2):
        samples, at = random_negative(generator(seed, kind), RATE_HZ, kind)
        again, _ = random_negative(generator(seed, kind), RATE_HZ, kind)
        assert np.array_equal(samples, again)
        assert np.isfinite(samples).all()
        assert peak(samples) == pytest.approx(1.0)
        assert at == 0
        assert np.any(samples[: RATE_HZ // 50])
        assert len(samples) < 14 * RATE_HZ
    other, _ = random_negative(generator(99, kind), RATE_HZ, kind)
    assert len(other) != len(samples) or not np.array_equal(other, samples)


@pytest.mark.parametrize("kind", BED_KINDS)
def test_a_bed_has_an_rms_of_one_over_its_length(kind: BedKind) -> None:
    bed = random_bed(generator(1, kind), RATE_HZ, 4.0, kind)
    assert len(bed) == 4 * RATE_HZ
    assert np.isfinite(bed).all()
    assert rms(bed) == pytest.approx(1.0)
    assert np.array_equal(bed, random_bed(generator(1, kind), RATE_HZ, 4.0, kind))


def test_coloured_noise_falls_as_its_slope_says() -> None:
    for slope in (0.0, 1.0, 1.6, 2.0):
        noise = coloured(generator(2), 2**18, slope=slope, rate_hz=48_000)
        power = np.abs(np.fft.rfft(noise)) ** 2
        bands = [
            power[round(f / 48_000 * 2**18) : round(2 * f / 48_000 * 2**18)].mean() for f in (100, 200, 1_600, 3_200)
        ]
        assert 10.0 * np.log10(bands[0] / bands[3]) == pytest.approx(5 * 3.01 * slope, abs=1.5)


def test_a_curve_passes_through_its_values() -> None:
    values = np.array([1.0, -2.0, 0.5, 3.0])
    curve = smooth_through(values, 3.0, 300)
    assert curve[[0, 100, 200]] == pytest.approx(values[:3])
    assert np.all(np.diff(curve[:100]) <= 0.0)


def test_modes_ring_at_their_frequency_and_decay() -> None:
    ringing = modes(48_000, np.array([1_000.0, 30_000.0]), np.array([0.1, 1.0]), np.array([1.0, 1.0]))
    spectrum = np.abs(np.fft.rfft(ringing[:48_000]))
    assert int(np.argmax(spectrum)) == pytest.approx(1_000, abs=1)
    assert peak(ringing[4_800:4_900]) / peak(ringing[:100]) == pytest.approx(np.exp(-1.0), rel=0.02)


def test_a_bed_of_any_length_reads_the_same_in_pieces() -> None:
    loop = bed_loop(5, "ambience", duration_s=300.0, rate_hz=8_000)
    whole = loop.read(300_000, 900_000)
    cuts = [300_000, 300_001, 359_000, 372_345, 720_000, 900_000]
    pieces = [loop.read(start, stop) for start, stop in itertools.pairwise(cuts)]
    assert np.array_equal(np.concatenate(pieces), whole)


def test_a_loop_has_no_seam() -> None:
    loop = bed_loop(6, "ambience", duration_s=300.0, rate_hz=8_000)
    levels = rms(loop.read(0, 8_000 * 30))
    steps = np.abs(np.diff(loop.read(0, 8_000 * 200)))
    assert steps.max() < 8.0 * levels
    seconds = loop.read(0, 8_000 * 200).reshape(200, -1)
    assert 0.2 < min(map(rms, seconds)) < max(map(rms, seconds)) < 4.0

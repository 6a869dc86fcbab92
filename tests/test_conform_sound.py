"""What two films are compared by: fingerprints over the whole, waveforms around a moment."""

from typing import Any

import numpy as np
import pytest

from blastline.conform.fingerprint import FRAME_HZ, Fingerprint, fingerprint, summed_around
from blastline.conform.search import Haystack
from blastline.conform.waveform import WORK_HZ, look, piece
from conform_films import RATE_HZ, InMemory, film, heard, murmur, seconds

ONSETS_S = (2.0, 3.1, 5.55, 7.025)


def printed(samples: np.ndarray, rate_hz: int = RATE_HZ, block: int = 65_536) -> Fingerprint:
    return fingerprint(InMemory(samples, rate_hz).blocks(block), rate_hz)


@pytest.mark.parametrize("block", [1, 333, 4_096, 1_000_000])
def test_the_size_of_blocks_changes_no_fingerprint(block: int) -> None:
    samples = murmur(0.7 if block == 1 else 8.0, seed=1)
    assert np.array_equal(printed(samples, block=block).frames, printed(samples).frames)


@pytest.mark.parametrize("rate_hz", [8_000, 11_025, 44_100, 48_000])
def test_a_frame_comes_every_hundredth_at_any_rate(rate_hz: int) -> None:
    made = printed(murmur(3.337, seed=2, rate_hz=rate_hz), rate_hz)
    assert len(made) == int(made.duration_s * FRAME_HZ) + 1
    assert made.duration_s == pytest.approx(3.337, abs=1e-4)


def test_level_does_not_matter() -> None:
    samples = murmur(8.0, seed=3)
    assert printed(0.1 * samples).frames == pytest.approx(printed(samples).frames, abs=1e-2)


def test_a_delay_delays_the_fingerprint() -> None:
    samples = murmur(12.0, seed=4)
    late = printed(np.concatenate([murmur(1.5, seed=5), samples]))
    around = slice(100, 1000)
    alike = np.corrcoef(printed(samples).frames[around].ravel(), late.frames[250:1150].ravel())[0, 1]
    assert alike > 0.99


def test_silence_has_an_empty_fingerprint() -> None:
    assert not printed(np.zeros(RATE_HZ)).frames.any()


@pytest.mark.parametrize("size", [1, 2, 3, 7, 8, 50])
@pytest.mark.parametrize("count", [1, 2, 5, 31])
def test_sums_around_are_sums_of_what_is_there(size: int, count: int) -> None:
    values, half = np.random.default_rng(count).normal(size=count), size // 2
    expected = [values[max(0, at - half) : at + half + 1].sum() for at in range(count)]
    np.testing.assert_allclose(summed_around(values, size), expected, rtol=0.0, atol=1e-12)


def test_a_piece_is_the_same_however_much_is_cut_out_around_it() -> None:
    old = heard(murmur(3.0, seed=8, rate_hz=48_000), 48_000)
    (whole, _), (inner, late_s) = piece(old, 1.0, 1.0), piece(old, 1.25, 0.5)
    assert late_s == pytest.approx(0.0, abs=1e-12)
    there = whole[WORK_HZ // 4 : WORK_HZ // 4 + len(inner)]
    assert np.max(np.abs(inner - there)) <= 1e-4 * np.max(np.abs(there))


def test_the_search_is_the_normalised_correlation_at_every_frame() -> None:
    new = printed(murmur(60.0, seed=6))
    pattern = new.frames[2_345:2_645].copy()
    found = Haystack(new, 8.0).correlation(pattern)
    starts = range(0, len(new) - 300 + 1, 97)
    slow = [
        float(np.sum(pattern * new.frames[n : n + 300]))
        / float(np.linalg.norm(pattern) * np.linalg.norm(new.frames[n : n + 300]))
        for n in starts
    ]
    assert found[list(starts)] == pytest.approx(slow, abs=1e-4)
    assert int(np.argmax(found)) == 2_345


@pytest.mark.parametrize("late_ms", [-3.0, -0.33, 0.0, 0.021, 2.5])
@pytest.mark.parametrize("new_rate_hz", [16_000, 44_100])
def test_a_shift_is_measured_to_some_microseconds(late_ms: float, new_rate_hz: int) -> None:
    import soxr

    fine = film(10.0, ONSETS_S, seed=7, rate_hz=48_000)
    old = heard(soxr.resample(fine, 48_000, RATE_HZ))
    new = heard(soxr.resample(fine, 48_000, new_rate_hz), new_rate_hz)
    found = look(
        old, new, old_s=5.55, new_s=5.55 - late_ms / 1000, before_s=0.01, after_s=0.2, scale=1.0, search_s=4e-3
    )
    assert found.late_s * 1000.0 == pytest.approx(late_ms, abs=0.005)
    assert found.likeness > 0.8  # half a sample apart, white noise loses as much


@pytest.mark.parametrize("scale", [24.0 / 25.0, 1.001, 1.0427])
def test_a_shot_is_found_at_another_speed(scale: float) -> None:
    import soxr

    samples = film(10.0, ONSETS_S, seed=8, rate_hz=48_000)
    new = soxr.resample(samples, 48_000 / scale, 48_000)
    found = look(
        heard(samples, 48_000),
        heard(new, 48_000),
        old_s=7.025,
        new_s=7.025 * scale + 1e-3,
        before_s=0.01,
        after_s=0.2,
        scale=scale,
        search_s=4e-3,
    )
    assert found.late_s == pytest.approx(-1e-3, abs=5e-6)
    assert found.likeness > 0.8  # half a sample apart, white noise loses as much


def test_another_sound_is_not_alike_and_the_films_ends_are_silence() -> None:
    old, new = heard(film(4.0, (2.0,), seed=9)), heard(film(4.0, (2.0,), seed=10))
    at: dict[str, Any] = {"before_s": 0.005, "after_s": 0.2, "scale": 1.0, "search_s": 4e-3}
    assert look(old, new, old_s=2.0, new_s=2.0, **at).likeness < 0.3
    whole = heard(seconds(film(4.0, (0.0,), seed=11), 0.0, 4.0))
    assert look(whole, whole, old_s=0.0, new_s=0.0, **at).likeness > 0.99
    assert look(whole, whole, old_s=3.95, new_s=3.95, **at).likeness > 0.99

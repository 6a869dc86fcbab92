"""Backdrops: the same bed gives the same bits whatever its level and whatever follows, another moment another ones."""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from blastline.detect.backdrop import BITS, LEVELS, backdrops, hamming_distance, sounds
from blastline.detect.spectrogram import spectrograms

RATE_HZ = 48_000
LENGTH = RATE_HZ // 2
AT = RATE_HZ // 4


def of(bed: NDArray[np.float64], gain: float = 1.0, seed: int = 1) -> int | None:
    """Return the backdrop of a bang over a bed."""
    film = gain * bed
    decay = np.exp(-np.arange(LENGTH - AT) / 800.0)
    film[AT:] += gain * np.random.default_rng(seed).standard_normal(LENGTH - AT) * decay
    (backdrop,) = backdrops(spectrograms(film.astype(np.float32), np.array([AT]), RATE_HZ))
    return backdrop


def noise(seed: int, level: float = 0.03) -> NDArray[np.float64]:
    return level * np.random.default_rng([9, seed]).standard_normal(LENGTH)


def apart(first: int | None, second: int | None) -> int:
    assert first is not None
    assert second is not None
    return int(hamming_distance(np.array([first]), np.array([second]))[0])


def test_one_bed_has_one_backdrop_at_any_level_under_any_sound() -> None:
    for seed in range(20):
        here = of(noise(seed))
        assert apart(here, of(noise(seed), gain=0.1)) <= 1
        assert apart(here, of(noise(seed), seed=2)) <= 2
        assert apart(here, of(noise(seed) + 0.2 * noise(seed + 100))) < 20


def test_a_fader_over_the_bed_changes_little() -> None:
    """It moves all bands alike, and only the steps between them count."""
    ramp = 10.0 ** (np.linspace(-1.0, 1.0, LENGTH) * 0.6)  # 6 dB in the 120 ms before
    for seed in range(20):
        assert apart(of(noise(seed)), of(noise(seed) * ramp)) <= 5


def test_two_moments_of_a_noise_differ_by_half_of_their_bits() -> None:
    numbers = [of(noise(seed)) for seed in range(60)]
    far = [apart(first, second) for n, first in enumerate(numbers) for second in numbers[:n]]
    assert abs(np.mean(far) - BITS / 2) < 1.0
    assert min(far) > 8


def test_silence_has_none() -> None:
    assert of(np.zeros(LENGTH)) is None
    assert of(noise(1, level=1e-6)) is None
    assert backdrops(spectrograms(np.zeros(LENGTH, np.float32), np.zeros(0, np.intp), RATE_HZ)) == []


def test_a_hum_has_none() -> None:
    """It is the same at any time, so that whoever fires in time with it would turn with a loop."""
    seconds = np.arange(LENGTH) / RATE_HZ
    for hum_hz in (50.0, 60.0, 100.0):
        hum = np.sum([np.sin(2.0 * np.pi * hum_hz * k * seconds + k) / k for k in (1, 2, 3, 5, 7)], axis=0)
        assert of(0.05 * hum) is None
        assert of(0.05 * hum + noise(1, level=3e-5)) is None


def test_a_sound_is_like_itself_over_any_bed_and_unlike_another() -> None:
    """A softer one over the same bed is a little less like itself."""

    def levels(bang: int, bed: int, gain: float = 1.0) -> NDArray[np.float64]:
        film = noise(bed, level=3e-3)
        tail = np.random.default_rng([7, bang]).standard_normal(LENGTH - AT)
        length, pole = 200.0 * 3.0**bang, 0.3 * bang
        film[AT:] += gain * lfilter([1.0 - pole], [1.0, -pole], tail * np.exp(-np.arange(LENGTH - AT) / length))
        (sound,) = sounds(spectrograms(film.astype(np.float32), np.array([AT]), RATE_HZ))
        assert len(sound) == LEVELS
        return np.array(sound, np.float64)

    for bang in (0, 1, 2):
        for gain in (1.0, 0.5):
            assert np.abs(levels(bang, 1) - levels(bang, 2, gain)).mean() < 1.5
    for other in (1, 2):
        assert np.abs(levels(0, 1) - levels(other, 1)).mean() > 2.5

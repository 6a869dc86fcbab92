"""The spectrograms that the networks see: at another speed they are those of the film played so fast."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import resample_poly

from blastline.detect.spectrogram import spectrograms

RATE_HZ = 48_000
AT = RATE_HZ // 2


def bang_over_hum() -> NDArray[np.float64]:
    """A burst of noise that dulls as it decays, over a hum with overtones."""
    rng = np.random.default_rng(5)
    time_s = np.arange(2 * RATE_HZ) / RATE_HZ
    film = sum(0.01 * np.sin(2.0 * np.pi * 230.0 * k * time_s) for k in (1, 2, 5)) + 1e-3 * rng.standard_normal(
        time_s.size
    )
    late_s = time_s[AT:] - time_s[AT]
    for decay_s, low in ((0.08, 24), (0.02, 4), (0.006, 1)):
        dull = np.convolve(rng.standard_normal(late_s.size), np.ones(low) / np.sqrt(low), mode="same")
        film[AT:] += 0.2 * np.exp(-late_s / decay_s) * dull
    return np.asarray(film)


@pytest.mark.parametrize(("up", "down"), [(10, 11), (5, 6), (10, 9)])
def test_at_another_speed_they_are_those_of_the_film_played_so_fast(up: int, down: int) -> None:
    speed, film = down / up, bang_over_hum()
    played = resample_poly(film, up, down)  # fewer samples at the same rate: faster and higher
    onset = np.array([round(AT / speed)])
    there = spectrograms(played.astype(np.float32), onset, RATE_HZ)
    seen, as_it_is = (
        spectrograms(film.astype(np.float32), np.array([AT]), RATE_HZ, speed=each) for each in (speed, 1.0)
    )
    for name in ("near", "wide"):
        heard = getattr(there, name)[0, :, :-3]  # the resampling filter falls off above
        off, off_as_it_is = (np.abs(getattr(each, name)[0, :, :-3] - heard).mean() for each in (seen, as_it_is))
        assert off < 1.0, (name, off)
        assert off < 0.5 * off_as_it_is, (name, off, off_as_it_is)

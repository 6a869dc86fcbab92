"""Spectrograms against what was before: what goes on is taken off, and what is new is left as if it were alone."""

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect.contrast import CONTRASTS, SCALE_DB, Contrasts, contrasts
from blastline.detect.spectrogram import LOWEST_DB, NEAR, WIDE, Spectrograms, spectrograms

RATE_HZ = 48_000
AT = RATE_HZ
LEVEL, RISE, REST, DECAY = range(CONTRASTS)


def bang(decay_s: float = 0.05) -> NDArray[np.float64]:
    """Return two seconds with a burst of noise that decays from the first second on."""
    time = np.arange(2 * RATE_HZ) / RATE_HZ - 1.0
    return np.where(time >= 0.0, np.exp(-np.maximum(time, 0.0) / decay_s), 0.0) * hiss(1)


def hiss(seed: int) -> NDArray[np.float64]:
    return np.asarray(0.1 * np.random.default_rng(seed).standard_normal(2 * RATE_HZ), np.float64)


def seen(samples: NDArray[np.float64]) -> Contrasts:
    return contrasts(spectrograms(samples.astype(np.float32), np.array([AT]), RATE_HZ))


def test_a_shot_over_a_steady_sound_is_left_as_if_it_were_alone() -> None:
    """Powers add: the levels change by up to 20 dB, the rest not at all where the shot is not drowned."""
    rng = np.random.default_rng(2)
    shot, bed = [], []
    for layout in (NEAR, WIDE):
        levels = rng.uniform(-25.0, 0.0, (1, layout.frames, layout.bands))
        levels[:, : layout.before] = LOWEST_DB
        shot.append(levels)
        bed.append(np.broadcast_to(rng.uniform(-35.0, -5.0, layout.bands), levels.shape))
    alone, over = contrasts(of_levels(*shot)), contrasts(of_levels(*map(added, shot, bed)))
    for one, two, levels, steady in zip((alone.near, alone.wide), (over.near, over.wide), shot, bed, strict=True):
        heard = levels > steady - 10.0
        heard[:, :12] = False
        assert np.abs(two - one)[heard, LEVEL].max() > 5.0 / SCALE_DB
        # the attack of the rest is the mean over all bands, drowned ones with them
        apart = (two - one)[heard, REST]
        assert np.ptp(apart) < 0.2 / SCALE_DB
        assert np.abs(apart).max() < 2.0 / SCALE_DB


def of_levels(near: NDArray[np.float64], wide: NDArray[np.float64]) -> Spectrograms:
    return Spectrograms(near.astype(np.float32), wide.astype(np.float32))


def added(one: NDArray[np.float64], two: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(10.0 * np.log10(10.0 ** (one / 10.0) + 10.0 ** (two / 10.0)), np.float64)


def test_what_goes_on_does_not_rise() -> None:
    steady = seen(hiss(2))
    assert np.abs(np.median(steady.wide[0, WIDE.before + 2 :, :, RISE])) * SCALE_DB < 1.5
    assert (
        np.median(steady.wide[0, WIDE.before + 2 :, :, REST]) < np.median(steady.wide[0, :, :, LEVEL]) - 3.0 / SCALE_DB
    )


@pytest.mark.parametrize("gain", [0.25, 4.0])
def test_gain_changes_no_contrast(gain: float) -> None:
    samples = bang() + 0.5 * hiss(3)  # far over the least that 16 bits tell
    plain, louder = seen(samples), seen(gain * samples)
    np.testing.assert_allclose(louder.near, plain.near, atol=0.02)
    np.testing.assert_allclose(louder.wide, plain.wide, atol=0.02)


def test_a_colour_of_the_whole_film_changes_no_rise_and_no_decay() -> None:
    """Levels in bands, as another microphone hears them: only what is against the attack changes."""
    rng = np.random.default_rng(4)
    near, wide = (rng.uniform(-40.0, 0.0, (3, r.frames, r.bands)).astype(np.float32) for r in (NEAR, WIDE))
    tilts = [np.linspace(-9.0, 9.0, r.bands, dtype=np.float32) for r in (NEAR, WIDE)]
    plain, tilted = contrasts(Spectrograms(near, wide)), contrasts(Spectrograms(near + tilts[0], wide + tilts[1]))
    for which in (RISE, DECAY):
        np.testing.assert_allclose(tilted.near[..., which], plain.near[..., which], atol=1e-3)
        np.testing.assert_allclose(tilted.wide[..., which], plain.wide[..., which], atol=1e-3)


def test_no_candidates_have_no_contrasts() -> None:
    none = contrasts(spectrograms(np.zeros(10, np.float32), np.zeros(0, np.intp), RATE_HZ))
    assert none.near.shape == (0, NEAR.frames, NEAR.bands, CONTRASTS)
    assert none.wide.shape == (0, WIDE.frames, WIDE.bands, CONTRASTS)


def test_silence_is_numbers_within_bounds() -> None:
    still = contrasts(spectrograms(np.zeros(RATE_HZ, np.float32), np.array([0, RATE_HZ // 2, RATE_HZ - 1]), RATE_HZ))
    for each in (still.near, still.wide):
        assert np.isfinite(each).all()
        assert np.abs(each).max() <= 3.0

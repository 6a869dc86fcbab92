"""A shot's parts: where its decay ends and why, and how peaks are held."""

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect.segment import _running_peak, segment
from blastline.model import Shot
from blastline.ruleset import load_rules

RATE_HZ = 48_000
ONSET = RATE_HZ // 2
RULES = load_rules("standard").tier.segment


def decaying(fall_db_per_s: float, *, seconds: float = 2.0, seed: int = 0) -> NDArray[np.float64]:
    """Return noise that begins at once and falls steadily."""
    time_s = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    noise = np.random.default_rng(seed).standard_normal(time_s.size)
    return np.asarray(0.1 * noise * 10.0 ** (-fall_db_per_s * time_s / 20.0), np.float64)


def segmented(*sounds: tuple[float, NDArray[np.float64]], constant: float = 0.0) -> Shot:
    """Return the first of some sounds, given with their begin in ms after it, over faint noise beside zero."""
    film = constant + 1e-5 * np.random.default_rng(9).standard_normal(3 * RATE_HZ)
    for at_ms, sound in sounds:
        start = ONSET + round(at_ms * RATE_HZ / 1000.0)
        film[start : start + sound.size] += sound[: film.size - start]
    return segment(
        film.astype(np.float32),
        ONSET,
        film_start=0,
        film_stop=film.size,
        confidence=1.0,
        rate_hz=RATE_HZ,
        rules=RULES,
    )


def ended(shot: Shot) -> tuple[float, str]:
    """Return how long a shot's decay is, in ms, and what ended it."""
    assert shot.evidence is not None
    return len(shot.span) * 1000.0 / RATE_HZ, shot.evidence.decay_end


@pytest.mark.parametrize("width", range(1, 10))
def test_a_running_peak_is_the_largest_of_each_sample_and_those_after_it(width: int) -> None:
    values = np.random.default_rng(width).uniform(0.0, 1.0, 50)
    ahead = [values[at : at + width].max() for at in range(values.size)]
    np.testing.assert_array_equal(_running_peak(values, width), ahead)


@pytest.mark.parametrize("next_ms", [600.0, 730.0, 900.0])
@pytest.mark.parametrize("gain", [0.01, 1.0, -1.0])
def test_the_decay_ends_and_says_so_where_another_sound_begins(next_ms: float, gain: float) -> None:
    one, other = gain * decaying(25.0), gain * decaying(25.0, seed=1)
    alone_ms, reason = ended(segmented((0.0, one)))
    assert alone_ms > next_ms + 100.0
    assert reason != "next sound"
    length_ms, reason = ended(segmented((0.0, one), (next_ms, other)))
    assert reason == "next sound"
    assert length_ms == pytest.approx(next_ms, abs=25.0)  # in whole grains of that length


def test_what_begins_while_the_shot_is_still_loud_does_not_end_it() -> None:
    length_ms, _ = ended(segmented((0.0, decaying(25.0)), (250.0, decaying(25.0, seed=1))))
    assert length_ms > 1000.0


@pytest.mark.parametrize("constant", [-0.3, 0.05])
def test_a_constant_is_no_sound(constant: float) -> None:
    sounds = (0.0, decaying(60.0)), (90.0, 0.4 * decaying(60.0))
    still, beside = segmented(*sounds), segmented(*sounds, constant=constant)
    assert still.reflections
    assert (beside.blast, beside.span) == (still.blast, still.span)
    assert [each.start for each in beside.reflections] == [each.start for each in still.reflections]
    assert (beside.peak_dbfs, beside.snr_db) == pytest.approx((still.peak_dbfs, still.snr_db), abs=0.02)

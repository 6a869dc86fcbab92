"""Shots of a window that are wanted softer or louder: what their gains do to the drive, and what it fades into."""

from collections.abc import Sequence

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from blastline import dsp
from blastline.model import Background, DriveModel, Shot, Span
from blastline.render import HeardWindow, RenderedWindow, hear_window, measure, plan_windows, render_window, with_gains
from blastline.units import gain_from_db, samples_from_ms
from render_signals import CAUSAL, RATE_HZ, RENDER, WINDOWS, clip, film_with_shot, shot_at

Samples = NDArray[np.float64]
LEAD = samples_from_ms(RENDER.lead_ms, RATE_HZ)
FIRST, SECOND, FRAMES = 2_000, 5_000, 10_000


def sounding(*onsets: int) -> list[Shot]:
    return [msgspec.structs.replace(shot_at(onset), span=Span(onset, onset + 2_800)) for onset in onsets]


def heard(film: Samples, shots: Sequence[Shot], gains_db: Sequence[float]) -> HeardWindow:
    """Return the one window of some shots of a film, each with its gain."""
    planned = plan_windows(shots, frames=len(film), rate_hz=RATE_HZ, rules=WINDOWS)
    (window,) = with_gains(planned, shots, gains_db)
    return hear_window(clip(film), window, filters=CAUSAL, rules=RENDER)


def rendered(
    film: Samples,
    shots: Sequence[Shot],
    gains_db: Sequence[float],
    *,
    model: DriveModel,
    background: Background = "mute",
) -> RenderedWindow:
    window = heard(film, shots, gains_db)
    return render_window(window, shots, model=model, reason="test", background=background)


def bangs(shots: Sequence[Shot], peak: float) -> Samples:
    """Return a film of some bangs, each softer than the one before, that the compensator drives so high."""
    bang, _ = film_with_shot(before_s=0.0, after_s=0.1, bed=0.0)
    film = np.zeros(FRAMES)
    for number, shot in enumerate(shots):
        film[shot.onset : shot.onset + bang.size] += 0.7**number * bang
    return np.asarray(film * (peak / measure(heard(film, shots, [0.0] * len(shots))).filter_peak))


@pytest.mark.parametrize("gains_db", [(-12.0, 6.0), (6.0, -12.0), (0.0, -84.0), (-84.0, 0.0)])
def test_the_next_shots_gain_is_reached_steadily_over_the_lead_and_holds_from_its_onset_on(
    gains_db: tuple[float, float],
) -> None:
    """A gain that jumps is a click in the drive, and the lead is the next shot's already."""
    window = heard(np.ones(FRAMES), sounding(FIRST, SECOND), gains_db)
    first, second = (gain_from_db(each) for each in gains_db)
    onset = SECOND - window.planned.window.start
    assert np.all(window.gains[: onset - LEAD] == first)
    assert np.all(window.gains[onset:] == second)
    steps = np.diff(window.gains[onset - LEAD : onset + 1])
    assert np.all(steps * np.sign(second - first) > 0.0)
    assert np.max(np.abs(steps)) <= 1.01 * abs(second - first) / LEAD
    assert np.array_equal(window.asked, window.gains)


@pytest.mark.parametrize("apart", [1, LEAD // 2, LEAD])
def test_a_shot_within_the_lead_of_the_next_has_its_own_gain_at_its_onset(apart: int) -> None:
    window = heard(np.ones(FRAMES), sounding(FIRST, FIRST + 500, FIRST + 500 + apart), [0.0, 20.0, -20.0])
    second = FIRST + 500 - window.planned.window.start
    assert window.gains[[second, second + apart]] == pytest.approx([10.0, 0.1])


@pytest.mark.parametrize("peak", [2.0, 4.0])
@pytest.mark.parametrize("gains_db", [(-6.0,), (-12.0,), (-20.0,), (-6.0, -20.0), (0.0, -6.0), (6.0,), (-6.0, 12.0)])
def test_what_the_compensator_has_to_scale_down_is_softer_by_just_its_gain_and_no_louder_than_the_limit(
    peak: float, gains_db: tuple[float, ...]
) -> None:
    """Scaling to the limit would give back what somebody has taken."""
    shots = sounding(FIRST, SECOND)[: len(gains_db)]
    film = bangs(shots, peak)
    plain = rendered(film, shots, [0.0] * len(shots), model="filter").clip.driving
    found = rendered(film, shots, gains_db, model="filter").clip.driving
    wanted = heard(film, shots, gains_db).gains * plain
    assert np.max(np.abs(plain)) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(found, wanted / max(1.0, np.max(np.abs(wanted))), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("gain_db", [-20.0, -6.0, -1.0, 0.0, 1.0, 6.0])
def test_a_gain_makes_no_shot_one_that_the_compensator_can_do(gain_db: float) -> None:
    """Softer by more than was asked for, or by another model than before, it would be another shot."""
    shots = sounding(FIRST)
    peak = measure(heard(bangs(shots, 1.5), shots, [gain_db])).filter_peak
    assert peak == pytest.approx(1.5 * max(1.0, gain_from_db(gain_db)), rel=1e-12)


@pytest.mark.parametrize("model", ["direct", "filter", "constrained"])
@pytest.mark.parametrize("onsets", [(FIRST,), (FIRST, SECOND)])
def test_the_peaks_of_a_windows_shots_are_all_of_its_peak_with_what_fades_into_it(
    model: DriveModel, onsets: tuple[int, ...]
) -> None:
    rng = np.random.default_rng(2)
    film = 0.01 * rng.standard_normal(FRAMES)
    film[: FIRST - 200] = rng.uniform(-0.9, 0.9, FIRST - 200)
    done = rendered(film, sounding(*onsets), [0.0] * len(onsets), model=model, background="direct")
    drive = np.abs(done.clip.driving)
    assert np.argmax(drive) < done.planned.window.fade_in_samples, "loudest before the shot"
    assert max(info.peak for info in done.drives) == np.max(drive)


@pytest.mark.parametrize("level", [0.5, 1.8, -1.8])
@pytest.mark.parametrize("gain_db", [-20.0, 0.0])
def test_a_fade_is_a_straight_mix_with_the_film_as_it_can_be_played(level: float, gain_db: float) -> None:
    film = np.full(FRAMES, level)
    shots = sounding(FIRST)
    done = rendered(film, shots, [gain_db], model="direct", background="direct")
    window = done.planned.window
    weights = np.ones(len(window.span))
    weights[: window.fade_in_samples] = dsp.fade(window.fade_in_samples)
    weights[-window.fade_out_samples :] = dsp.fade(window.fade_out_samples)[::-1]
    dry, wet = (float(np.clip(gain * level, -1.0, 1.0)) for gain in (1.0, gain_from_db(gain_db)))
    np.testing.assert_allclose(done.clip.driving, dry + weights * (wet - dry), rtol=0.0, atol=1e-12)

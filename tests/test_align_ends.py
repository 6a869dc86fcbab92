"""Films that end within a shot: a right drive passes all the same, and what is wrong with one is caught."""

from functools import cache

import numpy as np
import pytest

from align_films import RATE_HZ, Film, Held, checks_of, failed, figure, in_24_bits, timeline_of
from blastline.model import Event
from blastline.render import hear_window, needed_audio, plan_windows, render_window
from render_signals import CAUSAL, RENDER, WINDOWS, clip, shot_at

FRAMES = 3 * RATE_HZ


@cache
def cut_off(seed: int, before_end_ms: int) -> Film:
    """Return a film of two loud shots, the second so long before its end, with the drive that is rendered of it."""
    random = np.random.default_rng(seed)
    onsets = (RATE_HZ, FRAMES - 48 * before_end_ms)
    audio = 1e-4 * random.standard_normal(FRAMES)
    for onset in onsets:
        late_s = np.arange(FRAMES - onset) / RATE_HZ
        audio[onset:] += 0.8 * (1.0 - late_s / 3e-3) * np.exp(-late_s / 3e-3)
        audio[onset:] += 0.32 * random.standard_normal(len(late_s)) * np.exp(-late_s / 0.04)
    audio, drive, events = in_24_bits(np.clip(audio, -1.0, 1.0)), np.zeros(FRAMES), []
    shots = [shot_at(onset) for onset in onsets]
    for index, planned in enumerate(plan_windows(shots, frames=FRAMES, rate_hz=RATE_HZ, rules=WINDOWS)):
        some = clip(audio).slice(needed_audio(planned, frames=FRAMES, filters=CAUSAL, rules=RENDER))
        heard = hear_window(some, planned, filters=CAUSAL, rules=RENDER)
        done = render_window(heard, shots, model="constrained", reason="made for a test", background="mute")
        drive[planned.window.start : planned.window.stop] = done.clip.driving
        shot = shots[index]
        events.append(
            Event(
                id=f"shot-{index + 1:04d}",
                onset_sample=shot.onset,
                onset_s=shot.onset / RATE_HZ,
                timecode="",
                confidence=1.0,
                burst=None,
                shot_in_burst=None,
                peak_dbfs=-1.0,
                snr_db=40.0,
                blast=shot.blast,
                reflections=(),
                window=planned.window,
                drive=done.drives[0],
            )
        )
    return Film(Held(audio, RATE_HZ), Held(in_24_bits(drive), RATE_HZ), timeline_of(audio, events, RATE_HZ))


@pytest.mark.parametrize(
    ("seed", "before_end_ms"), [(0, 12), (0, 20), (3, 8), (3, 12), (4, 12), (5, 8), (6, 20), (7, 8), (8, 7), (9, 2)]
)
def test_a_right_drive_passes_however_near_the_end_its_last_shot_is(seed: int, before_end_ms: int) -> None:
    """After the end the sound's band rings on, and no drive can: nothing is concluded from there."""
    checks = checks_of(cut_off(seed, before_end_ms))
    assert failed(checks) == set()
    assert abs(figure(checks, "drive_shift")) < 0.4
    if before_end_ms >= 5:  # of less nothing tells, and one shot alone has no drift
        assert abs(figure(checks, "drive_drift")) < 0.4


@pytest.mark.parametrize("before_end_ms", [8, 12, 30])
@pytest.mark.parametrize("by", [1, -1, 7])
def test_a_displaced_drive_of_a_film_cut_off_fails_by_its_displacement(before_end_ms: int, by: int) -> None:
    right = cut_off(3, before_end_ms)
    checks = checks_of(right.with_drive(np.roll(right.drive.samples, by)))
    assert "drive_shift" in failed(checks)
    assert figure(checks, "drive_shift") == pytest.approx(by, abs=0.1)


@pytest.mark.parametrize("before_end_ms", [8, 12, 30])
def test_faults_of_a_shot_that_is_cut_off_are_caught(before_end_ms: int) -> None:
    right = cut_off(3, before_end_ms)
    start = right.timeline.events[1].window.start
    own = right.drive.samples[start:]
    for name, changed in (
        ("felt_lag", np.concatenate([np.zeros(24), own[:-24]])),
        ("felt_correlation", -own),
        ("felt_correlation", np.zeros(len(own))),
    ):
        assert name in failed(checks_of(right.with_drive(np.concatenate([right.drive.samples[:start], changed]))))

"""A right drive passes every check, and each way to break one is caught by the check meant for it, and measured."""

from dataclasses import dataclass, field, replace
from functools import cache

import msgspec
import numpy as np
import pytest

from align_films import RATE_HZ, RULES, Film, Held, Samples, checks_of, failed, figure, make_film
from blastline.align import check_timeline
from blastline.model import Background, Check, Clip, DriveModel, Event, Phase, Span, Window


@cache
def film(
    phase: Phase = "causal", background: Background = "mute", model: DriveModel | None = None, rate_hz: int = RATE_HZ
) -> Film:
    return make_film(phase=phase, background=background, model=model, rate_hz=rate_hz)


def resampled(samples: Samples, up: int, down: int) -> Samples:
    """Return samples at `up / down` times their rate; played at the old rate they run `down / up` times as fast."""
    from scipy.signal import resample_poly

    return np.clip(np.asarray(resample_poly(samples, up, down), dtype=np.float64), -1.0, 1.0)


@pytest.mark.parametrize(
    ("phase", "background", "rate_hz"),
    [("causal", "mute", 48_000), ("causal", "direct", 48_000), ("causal", "mute", 44_100), ("zero", "direct", 44_100)],
)
def test_a_right_drive_passes(phase: Phase, background: Background, rate_hz: int) -> None:
    right = film(phase, background, None, rate_hz)
    assert {event.drive.model for event in right.timeline.events if event.drive} == {"filter", "constrained"}
    checks = checks_of(right, phase, background)
    assert failed(checks) == set()
    assert abs(figure(checks, "drive_shift")) < 0.05
    assert abs(figure(checks, "drive_drift")) < 0.1
    for event in right.timeline.events:
        lag_ms = figure(checks, "felt_lag", event.id)
        if phase == "causal":
            assert 0.33 < lag_ms < 0.46
        else:
            assert abs(lag_ms) < 1000.0 / rate_hz


@pytest.mark.parametrize("phase", ["causal", "zero"])
@pytest.mark.parametrize("offset", [0.02, -0.1, 0.9])
def test_a_film_that_stands_off_zero_passes(offset: float, phase: Phase) -> None:
    """The drive has nothing of a constant, which the band leaves out; nor must what it is compared with."""
    peaks = (0.05, 0.06, 0.05, 0.07, 0.06)
    assert failed(checks_of(make_film(peaks=peaks, offset=offset, phase=phase), phase=phase)) == set()


def test_a_direct_drive_is_compared_as_it_is() -> None:
    checks = checks_of(film(model="direct"))
    assert failed(checks) == set()
    assert {check.name for check in checks if check.name.startswith("felt")} == set()
    assert abs(figure(checks, "drive_lag", "shot-0002")) < 1e-3
    assert figure(checks, "drive_correlation", "shot-0002") > 0.999


@pytest.mark.parametrize("level_db", [-12.0, -6.0, 6.0, 12.0])
@pytest.mark.parametrize("background", ["mute", "direct"])
def test_a_direct_drive_at_a_level_passes_though_the_limit_clips_it(level_db: float, background: Background) -> None:
    right = make_film(
        onsets_s=(0.4, 0.9, 1.4),
        peaks=(0.9, 0.5, 1.2),
        seconds=2.0,
        background=background,
        model="direct",
        rumble=0.05,
        tail=1.0,
        level_db=level_db,
    )
    assert failed(checks_of(right, background=background)) == set()
    in_windows = [right.drive.samples[event.window.start : event.window.stop] for event in right.timeline.events]
    assert (np.max(np.abs(np.concatenate(in_windows))) > 0.999) == (level_db > 0.0)


@pytest.mark.parametrize(
    ("by", "phase", "model"),
    [
        *((by, "causal", None) for by in (1, 7, 480, 12_000, -3)),
        (1, "zero", None),
        (-3, "causal", "direct"),
        (12_000, "causal", "direct"),
    ],
)
def test_a_displaced_drive_fails_by_its_displacement(by: int, phase: Phase, model: DriveModel | None) -> None:
    right = film(phase, "mute", model)
    checks = checks_of(right.with_drive(np.roll(right.drive.samples, by)), phase)
    assert figure(checks, "drive_shift") == pytest.approx(by, abs=0.05)
    assert "drive_shift" in failed(checks)
    of_place = {"silence_outside_windows", "fades", "drive_shift"}
    of_time = of_place | {"felt_lag", "drive_lag", "lag_as_rendered", "felt_onset", "drive_onset"}
    assert failed(checks) <= of_time
    subject = "drive_lag" if model else "felt_lag"
    before, after = (figure(c, subject, "shot-0003") for c in (checks_of(right, phase), checks))
    assert after - before == pytest.approx(1000.0 * by / RATE_HZ, abs=0.002)


@pytest.mark.parametrize("onsets_s", [(0.7, 4.1), (0.7, 2.0, 4.1)])
@pytest.mark.parametrize("by", [3_000, -9_000])
def test_a_displaced_drive_of_few_shots_is_found_though_it_never_rests(onsets_s: tuple[float, ...], by: int) -> None:
    """The film's own sound beside the shots leaves no pattern of windows: the shots alone tell where it is."""
    right = make_film(onsets_s=onsets_s, peaks=(0.5, 0.3, 0.5)[: len(onsets_s)], background="direct", rumble=0.01)
    assert failed(checks_of(right, background="direct")) == set()
    checks = checks_of(right.with_drive(np.roll(right.drive.samples, by)), background="direct")
    assert figure(checks, "drive_shift") == pytest.approx(by, abs=0.05)
    assert "drive_shift" in failed(checks)


@pytest.mark.parametrize("second_s", [1.007, 1.009, 1.4])
def test_a_drive_displaced_by_seconds_is_found_by_its_windows_though_two_lie_close(second_s: float) -> None:
    """So far away no shot is searched for by itself; and between two windows a drive may not rest for long enough."""
    right = make_film(onsets_s=(0.7, second_s, 2.9), peaks=(0.5, 0.3, 0.2), seconds=9.0)
    assert failed(checks_of(right)) == set()
    checks = checks_of(right.with_drive(np.roll(right.drive.samples, 5 * RATE_HZ)))
    assert figure(checks, "drive_shift") == pytest.approx(5 * RATE_HZ, abs=0.05)
    assert "drive_shift" in failed(checks)


def test_a_shot_in_whose_place_the_drive_is_noise_has_no_lag() -> None:
    right = film()
    event, drive = right.timeline.events[3], right.drive.samples.copy()
    window = slice(event.window.start, event.window.stop)
    drive[window] = 0.3 * np.random.default_rng(4).uniform(-1.0, 1.0, window.stop - window.start)
    checks = checks_of(right.with_drive(drive))
    lag, likeness = (
        next(check for check in checks if (check.name, check.event) == (name, event.id))
        for name in ("felt_lag", "felt_correlation")
    )
    assert (lag.measured, lag.passed, likeness.passed) == (None, False, False)


@pytest.mark.parametrize(
    ("index", "by", "model"),
    [(3, -16, None), (3, 3, None), (0, 3, None), (0, -38, None), (1, 8, "direct"), (1, -2, "direct")],
)
def test_one_shot_within_the_lag_allowed_but_beside_its_own_fails(
    index: int, by: int, model: DriveModel | None
) -> None:
    """A drive may be early by as much as its band delays it, and still lag by less than it may."""
    right = film("causal", "mute", model)
    event, drive = right.timeline.events[index], right.drive.samples.copy()
    inside = slice(event.window.start, event.window.stop)
    drive[inside] = np.roll(drive[inside], by)
    broken = [check for check in checks_of(right.with_drive(drive)) if not check.passed]
    told = {check.name: check for check in broken if check.event == event.id}
    assert {check.event for check in broken} <= {event.id, None}
    assert told["lag_as_rendered"].measured == pytest.approx(1000.0 * by / RATE_HZ, abs=0.005)
    assert {"felt_lag", "drive_lag"}.isdisjoint(told)


def test_a_displacement_shows_where_the_background_sounds() -> None:
    right = film("causal", "direct")
    checks = checks_of(right.with_drive(np.roll(right.drive.samples, 12_000)), "causal", "direct")
    assert figure(checks, "drive_shift") == pytest.approx(12_000, abs=0.05)
    assert {"drive_shift", "sound_outside_windows"} <= failed(checks)


@pytest.mark.parametrize(("up", "down"), [(1000, 1001), (147, 160)])
def test_another_speed_is_measured(up: int, down: int) -> None:
    right = film()
    fast = resampled(right.drive.samples, up, down)
    checks = checks_of(right.with_drive(fast))
    assert figure(checks, "drive_speed") == pytest.approx(down / up, abs=2e-6)
    assert {"drive_speed", "drive_drift", "frames"} <= failed(checks)
    first, last = (right.timeline.events[at].onset_sample for at in (0, -1))
    assert figure(checks, "drive_drift") == pytest.approx((up / down - 1) * (last - first), abs=1.0)
    assert figure(checks, "frames") == len(fast) - len(right.drive.samples)


def test_another_rate_is_named_and_the_timing_still_measured() -> None:
    right = film()
    slow = resampled(right.drive.samples, 147, 160)
    checks = checks_of(right.with_drive(slow, 44_100))
    assert failed(checks) == {"sample_rate"}
    assert figure(checks, "sample_rate") == 44_100
    assert abs(figure(checks, "drive_shift")) < 0.05
    late = checks_of(right.with_drive(np.roll(slow, 441), 44_100))
    assert figure(late, "drive_shift") == pytest.approx(480, abs=0.1)


def test_an_inverted_drive_fails_by_its_correlation_and_is_not_due() -> None:
    right = film()
    checks = checks_of(right.with_drive(-right.drive.samples))
    assert failed(checks) == {"felt_correlation", "drive_as_rendered"}
    assert figure(checks, "felt_correlation", "shot-0001") == pytest.approx(-1.0, abs=0.01)


def test_swapped_shots_fail_and_no_others() -> None:
    right = film()
    drive = right.drive.samples.copy()
    first, third = (right.timeline.events[index].window for index in (0, 2))
    length = min(len(first.span), len(third.span))
    held = drive[first.start : first.start + length].copy()
    drive[first.start : first.start + length] = drive[third.start : third.start + length]
    drive[third.start : third.start + length] = held
    broken = [check for check in checks_of(right.with_drive(drive)) if not check.passed]
    assert {check.event for check in broken} == {"shot-0001", "shot-0003"}
    assert "felt_correlation" in {check.name for check in broken}


def test_a_clipped_gain_fails_by_its_level() -> None:
    right = film()
    checks = checks_of(right.with_drive(np.clip(3.0 * right.drive.samples, -1.0, 1.0)))
    assert "level_as_rendered" in failed(checks)
    assert failed(checks) <= {f"{what}_as_rendered" for what in ("level", "peak", "drive")} | {
        "felt_correlation",
        "felt_lag",
    }
    assert figure(checks, "level_as_rendered", "shot-0001") == pytest.approx(20 * np.log10(3.0), abs=0.6)


def test_a_drive_that_is_raised_against_the_limit_fails_by_its_level() -> None:
    """Its peaks were at the limit before, and stay there: by them alone nobody tells that all else is louder."""
    right = make_film(peaks=(0.5, 0.9, 0.7, 0.8, 0.6))
    assert failed(checks_of(right)) == set()
    for gain in (1.15, 1.2):
        checks = checks_of(right.with_drive(np.clip(gain * right.drive.samples, -1.0, 1.0)))
        assert "level_as_rendered" in failed(checks)


@pytest.mark.parametrize("gain", [1.3, 2.0, 3.0])
def test_a_drive_that_is_louder_and_clipped_is_neither_displaced_nor_drifting(gain: float) -> None:
    right = film()
    checks = checks_of(right.with_drive(np.clip(gain * right.drive.samples, -1.0, 1.0)))
    assert {"drive_shift", "drive_drift", "drive_speed"}.isdisjoint(failed(checks))
    assert "level_as_rendered" in failed(checks)


def test_more_than_the_limit_fails() -> None:
    right = film()
    loud = 1.25 * right.drive.samples
    checks = checks_of(Film(right.audio, Held(loud, RATE_HZ), right.timeline))
    assert {"drive_peak", "peak"} <= failed(checks)
    assert figure(checks, "drive_peak") == pytest.approx(1.25, abs=1e-6)


def test_samples_that_are_no_number_are_counted() -> None:
    right = film()
    checks = checks_of(Film(right.audio, Held(right.drive.samples, RATE_HZ, damaged_samples=5), right.timeline))
    assert failed(checks) == {"drive_samples"}
    assert figure(checks, "drive_samples") == 5


def test_movement_between_windows_is_counted() -> None:
    right = film()
    drive = right.drive.samples.copy()
    drive[[10, 200, 287_000]] = 2.0**-23
    checks = checks_of(right.with_drive(drive))
    assert failed(checks) == {"silence_outside_windows"}
    assert figure(checks, "silence_outside_windows") == 3


@pytest.mark.parametrize("background", ["mute", "direct"])
@pytest.mark.parametrize("end", ["fade_in", "fade_out"])
def test_a_window_without_its_fade_fails(background: Background, end: str) -> None:
    right = film("causal", background, "direct")
    drive, (_, event, *_) = right.drive.samples.copy(), right.timeline.events
    window, onset = event.window, event.onset_sample
    at = window.stop - 60 if end == "fade_out" else window.start
    drive[at : at + 60] = drive[onset : onset + 60]  # cut hard into something that moves
    broken = failed(checks_of(right.with_drive(drive), background=background))
    assert "fades" in broken
    assert broken <= {"fades", "pre_echo", "drive_as_rendered"}
    assert figure(checks_of(right, background=background), "fades") == 0.0


def test_missing_frames_are_counted() -> None:
    right = film()
    checks = checks_of(right.with_drive(right.drive.samples[:-1000]))
    assert failed(checks) == {"frames"}
    assert figure(checks, "frames") == -1000


@pytest.mark.parametrize("bed", [1e-4, 1e-2])
def test_a_drive_that_begins_after_the_bang_fails(bed: float) -> None:
    right = make_film(bed=bed)
    event = right.timeline.events[0]
    drive = right.drive.samples.copy()
    drive[event.window.start : event.onset_sample + round(0.003 * RATE_HZ)] = 0.0
    broken = [c for c in checks_of(right.with_drive(drive)) if not c.passed]
    assert ("felt_onset", event.id) in {(c.name, c.event) for c in broken}
    assert {c.event for c in broken} == {event.id}


def test_a_fade_that_eats_the_attack_fails() -> None:
    right = film()
    first = right.timeline.events[0]
    window = first.window
    late = Window(window.start, window.stop, window.fade_in_samples + 96, window.fade_out_samples)
    checks = checks_of(right.with_events(msgspec.structs.replace(first, window=late), *right.timeline.events[1:]))
    assert failed(checks) == {"fade_in_before_onset"}
    assert figure(checks, "fade_in_before_onset", first.id) == pytest.approx(-1.0)


def test_vibration_before_the_bang_fails() -> None:
    right = film()
    event = right.timeline.events[3]
    drive = right.drive.samples.copy()
    early = slice(event.window.start, event.window.start + 96)
    drive[early] += 0.5 * np.sin(2 * np.pi * 500 * np.arange(96) / RATE_HZ)
    broken = [check for check in checks_of(right.with_drive(drive)) if not check.passed]
    assert ("pre_echo", event.id) in {(check.name, check.event) for check in broken}


@pytest.mark.parametrize("onsets_s", [(0.5,), (0.5, 1.3), (0.7, 1.6, 2.9, 4.1, 5.0)])
def test_a_silent_drive_fails_by_name(onsets_s: tuple[float, ...]) -> None:
    right = make_film(onsets_s=onsets_s, peaks=(0.3,) * len(onsets_s))
    checks = checks_of(right.with_drive(np.zeros(right.drive.frames)))
    assert {"drive_shift", "felt_lag", "felt_correlation"} <= failed(checks)
    assert all(check.measured is None for check in checks if check.name in ("drive_shift", "felt_lag"))


@pytest.mark.parametrize("model", ["direct", "filter", "constrained"])
@pytest.mark.parametrize("phase", ["causal", "zero"])
def test_a_shot_that_is_muted_is_held_to_all_that_it_was_held_to(model: DriveModel, phase: Phase) -> None:
    right = make_film(model=model, phase=phase)
    muted, drive = right.timeline.events[1], right.drive.samples.copy()
    drive[muted.window.start : muted.window.stop] = 0.0
    asked, checks = (checks_of(each, phase=phase) for each in (right, right.with_drive(drive)))
    assert [(check.name, check.event) for check in checks] == [(check.name, check.event) for check in asked]
    subject = "drive" if model == "direct" else "felt"
    lacking = {f"{subject}_lag", f"{subject}_correlation", f"{subject}_onset", "drive_as_rendered", "level_as_rendered"}
    assert {c.name for c in checks if not c.passed} == lacking | {"peak_as_rendered"}
    assert {c.event for c in checks if not c.passed} == {muted.id}


def test_a_film_without_shots_passes_with_nothing_measured() -> None:
    right = film()
    still = right.with_events().with_drive(np.zeros(right.drive.frames))
    checks = checks_of(still)
    assert failed(checks) == set()
    assert [check.measured for check in checks if check.name == "drive_shift"] == [None]


def test_shots_at_both_ends_of_the_film_are_checked() -> None:
    edge = make_film(onsets_s=(0.0, 1.0, 1.95), peaks=(0.05, 0.05, 0.05), seconds=2.0)
    assert failed(checks_of(edge)) == set()


def test_the_actuators_limit_does_not_bend_the_lag() -> None:
    loud = make_film(onsets_s=(0.5,), peaks=(0.95,), seconds=1.0, seed=7)
    (event,) = loud.timeline.events
    assert event.drive is not None
    assert event.drive.model == "constrained"
    assert event.drive.fidelity < 0.98
    checks = checks_of(loud)
    (limit,) = (check.limit for check in checks if check.name == "drive_shift")
    assert limit == RULES.shift_samples
    assert abs(figure(checks, "drive_shift")) < 0.02
    by_one = checks_of(loud.with_drive(np.roll(loud.drive.samples, 1)))
    assert figure(by_one, "drive_shift") == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(("below", "held"), [(-0.01, False), (0.01, True)])
def test_only_a_drive_that_was_to_follow_its_sound_is_held_to_it(below: float, held: bool) -> None:
    loud = make_film(onsets_s=(0.5,), peaks=(0.95,), seconds=1.0, seed=7)
    (event,) = loud.timeline.events
    assert event.drive is not None
    drive = msgspec.structs.replace(event.drive, fidelity=RULES.least_correlation + below)
    told = loud.with_events(msgspec.structs.replace(event, drive=drive))
    late = np.roll(loud.drive.samples, round(0.005 * RATE_HZ))
    assert ("felt_lag" in failed(checks_of(told.with_drive(late)))) is held


def test_a_single_shot_has_no_drift() -> None:
    single = make_film(onsets_s=(0.5,), peaks=(0.4,), seconds=1.0)
    checks = checks_of(single.with_drive(np.roll(single.drive.samples, 1)))
    assert figure(checks, "drive_shift") == pytest.approx(1.0, abs=0.05)
    assert "drive_drift" not in {check.name for check in checks}


def test_shots_of_one_window_are_checked_each_over_its_own_part() -> None:
    onsets_s = (0.5, 0.58, 0.66, 0.74)
    burst = make_film(onsets_s=(0.58,), peaks=(0.06,), seconds=2.0, bed=1e-3)
    (event,) = burst.timeline.events
    shots = [
        msgspec.structs.replace(event, id=f"s{k}", onset_sample=event.onset_sample + round(k * 0.05 * RATE_HZ))
        for k in range(len(onsets_s))
    ]
    checks = checks_of(burst.with_events(*shots))
    assert {c.event for c in checks if c.event} == {"s0", "s1", "s2", "s3"}
    assert "felt_lag" not in failed(checks)
    assert "felt_correlation" not in failed(checks)


def test_a_shot_that_only_other_channels_play_passes_with_nothing_measured() -> None:
    """An effects channel that drives the seat need not hold every shot that is heard."""
    film = make_film()
    second = film.timeline.events[1]
    around = slice(second.window.start - RATE_HZ // 2, second.window.stop + RATE_HZ // 20)
    audio, drive = film.audio.samples.copy(), film.drive.samples.copy()
    audio[around] = drive[around] = 0.0
    film = replace(film, audio=Held(audio, RATE_HZ)).with_drive(drive)
    assert failed(checks_of(film)) == {"peak_as_rendered"}  # of a drive that was there when the timeline was made
    assert second.drive is not None
    silent = msgspec.structs.replace(second, drive=msgspec.structs.replace(second.drive, peak=0.0))
    film = film.with_events(*(silent if event is second else event for event in film.timeline.events))
    checks = checks_of(film)
    assert failed(checks) == set()
    (lag,) = (check for check in checks if (check.name, check.event) == ("felt_lag", second.id))
    assert (lag.measured, lag.limit) == (None, None)
    moved = drive.copy()
    moved[second.onset_sample + 100] = 0.5
    assert ("felt_lag", second.id) in {
        (check.name, check.event) for check in checks_of(film.with_drive(moved)) if not check.passed
    }


@pytest.mark.parametrize("after_ms", [0.2, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("phase", ["causal", "zero"])
def test_a_shot_that_is_over_before_the_next_is_not_held_to_it(after_ms: float, phase: Phase) -> None:
    film = make_film(onsets_s=(0.7,), peaks=(0.06,), seconds=1.5, phase=phase)
    (event,) = film.timeline.events
    onset = event.onset_sample + round(after_ms * RATE_HZ / 1000.0)
    other = msgspec.structs.replace(event, id="shot-0002", onset_sample=onset, onset_s=onset / RATE_HZ)
    film = film.with_events(event, other)
    checks = checks_of(film, phase=phase)
    assert {check.name for check in checks if not check.passed and check.event == event.id} == set()
    assert next(check for check in checks if check.event == event.id and check.name == "felt_lag").limit is None
    assert abs(figure(checks, "drive_shift")) < 0.4
    late = film.with_drive(np.roll(film.drive.samples, 7))
    assert figure(checks_of(late, phase=phase), "drive_shift") == pytest.approx(7, abs=0.4)


def test_without_a_drive_the_onsets_are_sought_in_the_sound() -> None:
    right = film()
    assert failed(check_timeline(right.timeline, audio=right.audio, rules=RULES)) == set()
    wrong = msgspec.structs.replace(
        right.timeline.events[1], onset_sample=right.timeline.events[1].onset_sample - 5_000
    )
    moved = right.with_events(right.timeline.events[0], wrong, *right.timeline.events[2:])
    assert failed(check_timeline(moved.timeline, audio=moved.audio, rules=RULES)) >= {"audio_rise"}


def rises_of(film: Film) -> list[Check]:
    """Return the checks of how the sound rises at each onset, of the timeline without its drive."""
    checks = check_timeline(film.timeline, audio=film.audio, rules=RULES)
    return [check for check in checks if check.name == "audio_rise"]


@pytest.mark.parametrize("after_ms", [3.0, 20.0, 60.0])
def test_without_a_drive_a_shot_of_a_burst_need_not_rise_over_the_one_before_it(after_ms: float) -> None:
    film = make_film(onsets_s=(0.7,), peaks=(0.5,), seconds=1.5)
    (first,) = film.timeline.events
    onset = first.onset_sample + round(after_ms * RATE_HZ / 1000.0)
    softer = msgspec.structs.replace(first, id="shot-0002", onset_sample=onset, onset_s=onset / RATE_HZ)
    opening, following = rises_of(film.with_events(first, softer))
    assert following.measured is not None
    assert following.measured < RULES.rise_db
    assert (following.passed, following.limit) == (True, None)
    assert (opening.passed, opening.limit) == (True, RULES.rise_db)
    window = msgspec.structs.replace(softer.window, start=onset - 48)
    _, alone = rises_of(film.with_events(first, msgspec.structs.replace(softer, window=window)))
    assert (alone.passed, alone.limit) == (False, RULES.rise_db)


@pytest.mark.parametrize("offset", [0.4, -0.05])
def test_a_constant_under_the_film_changes_nothing_of_a_rise(offset: float) -> None:
    film = make_film(onsets_s=(0.1, 0.7), peaks=(0.5, 0.1), seconds=1.5)
    plain = [rise.measured for rise in rises_of(film)]
    moved = replace(film, audio=replace(film.audio, samples=film.audio.samples + offset))
    shifted = [rise.measured for rise in rises_of(moved)]
    assert shifted == pytest.approx(plain, abs=1e-6)


@pytest.mark.parametrize("rate_hz", [44_100, 48_000])
def test_without_a_drive_a_shot_at_the_films_beginning_need_not_rise_over_itself(rate_hz: int) -> None:
    film = make_film(onsets_s=(0.0,), peaks=(0.5,), seconds=1.0, rate_hz=rate_hz)
    (first,) = film.timeline.events
    told = []
    for onset in (0, 3, rate_hz // 100 - 1, rate_hz // 100):
        [rise] = rises_of(film.with_events(msgspec.structs.replace(first, onset_sample=onset)))
        told.append((rise.passed, rise.limit))
    assert told == [(True, None)] * 3 + [(False, RULES.rise_db)]


def test_shots_that_share_a_window_of_half_a_film_are_checked_without_reading_it_for_each_of_them() -> None:
    """A battle is one window: to read all of it for each shot takes the square of its length."""

    @dataclass(frozen=True, eq=False)
    class Counted(Held):
        lengths: list[int] = field(default_factory=list)

        def read(self, span: Span, *, sides: bool = False) -> Clip:
            self.lengths.append(len(span))
            return super().read(span, sides=sides)

    def frames_read(events: tuple[Event, ...]) -> int:
        counted = Counted(apart.audio.samples, RATE_HZ)
        checks_of(replace(apart.with_events(*events), audio=counted))
        return sum(counted.lengths)

    apart = make_film(onsets_s=(0.7, 1.7, 2.7, 3.7, 4.7), seconds=6.0)
    events = apart.timeline.events
    shared = Window(events[0].window.start, events[-1].window.stop, 240, 1920)
    together = tuple(msgspec.structs.replace(event, window=shared) for event in events)
    assert frames_read(together) - frames_read(events) < 2 * apart.audio.frames  # each part once, and around it

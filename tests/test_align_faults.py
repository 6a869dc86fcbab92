"""Loud shots over loud beds, at the actuator's limit: a right drive passes, and what is wrong with one is caught."""

from collections.abc import Callable
from functools import cache

import msgspec
import numpy as np
import pytest

from align_films import (
    PROFILE,
    RATE_HZ,
    Film,
    Held,
    Samples,
    checks_of,
    event_of,
    failed,
    figure,
    in_24_bits,
    limited,
    make_film,
    timeline_of,
    weights_of,
)
from blastline import dsp
from blastline.model import Background, Check, Event, Window

Change = Callable[[Samples, int, slice], None]
"""What is done to a drive, given the onset of a shot and its window."""


@cache
def loud_film(seed: int = 0, background: Background = "mute") -> Film:
    """Return shots of dense noise, clipped at full scale, over a loud bed: their drive is mostly at its limit."""
    return make_film(
        onsets_s=(0.4, 0.9, 1.4),
        peaks=(2.0, 5.0, 1.2),
        seconds=2.0,
        background=background,
        bed=1e-3,
        rumble=0.15,
        tail=1.0,
        seed=seed,
    )


def make_burst(*, gap_s: float = 0.08, shots: int = 3, foresight: bool = False, seed: int = 0) -> Film:
    """Return a film of shots so loud and close that one window holds them, and its drive keeps to the limit.

    Each shot's drive is solved after the one before it, not knowing the next; with `foresight` all are solved as one.
    """
    onsets_s = tuple(0.5 + gap_s * index for index in range(shots))
    single = make_film(onsets_s=onsets_s, peaks=(0.9,) * shots, seconds=1.2, rumble=0.1, seed=seed)
    audio, events = single.audio.samples, single.timeline.events
    first, last = events[0].window, events[-1].window
    window = Window(first.start, last.stop, first.fade_in_samples, last.fade_out_samples)
    target, wet = (
        dsp.run_filter(dsp.discretise(analogue, RATE_HZ), audio)[window.start : window.stop]
        for analogue in (dsp.band(PROFILE), dsp.compensator(PROFILE))
    )
    starts = [event.onset_sample - round(1e-3 * RATE_HZ) for event in events]
    leads = [start - window.start for start in starts]
    solved = limited(target, leads[0], RATE_HZ) if foresight else limited_in_turn(target, wet, leads)
    drive = np.zeros_like(audio)
    drive[window.start : window.stop] = solved * weights_of(window)
    stops = [*starts[1:], window.stop - window.fade_out_samples]
    shared = [
        event_of(index, audio, drive, window, event.onset_sample, 1000, RATE_HZ, "constrained", stop=stop)
        for index, (event, stop) in enumerate(zip(events, stops, strict=True))
    ]
    return Film(single.audio, Held(in_24_bits(drive), RATE_HZ), timeline_of(audio, shared, RATE_HZ))


def limited_in_turn(target: Samples, wet: Samples, leads: list[int]) -> Samples:
    """Return a window's drive solved from shot to shot; each piece may ring on as the compensator's drive would."""
    felt = dsp.discretise(dsp.felt_response(PROFILE), RATE_HZ)
    drive = np.zeros(len(target))
    for start, stop in zip(leads, [*leads[1:], len(target)], strict=True):
        known = np.arange(len(target)) < stop
        rings = dsp.run_filter(felt, np.where(known, np.clip(wet, -1.0, 1.0), 0.0))
        wanted = np.where(known, target, rings) - dsp.run_filter(felt, drive)
        drive += limited(wanted, start, RATE_HZ, stop=stop)
    return drive


@pytest.mark.parametrize(
    ("seed", "background"), [(0, "mute"), (7, "mute"), (10, "mute"), (11, "mute"), (0, "direct"), (10, "direct")]
)
def test_a_right_drive_of_loud_shots_over_a_loud_bed_passes(seed: int, background: Background) -> None:
    right = loud_film(seed, background)
    assert all(event.drive is not None and event.drive.fidelity < 0.93 for event in right.timeline.events)
    checks = checks_of(right, background=background)
    assert failed(checks) == set()
    for event in right.timeline.events:
        assert abs(figure(checks, "felt_onset", event.id)) < 0.1
        assert figure(checks, "pre_echo", event.id) < -100.0


def changed(right: Film, index: int, change: Change) -> list[Check]:
    """Return what fails where `change` is done to the drive, around the onset and in the window of one shot."""
    event, drive = right.timeline.events[index], right.drive.samples.copy()
    change(drive, event.onset_sample, slice(event.window.start, event.window.stop))
    broken = [check for check in checks_of(right.with_drive(np.clip(drive, -1.0, 1.0))) if not check.passed]
    assert {check.event for check in broken} <= {event.id, None}
    return broken


def delayed(by: int) -> Change:
    def change(drive: Samples, onset: int, window: slice) -> None:
        drive[window.start + by : window.stop + by] = drive[window].copy()
        drive[window.start : window.start + max(0, by)] = 0.0
        drive[window.stop + min(0, by) : window.stop] = 0.0

    return change


def inverted(drive: Samples, onset: int, window: slice) -> None:
    drive[window] *= -1.0


def begun_late(drive: Samples, onset: int, window: slice) -> None:
    drive[window.start : onset + ms(2.0)] = 0.0


def faded_in_late(drive: Samples, onset: int, window: slice) -> None:
    drive[window.start : onset] = 0.0
    drive[onset : onset + ms(8.0)] *= np.linspace(0.0, 1.0, ms(8.0))


def shaken_before(drive: Samples, onset: int, window: slice) -> None:
    drive[onset - ms(6.0) : onset - ms(4.0)] += 0.2 * np.sin(2 * np.pi * 250 * np.arange(ms(2.0)) / RATE_HZ)


def ms(duration_ms: float) -> int:
    return round(duration_ms * RATE_HZ / 1000)


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (delayed(ms(10.0)), "felt_lag"),
        (delayed(ms(10.0)), "felt_onset"),
        (delayed(ms(1.0)), "felt_lag"),
        (delayed(ms(-1.0)), "felt_lag"),
        (inverted, "felt_correlation"),
        (begun_late, "felt_onset"),
        (faded_in_late, "felt_onset"),
        (shaken_before, "pre_echo"),
    ],
)
@pytest.mark.parametrize("index", [0, 1, 2])
def test_a_fault_in_a_loud_shot_over_a_loud_bed_fails(change: Change, name: str, index: int) -> None:
    assert name in {check.name for check in changed(loud_film(), index, change)}


@pytest.mark.parametrize(("of", "to"), [(0, 1), (1, 2), (2, 0)])
def test_a_loud_shot_with_the_drive_of_another_fails(of: int, to: int) -> None:
    right = loud_film()
    other = right.timeline.events[of].window

    def change(drive: Samples, onset: int, window: slice) -> None:
        drive[window] = right.drive.samples[other.start : other.start + window.stop - window.start]

    assert "felt_correlation" in {check.name for check in changed(right, to, change)}


def test_the_fade_in_of_a_loud_bed_is_no_pre_echo() -> None:
    quiet = make_film(onsets_s=(0.5,), peaks=(0.03,), seconds=1.0, bed=1e-4, rumble=0.02, seed=11)
    (event,) = quiet.timeline.events
    assert event.drive is not None
    assert event.drive.model == "filter"
    checks = checks_of(quiet)
    assert failed(checks) == set()
    assert figure(checks, "pre_echo", event.id) < -50.0
    assert abs(figure(checks, "drive_shift")) < 0.02


@pytest.mark.parametrize(("early_ms", "fails"), [(6.0, True), (18.0, True), (40.0, False)])
def test_before_a_shot_a_drive_of_unknown_making_may_do_no_more_than_is_heard(early_ms: float, fails: bool) -> None:
    """What is felt longer before belongs to another sound."""

    def unknown(event: Event) -> Event:
        window = event.window
        opened = Window(window.start - ms(80.0), window.stop, window.fade_in_samples, window.fade_out_samples)
        return msgspec.structs.replace(event, drive=None, window=opened)

    made = make_film()
    right = made.with_events(*map(unknown, made.timeline.events))
    assert "pre_echo" not in failed(checks_of(right))
    event, drive = right.timeline.events[3], right.drive.samples.copy()
    start = event.onset_sample - ms(early_ms)
    drive[start : start + ms(2.0)] += 0.2 * np.sin(2 * np.pi * 250 * np.arange(ms(2.0)) / RATE_HZ)
    wrong = {
        check.event for check in checks_of(right.with_drive(drive)) if check.name == "pre_echo" and not check.passed
    }
    assert wrong == ({event.id} if fails else set())


def test_in_a_loud_bed_a_drive_of_unknown_making_may_do_as_much_before_a_shot_as_is_heard() -> None:
    made = make_film(rumble=0.02)
    right = made.with_events(*(msgspec.structs.replace(event, drive=None) for event in made.timeline.events))
    assert any(figure(checks_of(right), "pre_echo", event.id) > -10.0 for event in right.timeline.events)
    assert "pre_echo" not in failed(checks_of(right))


@pytest.mark.parametrize("seed", [0, 1])
def test_between_shots_of_a_window_a_drive_follows_the_one_before(seed: int) -> None:
    right = make_burst(seed=seed)
    checks = checks_of(right)
    assert failed(checks) == set()
    assert all(abs(figure(checks, "felt_onset", event.id)) < 0.1 for event in right.timeline.events)
    event, drive = right.timeline.events[1], right.drive.samples.copy()
    shaken_before(drive, event.onset_sample, slice(0))
    broken = {check.name for check in checks_of(right.with_drive(np.clip(drive, -1.0, 1.0))) if not check.passed}
    assert broken == {"pre_echo"}


def test_a_drive_that_winds_up_for_the_next_shot_fails() -> None:
    checks = checks_of(make_burst(foresight=True))
    assert failed(checks) == {"pre_echo"}


@pytest.mark.parametrize("level_db", [-6.0, 6.0])
def test_at_whatever_level_a_drive_was_rendered_its_attack_is_checked(level_db: float) -> None:
    right = make_film(level_db=level_db)
    assert failed(checks_of(right)) == set()
    event, drive = right.timeline.events[3], right.drive.samples.copy()
    begun_late(drive, event.onset_sample, slice(event.window.start, event.window.stop))
    assert "felt_onset" in failed(checks_of(right.with_drive(drive)))


def test_a_drive_that_is_nowhere_what_is_due_is_late_only_where_it_rests() -> None:
    right = loud_film()
    wet = dsp.run_filter(dsp.discretise(dsp.compensator(PROFILE), RATE_HZ), right.audio.samples)
    drive = np.where(right.drive.samples == 0.0, 0.0, np.clip(wet, -1.0, 1.0))
    first = right.timeline.events[0]
    begun_late(drive, first.onset_sample, slice(first.window.start, first.window.stop))
    told = [check for check in checks_of(right.with_drive(drive)) if check.name == "felt_onset"]
    assert [check.passed for check in told] == [False, True, True]
    assert told[0].measured == pytest.approx(2.0, abs=0.6)
    assert told[1].measured is None
    assert told[2].measured is None

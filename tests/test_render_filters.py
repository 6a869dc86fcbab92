"""The filters of rendering: designed at every rate, settled where they begin, and what is felt through them."""

import math
from contextlib import nullcontext

import msgspec
import numpy as np
import pytest
from scipy.signal import sosfilt

from blastline import dsp
from blastline.errors import RuleError
from blastline.model import Phase, Span
from blastline.render import DriveFilters, drive_filters, hear_window, needed_audio, preroll, require_renderable
from blastline.render.filters import compensated, felt, in_band, settled_band, settled_compensated
from blastline.ruleset import ActuatorProfile
from render_signals import CAUSAL, KINDS, PROFILE, RATE_HZ, RENDER, ZERO, clip, film_with_shot, only_window


@pytest.mark.parametrize("rate_hz", [8_000, 22_050, 44_100, 96_000, 384_000])
@pytest.mark.parametrize("phase", ["causal", "zero"])
def test_filters_design_at_every_rate(rate_hz: int, phase: Phase) -> None:
    filters = drive_filters(PROFILE, rate_hz, phase)
    film, _ = film_with_shot(rate_hz=rate_hz, before_s=0.1, after_s=0.2)
    drive = compensated(film, filters)
    wanted = in_band(film, filters)
    error = np.linalg.norm(felt(drive, filters) - wanted) / np.linalg.norm(wanted)
    assert error < (0.005 if rate_hz >= 44_100 else 0.1)


@pytest.mark.parametrize("filters", [CAUSAL, ZERO], ids=["causal", "zero"])
@pytest.mark.parametrize("kind", KINDS)
def test_compensated_shot_is_felt_as_the_shot_in_the_band(
    filters: DriveFilters, kind: tuple[float, float, float]
) -> None:
    film, _ = film_with_shot(kind)
    wanted = in_band(film, filters)
    error = np.linalg.norm(felt(compensated(film, filters), filters) - wanted) / np.linalg.norm(wanted)
    assert error < 0.005


@pytest.mark.parametrize("filters", [CAUSAL, ZERO], ids=["causal", "zero"])
@pytest.mark.parametrize(("before", "after"), [(28_800, 28_800), (28_800, 100), (1000, 28_799), (1, 0), (0, 28_800)])
def test_filters_that_begin_settled_are_filters_that_have_run(filters: DriveFilters, before: int, after: int) -> None:
    """The state that a window begins with is worked out; run from the start of the sound, it comes to the same."""
    sound = np.random.default_rng(before).standard_normal(before + 5000 + after)
    inside = slice(before, before + 5000)
    for sections, settled in ((filters.band, settled_band), (filters.compensator, settled_compensated)):
        wanted = sosfilt(sections, np.pad(sound, (0, 28_800 - after)))
        wanted = (sosfilt(filters.band, wanted[::-1])[::-1] if filters.phase == "zero" else wanted)[inside]
        found = settled(sound, inside, filters, RENDER)
        assert found.shape == wanted.shape
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-11 * np.max(np.abs(wanted)))


@pytest.mark.parametrize("filters", [CAUSAL, ZERO], ids=["causal", "zero"])
@pytest.mark.parametrize("before_end_ms", [1, 5, 20, 100, 700])
def test_silence_after_the_film_changes_nothing_in_it(filters: DriveFilters, before_end_ms: int) -> None:
    """Backwards filters hear what the forward ones still ring when the film is over: to them it ends in silence."""
    film, shot = film_with_shot(after_s=before_end_ms / 1000.0)
    longer = np.concatenate([film, np.zeros(2 * RATE_HZ)])
    for run in (in_band, compensated):
        wanted = run(longer, filters)[: len(film)]
        np.testing.assert_allclose(run(film, filters), wanted, rtol=0.0, atol=1e-8 * np.max(np.abs(wanted)))
    planned = only_window(film, shot)
    short, long = (hear_window(clip(each), planned, filters=filters, rules=RENDER) for each in (film, longer))
    assert np.array_equal(short.target, long.target)
    assert np.array_equal(short.unlimited, long.unlimited)


@pytest.mark.parametrize("rate_hz", [8_000, 48_000, 192_000])
@pytest.mark.parametrize("lead", [0, 1, 1023, 1024, 1025, 5000])
def test_state_that_sections_arrive_in_is_that_of_running_them(rate_hz: int, lead: int) -> None:
    sections = drive_filters(PROFILE, rate_hz, "causal").compensator
    sound = np.random.default_rng(lead).standard_normal(lead)
    ran = sosfilt(sections, sound, zi=np.zeros((len(sections), 2)))[1] if lead else np.zeros((len(sections), 2))
    found = dsp.settled_state(dsp.settling(sections, lead), sound)
    np.testing.assert_allclose(found, ran, rtol=0.0, atol=1e-10 * max(1.0, float(np.max(np.abs(ran)))))


def test_sound_before_the_lead_is_not_heard() -> None:
    settling = dsp.settling(CAUSAL.compensator, 1500)
    sound = np.random.default_rng(0).standard_normal(1500)
    loud = np.concatenate([np.full(300, 1e6), sound])
    assert np.array_equal(dsp.settled_state(settling, loud), dsp.settled_state(settling, sound))


@pytest.mark.parametrize("rate_hz", [8_000, 16_000, RATE_HZ])
@pytest.mark.parametrize("corner_rad_s", [None, 15_000.0])
def test_impulse_response_is_what_is_felt_of_an_impulse_until_it_has_faded(
    rate_hz: int, corner_rad_s: float | None
) -> None:
    """Also where the actuator fades sooner than its sections do."""
    response = PROFILE.response
    if corner_rad_s is not None:
        poles = ((-corner_rad_s, 0.0),) * 3
        response = msgspec.structs.replace(response, gain=1e8, zeros_rad_s=((-20.0, 0.0),), poles_rad_s=poles)
    filters = drive_filters(msgspec.structs.replace(PROFILE, response=response), rate_hz, "causal")
    whole = felt(np.concatenate([[1.0], np.zeros(rate_hz)]), filters)
    length = len(filters.impulse)
    assert np.array_equal(whole[:length], filters.impulse)
    assert np.max(np.abs(whole[length:])) < 1e-9 * np.max(np.abs(whole))
    assert length < rate_hz // 5


def test_zero_phase_band_is_symmetric_in_time_and_causal_band_is_not() -> None:
    impulse = np.zeros(2 * RATE_HZ + 1)
    impulse[RATE_HZ] = 1.0
    both_ways = in_band(impulse, ZERO)
    np.testing.assert_allclose(both_ways, both_ways[::-1], atol=1e-12)
    assert int(np.argmax(both_ways)) == RATE_HZ
    one_way = in_band(impulse, CAUSAL)
    assert not np.any(one_way[:RATE_HZ])


@pytest.mark.parametrize(("filters", "shortest", "longest"), [(CAUSAL, 0.2, 0.5), (ZERO, -0.01, 0.01)])
def test_lag_of_the_felt_shot(filters: DriveFilters, shortest: float, longest: float) -> None:
    film, shot = film_with_shot(KINDS[0], bed=0.0)
    found = felt(compensated(film, filters), filters)
    lags = np.arange(-60, 61)
    inner = slice(shot.onset - 480, shot.onset + 9600)
    products = np.array([float(np.sum(np.roll(found, -lag)[inner] * film[inner])) for lag in lags])
    best = int(np.argmax(products))
    before, peak, after = products[best - 1 : best + 2]
    lag_ms = (lags[best] + 0.5 * (before - after) / (before - 2.0 * peak + after)) * 1e3 / RATE_HZ
    assert shortest <= lag_ms <= longest


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"lowpass": {"corner_hz": 4000.0}}, r"lowpass.corner_hz: 4000 Hz: expected below 4000 Hz"),
        ({"highpass": {"corner_hz": 5000.0}}, r"highpass.corner_hz: 5000 Hz: expected below 4000 Hz"),
        (
            {"response": {"poles_rad_s": ((-1400.0, 0.0), (-100.0, 3e4), (-100.0, -3e4))}},
            r"crowson-t108sm: response.poles_rad_s\[1\]: 4774.67 Hz: expected below 4000 Hz, half the sound",
        ),
    ],
)
def test_corner_above_half_the_rate_is_refused(changes: dict[str, dict[str, object]], message: str) -> None:
    profile = PROFILE
    for table, keys in changes.items():
        profile = msgspec.structs.replace(profile, **{table: msgspec.structs.replace(getattr(profile, table), **keys)})
    with pytest.raises(RuleError, match=message):
        drive_filters(profile, 8_000, "causal")


def at_gain(factor: float) -> ActuatorProfile:
    """Return the built-in actuator with what is felt of a full drive peaking at `factor`."""
    response = PROFILE.response
    peak = float(np.max(np.abs(dsp.felt_response(PROFILE).at(np.geomspace(1.0, RATE_HZ / 2.0, 5000)))))
    return msgspec.structs.replace(
        PROFILE, response=msgspec.structs.replace(response, gain=factor * response.gain / peak)
    )


@pytest.mark.parametrize("factor", [1e-9, 1e-7, 1e7, 1e9])
def test_an_actuator_in_a_unit_that_none_is_measured_in_is_refused(factor: float) -> None:
    for power in (-5, 0, 5):
        require_renderable(at_gain(10.0**power), RATE_HZ)
    with pytest.raises(RuleError, match=r"what is felt of a full drive peaks at \S+; expected 1e-06 to 1e\+06"):
        require_renderable(at_gain(factor), RATE_HZ)


def test_a_sharp_resonance_that_no_unit_makes_so_strong_is_refused_wherever_it_lies() -> None:
    """A full drive is felt there more than a hundred times as strongly as a little beside it."""
    for at_hz in np.geomspace(800.0, 880.0, 12):
        profile = resonating(float(at_hz))
        felt = profile.response
        peak = float(np.abs(dsp.felt_response(profile).at(np.array([at_hz])))[0])
        for share, refused in ((0.9, False), (1.1, True)):
            raised = msgspec.structs.replace(felt, gain=felt.gain * share * 1e6 / peak)
            with pytest.raises(RuleError, match=r"peaks at 1\.1e") if refused else nullcontext():
                require_renderable(msgspec.structs.replace(profile, response=raised), RATE_HZ)


def resonating(at_hz: float) -> ActuatorProfile:
    """Return the built-in actuator with a resonance of Q 1000 that it answers a hundred times as strongly at."""
    angular = 2.0 * math.pi * at_hz
    response = PROFILE.response
    zeros, poles = (
        tuple((-0.5 * angular / q, sign * angular * math.sqrt(1.0 - 0.25 / q**2)) for sign in (1.0, -1.0))
        for q in (10.0, 1000.0)
    )
    response = msgspec.structs.replace(
        response, zeros_rad_s=response.zeros_rad_s + zeros, poles_rad_s=response.poles_rad_s + poles
    )
    return msgspec.structs.replace(PROFILE, response=response)


@pytest.mark.parametrize("near_hz", [4_500.0, 5_500.0])
def test_a_sharp_resonance_is_steered_wherever_it_lies(near_hz: float) -> None:
    """It is felt well over a part in a thousand of its frequency: less than points over the whole band lie apart."""
    for step in range(0, 60, 6):
        at_hz = near_hz * (1.0 + step / 5000.0)
        stride = drive_filters(resonating(at_hz), RATE_HZ, "causal").recursion.longest_stride
        assert stride == int(RATE_HZ / (2.0 * at_hz)), at_hz


@pytest.mark.parametrize("zero_rad_s", [-1.0, -3.14, -20.0])
def test_filters_that_ring_for_long_have_settled_as_well_when_a_window_begins(zero_rad_s: float) -> None:
    """A zero of the response is a pole of the compensator; what it heard before is not forgotten for seconds."""
    response = msgspec.structs.replace(PROFILE.response, zeros_rad_s=((zero_rad_s, 0.0),))
    filters = drive_filters(msgspec.structs.replace(PROFILE, response=response), 8_000, "causal")
    film = np.random.default_rng(1).standard_normal(30 * 8_000)
    roll = preroll(filters, RENDER)
    assert roll >= RENDER.preroll_ms * 8.0
    start = 26 * 8_000
    whole = compensated(film, filters)[start:]
    part = settled_compensated(film[start - roll :], slice(roll, len(film) - start + roll), filters, RENDER)
    assert np.linalg.norm(part - whole) < 1e-4 * np.linalg.norm(whole)


@pytest.mark.parametrize("zero_rad_s", [-1.0, -20.0, -300.0])
@pytest.mark.parametrize(("low_hz", "order"), [(5.0, 1), (5.0, 4), (2.0, 1), (0.5, 3)])
@pytest.mark.parametrize("phase", ["causal", "zero"])
def test_checks_know_the_pre_roll_that_a_drive_was_made_with(
    zero_rad_s: float, low_hz: float, order: int, phase: Phase
) -> None:
    response = msgspec.structs.replace(PROFILE.response, zeros_rad_s=((zero_rad_s, 0.0),))
    highpass = msgspec.structs.replace(PROFILE.highpass, corner_hz=low_hz, order=order)
    profile = msgspec.structs.replace(PROFILE, response=response, highpass=highpass)
    roll_ms = dsp.preroll_ms(RENDER.preroll_ms, dsp.compensator_slowest_s(profile, phase))
    assert preroll(drive_filters(profile, 8_000, phase), RENDER) == pytest.approx(8.0 * roll_ms, abs=24.0)


def test_needed_audio_is_the_window_with_its_pre_roll_inside_the_film() -> None:
    film, shot = film_with_shot(before_s=0.8)
    planned = only_window(film, shot)
    roll = preroll(CAUSAL, RENDER)
    assert roll == 28_800
    frames = 10 * RATE_HZ
    start, stop = planned.window.start, planned.window.stop
    assert needed_audio(planned, frames=frames, filters=CAUSAL, rules=RENDER) == Span(start - roll, stop)
    assert needed_audio(planned, frames=frames, filters=ZERO, rules=RENDER) == Span(start - roll, stop + roll)
    early = msgspec.structs.replace(shot, onset=10, span=Span(10, 500))
    planned = only_window(film[:600], early)
    assert needed_audio(planned, frames=600, filters=ZERO, rules=RENDER) == Span(0, 600)

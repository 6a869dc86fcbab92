"""Numbers at the extremes: what `study stability` measures at fixed places holds over whole ranges as well."""

import importlib
import json
import math
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.signal import freqz_sos

from blastline import dsp
from blastline.errors import OutputError, RuleError
from blastline.model import DriveModel
from blastline.render import drive_filters
from blastline.ruleset import ActuatorProfile
from blastline.soundtrack import Cue
from blastline.soundtrack.bwf import cue_chunks
from blastline.study import stability, stability_filters
from blastline.study.bars import Bar, exact, refused
from blastline.study.stability import stability_json
from blastline.study.stability_filters import (
    bar_db,
    response_error_db,
    sections_response,
    single_pole,
    time_error_db,
    top_hz,
)
from blastline.study.stability_signals import MODELS, drive_of, shot_film
from commands import blastline
from render_signals import CAUSAL, PROFILE

Fit = tuple[NDArray[np.complex128], int, float]
RATES_HZ = st.sampled_from(stability_filters.RATES_HZ)
SLOW = settings(max_examples=12, derandomize=True)


@st.composite
def roots(draw: st.DrawFn, most: int) -> tuple[tuple[float, float], ...]:
    """Real roots from 1 to 800 Hz and resonances from 20 to 800 Hz, Q 0.5 to 30."""
    found: tuple[tuple[float, float], ...] = ()
    while len(found) < most and draw(st.booleans()):
        if most - len(found) >= 2 and draw(st.booleans()):
            corner_rad_s = 2.0 * math.pi * draw(st.floats(20.0, 800.0))
            real = -corner_rad_s / (2.0 * draw(st.floats(0.51, 30.0)))
            imaginary = math.sqrt(corner_rad_s**2 - real**2)
            found += ((real, imaginary), (real, -imaginary))
        else:
            found += ((-2.0 * math.pi * draw(st.floats(1.0, 800.0)), 0.0),)
    return found


@st.composite
def profiles(draw: st.DrawFn) -> ActuatorProfile:
    poles = draw(roots(6)) or ((-1400.0, 0.0),)
    zeros = draw(roots(len(poles) - 1))
    rise = len(poles) - len(zeros)
    replace = msgspec.structs.replace
    return replace(
        PROFILE,
        response=replace(PROFILE.response, poles_rad_s=poles, zeros_rad_s=zeros, gain=1.0),
        lowpass=replace(
            PROFILE.lowpass,
            corner_hz=draw(st.floats(400.0, 1600.0)),
            order=draw(st.integers(rise + 1, max(6, rise + 1))),
        ),
        highpass=replace(PROFILE.highpass, corner_hz=draw(st.floats(1.0, 40.0)), order=draw(st.integers(1, 4))),
    )


HARD = tuple(
    msgspec.structs.replace(
        PROFILE,
        response=msgspec.structs.replace(PROFILE.response, poles_rad_s=((-1400.0, 0.0),) * poles, zeros_rad_s=()),
        lowpass=msgspec.structs.replace(PROFILE.lowpass, corner_hz=corner_hz, order=poles + 1),
    )
    for poles in (1, 5)
    for corner_hz in (400.0, 1600.0)
)


def near(profile: ActuatorProfile, rate_hz: int, *, lean: bool) -> bool:
    """Return whether both of a profile's compensators keep the bar; float64 is exact enough for that."""
    frequencies = np.concatenate(
        [np.geomspace(1.0, top_hz(rate_hz), 60), np.linspace(0.02, 1.0, 100) * top_hz(rate_hz)]
    )
    for analogue in (dsp.compensator(profile), dsp.inverse(profile) * dsp.half_band(profile)):
        wanted = analogue.at(frequencies)
        _, found = freqz_sos(dsp.discretise(analogue, rate_hz, lean=lean), frequencies, fs=rate_hz)
        peak = np.max(np.abs(wanted[frequencies <= 2000.0]))
        if 20.0 * np.log10(np.max(np.abs(found - wanted)) / peak) > bar_db(rate_hz):
            return False
    return True


@settings(max_examples=10, derandomize=True)
@given(profiles(), st.sampled_from((8_000, 11_025, 44_100)), st.booleans())
def test_any_compensator_is_as_near_to_its_prototype_as_it_must(
    profile: ActuatorProfile, rate_hz: int, lean: bool
) -> None:
    assert near(profile, rate_hz, lean=lean)


@pytest.mark.parametrize("rate_hz", [8_000, 11_025, 44_100])
def test_hard_compensators_keep_their_bar(rate_hz: int) -> None:
    assert all(near(profile, rate_hz, lean=lean) for profile in HARD for lean in (False, True))


@pytest.mark.parametrize(
    ("name", "broken"),
    [
        ("fewer taps", lambda poles, taps, beyond: (poles, taps - 6, beyond)),
        ("other poles", lambda poles, taps, beyond: (np.full(len(poles), 0.9 + 0j), taps, beyond)),
        ("no care for half the rate", lambda poles, taps, beyond: (poles, taps, 30.0)),
    ],
)
def test_a_worse_design_would_be_seen(name: str, broken: Callable[..., Fit], monkeypatch: pytest.MonkeyPatch) -> None:
    """The law above is worth something: designs that are made worse on purpose break it."""
    module = importlib.import_module("blastline.dsp.digital")
    monkeypatch.setattr(module, "FITS", tuple(broken(*fit) for fit in module.FITS))
    assert not all(near(profile, 8_000, lean=False) for profile in HARD)


@SLOW
@given(st.floats(math.log(0.01), math.log(0.9 * math.pi)), st.integers(1, 4), RATES_HZ)
@example(math.log(0.9 * math.pi), 1, 48_000)
def test_single_corners_from_very_slow_to_nearly_half_the_rate(log_corner: float, times: int, rate_hz: int) -> None:
    """The corner runs from 0.01 rad/s to 0.9 of half the rate, on a scale that reaches both."""
    share = (log_corner - math.log(0.01)) / (math.log(0.9 * math.pi) - math.log(0.01))
    corner_rad_s = 0.01 * (0.9 * math.pi * rate_hz / 0.01) ** share
    analogue = single_pole(corner_rad_s, times)
    error_db = response_error_db(analogue, dsp.discretise(analogue, rate_hz), rate_hz, start_hz=1e-4, points=25)
    assert error_db <= bar_db(rate_hz)


@pytest.mark.parametrize("rate_hz", [8_000, 48_000, 384_000])
@pytest.mark.parametrize("times", [1, 2, 3, 4])
def test_slow_poles_keep_their_gain_at_dc_after_rounding(rate_hz: int, times: int) -> None:
    sections = dsp.discretise(single_pole(0.01, times), rate_hz)
    (at_dc,) = sections_response(sections, np.zeros(1), rate_hz)
    assert abs(at_dc - 1) < 1e-6


@settings(max_examples=6, derandomize=True)
@given(st.floats(0.1, 40.0), st.integers(1, 4), RATES_HZ)
def test_every_high_pass_that_a_profile_may_have_is_stable_and_stops_dc(
    corner_hz: float, order: int, rate_hz: int
) -> None:
    band = dsp.butterworth(order, corner_hz, "highpass") * dsp.butterworth(3, 1000.0, "lowpass")
    sections = dsp.discretise(band, rate_hz)
    (at_dc,) = sections_response(sections, np.zeros(1), rate_hz)
    assert abs(at_dc) < 1e-8
    assert response_error_db(band, sections, rate_hz, points=10) <= bar_db(rate_hz) - 20.0


@settings(max_examples=8, derandomize=True)
@given(RATES_HZ, st.integers(0, 99), st.floats(-30.0, 30.0))
def test_filtered_samples_are_those_of_exact_arithmetic(rate_hz: int, seed: int, exponent: float) -> None:
    sections = dsp.discretise(dsp.compensator(PROFILE), rate_hz)
    samples = np.random.default_rng(seed).uniform(-1.0, 1.0, 300) * 10.0**exponent
    assert time_error_db(sections, samples) < -200.0


@given(st.integers(-900, 900), st.integers(0, 2**32 - 1))
def test_a_power_of_two_goes_through_a_filter_to_the_bit(power: int, seed: int) -> None:
    samples = np.random.default_rng(seed).uniform(-1.0, 1.0, 64)
    once = dsp.run_filter(CAUSAL.compensator, samples)
    assert np.array_equal(dsp.run_filter(CAUSAL.compensator, np.ldexp(samples, power)), np.ldexp(once, power))


def test_a_filter_left_alone_comes_to_rest() -> None:
    """Denormals would last for ever: the smallest of them times 0.9 is itself."""
    impulse = np.zeros(3 * 65_536)
    impulse[0] = 1.0
    felt = dsp.run_filter(CAUSAL.felt, impulse)
    assert np.any(felt[:65_536])
    assert not np.any(felt[65_536:])
    assert not np.any(dsp.run_filter(CAUSAL.felt, np.full(1000, 1e-300)))


@pytest.mark.parametrize("start", [0, 1, 65_535, 65_536, 65_537, 100_000])
def test_where_a_run_is_cut_changes_no_bit(start: int) -> None:
    samples = np.random.default_rng(0).standard_normal(140_000)
    late = dsp.run_filter(CAUSAL.compensator, np.concatenate([np.zeros(start), samples]))
    assert np.array_equal(late[start:], dsp.run_filter(CAUSAL.compensator, samples))
    assert not np.any(late[:start])


@pytest.mark.parametrize("model", MODELS)
@settings(max_examples=6, derandomize=True)
@given(exponent=st.floats(-320.0, 150.0))
def test_a_drive_stays_within_the_limit_whatever_the_sound_is(model: DriveModel, exponent: float) -> None:
    drive = drive_of(shot_film(scale=10.0**exponent), 14_400, model, CAUSAL)
    assert np.all(np.abs(drive) <= 1.0)
    assert not np.any(drive[: 14_400 - 48])


@pytest.mark.parametrize(
    ("table", "changes", "message"),
    [
        ("response", {"gain": 1e-200}, r"crowson-t108sm: response.gain = 1e-200: .* expected 1e-06 to 1e\+06"),
        ("response", {"gain": 1e200}, r"response.gain = 1e\+200: .* expected 1e-06 to 1e\+06"),
        ("response", {"zeros_rad_s": ((-0.5, 0.0),)}, r"zeros_rad_s\[0\] = \[-0.5, 0.0\]: .* \(it rings for 10 s\)"),
        ("highpass", {"corner_hz": 1000.0}, r"highpass.corner_hz = 1000: expected below lowpass.corner_hz = 1000"),
        ("lowpass", {"order": 1}, "crowson-t108sm: lowpass.order = 1: expected more than 2"),
    ],
)
def test_profiles_that_no_filter_can_hold_are_refused(table: str, changes: dict[str, object], message: str) -> None:
    replaced = msgspec.structs.replace(getattr(PROFILE, table), **changes)
    with pytest.raises(RuleError, match=message):
        drive_filters(msgspec.structs.replace(PROFILE, **{table: replaced}), 48_000, "causal")


@pytest.mark.parametrize("rate_hz", [-1, 0, 1, 2_000])
def test_a_rate_with_no_room_for_the_band_is_refused(rate_hz: int) -> None:
    with pytest.raises(RuleError, match=f"half the soundtrack's sample rate of {rate_hz} Hz"):
        drive_filters(PROFILE, rate_hz, "zero")


@pytest.mark.parametrize("corner_rad_s", [1e-12, 1e-300])
def test_a_pole_that_rounding_would_make_unstable_is_refused(corner_rad_s: float) -> None:
    with pytest.raises(ValueError, match="decays too slowly"):
        dsp.discretise(single_pole(corner_rad_s), 384_000)


def test_a_gain_beyond_floating_point_is_refused() -> None:
    with pytest.raises(ValueError, match=r"gain of .* cannot be computed"):
        dsp.discretise(dsp.Analogue(np.array([], complex), np.array([-1e3 + 0j]), 0.0), 48_000)


def test_roots_without_their_conjugates_are_refused() -> None:
    with pytest.raises(ValueError, match="conjugates"):
        dsp.discretise(dsp.Analogue(np.array([], complex), np.array([-1e3 - 1e3j]), 1.0), 48_000)


def test_a_marker_beyond_32_bits_is_left_to_the_timeline() -> None:
    last = Cue(2**32 - 1, "last", 5)
    assert cue_chunks([last, Cue(2**32, "beyond")]) == cue_chunks([last])
    assert cue_chunks([Cue(5, "long", 2**33)]) == cue_chunks([Cue(5, "long", 2**32 - 1)])


@pytest.mark.parametrize("family", ["windows", "files", "solver", "measurements", "refusals"])
def test_a_family_of_rows_holds(family: str, tmp_path: Path) -> None:
    rows = list(stability.families()[family](tmp_path))
    assert len(rows) > 5
    assert [row for row in rows if not row.met] == []


def test_rows_know_on_which_side_of_their_bar_they_are() -> None:
    assert Bar("a", -61.0, -60.0).met
    assert not Bar("a", -59.0, -60.0).met
    assert Bar("a", 2.0, 1.0, better="above").margin == 1.0
    assert not Bar("a", 0.5, 1.0, better="above").met
    assert exact("a", 0).met
    assert not exact("a", 1).met
    assert not Bar("a", math.nan, 1.0).met
    assert not Bar("a", math.nan, 1.0, better="above").met
    assert "MISSED" in str(Bar("a", 2.0, 1.0))


def test_the_table_is_printed_and_written_and_a_missed_bar_is_exit_code_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = [Bar("good", 0.5, 1.0, "dB"), Bar("not a number", math.nan, 1.0)]
    monkeypatch.setattr(stability, "families", lambda: {"few": lambda folder: iter(rows)})
    ended = blastline("study", "stability", "--output", tmp_path / "rows.json")
    assert ended.code == 1
    assert "2 rows, 1 miss their bar" in ended.out
    written = json.loads((tmp_path / "rows.json").read_bytes())
    assert [row["met"] for row in written] == [True, False]
    assert [row["measured"] for row in written] == [0.5, None]
    assert stability_json([("few", rows[0])]).endswith(b"\n")
    rows.pop()
    assert blastline("study", "stability").code == 0


def test_without_its_reference_the_study_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stability, "find_spec", lambda name: None)
    assert "pip install 'blastline[study]'" in blastline("study", "stability").complaint


@pytest.mark.parametrize("rate_hz", [44_100, 48_000, 96_000])
@pytest.mark.parametrize("corner_hz", [1000.0, 3000.0, 6000.0])
def test_a_low_pass_far_above_the_band_gains_little_where_nobody_feels_it(rate_hz: int, corner_hz: float) -> None:
    """The prototype falls towards half the rate: fits that are nearer to it below must not rise far over it there."""
    lowpass = msgspec.structs.replace(PROFILE.lowpass, corner_hz=corner_hz)
    analogue = dsp.compensator(msgspec.structs.replace(PROFILE, lowpass=lowpass))
    low, high = np.geomspace(1.0, 2000.0, 200), np.linspace(0.4, 0.5, 500) * rate_hz
    peak = np.max(np.abs(analogue.at(np.geomspace(1.0, 0.4 * rate_hz, 2000))))
    for lean in (False, True):
        sections = dsp.discretise(analogue, rate_hz, lean=lean)
        assert np.max(np.abs(freqz_sos(sections, high, fs=rate_hz)[1])) < 10.0 * np.max(np.abs(analogue.at(high)))
        assert np.max(np.abs(freqz_sos(sections, low, fs=rate_hz)[1] - analogue.at(low))) < 1e-3 * peak


def test_a_full_disk_is_no_refusal_of_an_input() -> None:
    def ask(error: Exception) -> None:
        raise error

    assert refused("an input", lambda: ask(RuleError("out of range"))).met
    assert not refused("an input", lambda: None).met
    with pytest.raises(OutputError, match="no room"):
        refused("an input", lambda: ask(OutputError("no room")))

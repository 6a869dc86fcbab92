"""Fitting: rational systems come back, notches are filled, and every model is stable, and its inverse as well."""

import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from actuator_signals import Seat, run_of
from blastline.actuator import (
    FittedResponse,
    MeasuredResponse,
    Model,
    analogue,
    fit,
    fit_target,
    fitted_profile,
    identify,
    inversion_db,
    level_db,
    octave_errors,
    sensitivity_db,
)
from blastline.actuator.rational import (
    PAPER_FORM,
    fit_form,
    general_form,
    levels_and_derivatives,
    start_from_roots,
)
from blastline.dsp import compensator, felt_response
from blastline.errors import RuleError
from blastline.ruleset import (
    SLOWEST_RAD_S,
    PerceptionCurve,
    check_stable,
    load_actuator,
    load_measuring,
    load_perception,
    perception_names,
)

MEASURING = load_measuring()
RULES = MEASURING.fit
GRID_HZ = np.geomspace(5.0, 2000.0, 200)


def measured_as(level: Callable[[np.ndarray], np.ndarray], frequencies_hz: np.ndarray = GRID_HZ) -> MeasuredResponse:
    return MeasuredResponse(frequencies_hz, 10.0 ** (level(frequencies_hz) / 20.0))


def fit_of(measured: MeasuredResponse, perception: PerceptionCurve | None = None) -> FittedResponse:
    return fit(fit_target(measured, perception, rules=RULES, name="seat.csv"), rules=RULES, name="seat.csv")


def off_db(found: FittedResponse, level: Callable[[np.ndarray], np.ndarray], low_hz: float, high_hz: float) -> float:
    frequencies_hz = np.geomspace(low_hz, high_hz, 400)
    return float(np.max(np.abs(level_db(found.best.model, frequencies_hz) - level(frequencies_hz))))


@pytest.mark.parametrize(
    ("rate_hz", "length_s", "snr_db", "delay_s", "sign"),
    [
        (48_000, 20.0, 40.0, 0.01234, 1.0),
        (8_000, 20.0, 30.0, 0.0201234, 1.0),
        (44_100, 30.0, 10.0, 0.1, -1.0),
        (192_000, 8.0, 40.0, 3.3e-6, 1.0),
        (48_000, 30.0, 0.0, 0.005, 1.0),
    ],
)
def test_an_identified_actuator_is_fitted_back_within_half_a_decibel(
    rate_hz: int, length_s: float, snr_db: float, delay_s: float, sign: float
) -> None:
    seat = Seat(delay_s=delay_s, sign=sign)
    run = run_of(seat, rate_hz=rate_hz, length_s=length_s, snr_db=snr_db)
    found = fit_of(identify(*run, rules=MEASURING.identify).measured)
    assert off_db(found, seat.level_db, 20.0, 1000.0) < 0.5


def test_noise_takes_no_part_in_the_levels_and_its_size_is_told() -> None:
    seat = Seat()
    measured = identify(*run_of(seat, rate_hz=8_000, length_s=60.0, snr_db=-5.0), rules=MEASURING.identify).measured
    target = fit_target(measured, None, rules=RULES, name="seat.csv")
    error = (target.target_db - seat.level_db(target.frequencies_hz)) / target.error_db
    assert abs(np.mean(error)) < 0.25
    assert 0.8 < np.sqrt(np.mean(error**2)) < 1.25


@pytest.mark.parametrize("seat", [Seat(resonance_hz=80.0, damping=0.2), Seat(resonance_hz=700.0, damping=0.4)])
def test_other_resonances_are_fitted_back_as_well(seat: Seat) -> None:
    found = fit_of(identify(*run_of(seat, snr_db=60.0), rules=MEASURING.identify).measured)
    assert off_db(found, seat.level_db, 20.0, 1000.0) < 0.5


def test_the_papers_response_comes_back_as_eq_2() -> None:
    profile, _ = load_actuator("crowson-t108sm")
    felt = felt_response(profile)
    found = fit_of(measured_as(lambda f: 20.0 * np.log10(np.abs(felt.at(f)))))
    assert found.best.is_papers
    ours = analogue(found.best.model)
    assert ours.gain == pytest.approx(2.44e6, rel=1e-3)
    assert ours.zeros == pytest.approx([-20.0], rel=1e-3)
    assert ours.poles == pytest.approx([-1400.0] * 3, rel=1e-3)


def test_noise_does_not_buy_poles() -> None:
    felt = felt_response(load_actuator("crowson-t108sm")[0])
    noise_db = np.random.default_rng(5).normal(0.0, 0.5, len(GRID_HZ))
    found = fit_of(measured_as(lambda f: 20.0 * np.log10(np.abs(felt.at(f))) + noise_db))
    assert found.best.model.poles <= 4
    assert off_db(found, lambda f: 20.0 * np.log10(np.abs(felt.at(f))), 5.0, 1000.0) < 0.6


def two_resonances(frequencies_hz: np.ndarray, sign: float) -> np.ndarray:
    """Return the level of two resonances, 60 and 292 Hz, in phase or against each other."""
    s = 2j * math.pi * frequencies_hz
    total = np.zeros_like(s)
    for hz, damping, gain in ((292.0, 0.1, 1.0), (60.0, 0.05, 0.5 * sign)):
        w = 2.0 * math.pi * hz
        total += gain * w * w / (s * s + 2.0 * damping * w * s + w * w)
    return np.asarray(20.0 * np.log10(np.abs(total)))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_several_resonances_take_more_poles(sign: float) -> None:
    def level(frequencies_hz: np.ndarray) -> np.ndarray:
        return two_resonances(frequencies_hz, sign)

    found = fit_of(measured_as(level))
    assert found.best.model.poles >= 4
    assert off_db(found, level, 20.0, 1000.0) < 0.5
    assert found.papers is not None
    assert found.papers.error_db > 10.0 * found.best.error_db


@pytest.mark.parametrize("largest_gain_db", [20.0, 40.0, 60.0])
def test_a_notch_is_filled_and_the_compensator_bounded(largest_gain_db: float) -> None:
    rules = msgspec.structs.replace(RULES, largest_gain_db=largest_gain_db)
    w, notch = 2.0 * math.pi * 292.0, 2.0 * math.pi * 120.0

    def level(frequencies_hz: np.ndarray) -> np.ndarray:
        s = 2j * math.pi * frequencies_hz
        response = w * w / (s * s + 0.4 * w * s + w * w) * (s * s + 1e-5 * notch * s + notch**2) / (s + notch) ** 2
        return np.asarray(20.0 * np.log10(np.abs(response)))

    frequencies_hz = np.unique(np.append(GRID_HZ, 120.0))
    target = fit_target(measured_as(level, frequencies_hz), None, rules=rules, name="notch.csv")
    assert np.max(target.target_db) - np.min(target.target_db) <= largest_gain_db + 1e-9
    found = fit(target, rules=rules, name="notch.csv")
    assert inversion_db(found.best.model, target, rules=rules) <= largest_gain_db + 1.0
    profile = fitted_profile(found, name="notch", source="a test", origin="a test", rules=rules)
    wide_hz = np.geomspace(0.01, 1e5, 20_000)
    drive_db = 20.0 * np.log10(np.abs(compensator(profile).at(wide_hz)))
    felt_db = 20.0 * np.log10(np.abs(felt_response(profile).at(np.geomspace(*target.band_hz, 2000))))
    assert np.max(drive_db) + np.max(felt_db) <= largest_gain_db + 1.0


@pytest.mark.parametrize("corner_hz", [8.0, 30.0, 90.0])
def test_what_an_inverse_gains_is_what_the_written_profile_drives_at_most(corner_hz: float) -> None:
    """The compensator of the profile is built of filters, in another module, and is asked at its own frequencies."""
    seat = Seat(resonance_hz=150.0, damping=0.3, corner_hz=corner_hz)
    measured = measured_as(seat.level_db)
    target = fit_target(measured, None, rules=RULES, name="seat.csv")
    found = fit(target, rules=RULES, name="seat.csv")
    profile = fitted_profile(found, name="seat", source="a test", origin="a test", rules=RULES)
    low_hz, high_hz = target.band_hz
    drive = np.abs(compensator(profile).at(np.geomspace(0.1 * low_hz, 10.0 * high_hz, 9_999)))
    felt = np.abs(felt_response(profile).at(np.geomspace(low_hz, high_hz, 9_999)))
    gains_db = 20.0 * math.log10(np.max(drive) * np.max(felt))
    assert inversion_db(found.best.model, target, rules=RULES) == pytest.approx(gains_db, abs=0.05)


@pytest.mark.parametrize("seed", range(6))
def test_whatever_was_measured_the_model_and_its_inverse_are_stable(seed: int) -> None:
    random = np.random.default_rng(seed)
    frequencies_hz = np.sort(np.exp(random.uniform(np.log(5.0), np.log(1500.0), 40)))
    bumps = np.cumsum(random.normal(0.0, 3.0, 40))
    measured = measured_as(lambda f: bumps, frequencies_hz)
    found = fit_of(measured)
    felt = analogue(found.best.model)
    assert len(felt.zeros) < len(felt.poles)
    assert max(root.real for root in [*felt.zeros.tolist(), *felt.poles.tolist()]) < 0.0
    np.testing.assert_allclose(
        20.0 * np.log10(np.abs(felt.at(frequencies_hz))), level_db(found.best.model, frequencies_hz), atol=1e-9
    )
    fitted_profile(found, name="any", source="a test", origin="a test", rules=RULES)


def test_derivatives_are_those_of_the_level() -> None:
    form = (*general_form(3, 5), *PAPER_FORM)
    random = np.random.default_rng(0)
    size = 1 + sum(factor.order for factor in form)
    parameters = random.normal(0.0, 0.5, size) + np.where(np.arange(size) % 2, 7.0, 0.0)
    log_w = np.log(2.0 * math.pi * GRID_HZ)
    _, told = levels_and_derivatives(form, parameters, log_w)
    for index in range(size):
        step = np.zeros(size)
        step[index] = 1e-6
        above, _ = levels_and_derivatives(form, parameters + step, log_w)
        below, _ = levels_and_derivatives(form, parameters - step, log_w)
        np.testing.assert_allclose(told[:, index], (above - below) / 2e-6, atol=1e-5)


@pytest.mark.parametrize("zeros", range(6))
@pytest.mark.parametrize("poles", [2, 5])
def test_a_form_has_as_many_zeros_and_poles_as_were_asked_for(zeros: int, poles: int) -> None:
    form = general_form(zeros, poles)
    model = Model(form, start_from_roots(form, [-30.0 - n for n in range(zeros)], [-40.0 - n for n in range(poles)]))
    assert (model.zeros, model.poles) == (zeros, poles)


def test_roots_make_the_start_that_they_are() -> None:
    zeros = [complex(-30.0), complex(-100.0, 900.0), complex(-100.0, -900.0)]
    poles = [complex(-50.0), complex(-70.0), complex(-2000.0), complex(-200.0, 1500.0), complex(-200.0, -1500.0)]
    form = general_form(len(zeros), len(poles))
    again = analogue(Model(form, start_from_roots(form, zeros, poles)))
    for found, wanted in ((again.zeros, zeros), (again.poles, poles)):
        np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(np.array(wanted)), rtol=1e-9)


def test_a_fit_ends_where_it_began_when_that_is_exact() -> None:
    form = general_form(1, 3)
    wanted = np.array([3.0, math.log(100.0), math.log(1800.0), math.log(0.2), math.log(4000.0)])
    levels = level_db(Model(form, wanted), GRID_HZ)
    weights = np.full(len(GRID_HZ), 1.0 / len(GRID_HZ))
    off = wanted + np.array([0.0, 0.3, -0.2, 0.4, 0.1])
    found = fit_form(form, off, GRID_HZ, levels, weights=weights, band_rad_s=(1.0, 2e4))
    np.testing.assert_allclose(found.parameters, wanted, atol=1e-4)


def test_octaves_add_up_to_the_whole() -> None:
    found = fit_of(measured_as(lambda f: two_resonances(f, -1.0) + np.sin(5.0 * np.log(f))))
    rows = octave_errors(found)
    assert [row.centre_hz for row in rows] == sorted(row.centre_hz for row in rows)
    assert max(abs(row.worst_db) for row in rows) >= found.best.error_db
    assert min(row.rms_db for row in rows) <= found.best.error_db <= max(row.rms_db for row in rows)
    for row in rows:
        inside = found.target.target_db[np.abs(np.log2(found.target.frequencies_hz / row.centre_hz)) <= 0.5]
        assert inside.min() <= row.level_db <= inside.max()
    assert all(abs(row.mean_db) <= row.rms_db + 1e-12 <= abs(row.worst_db) + 1e-9 for row in rows)


def test_perception_is_the_square_of_sensitivity_with_its_peak_at_1() -> None:
    assert {"iso-2631-wk", "mpeg-psychohaptic"} <= set(perception_names())
    for name in perception_names():
        curve = load_perception(name)
        frequencies_hz = np.asarray(curve.frequencies_hz)
        thresholds = 10.0 ** (np.asarray(curve.threshold_db) / 20.0)
        wanted = (np.min(thresholds) / thresholds) ** 2
        found = 10.0 ** (sensitivity_db(curve, frequencies_hz) / 20.0)
        np.testing.assert_allclose(found, wanted, rtol=1e-9)
        assert np.max(found) == 1.0
        assert np.all(np.isnan(sensitivity_db(curve, np.array([frequencies_hz[0] * 0.9, frequencies_hz[-1] * 1.1]))))


def test_the_mpeg_curve_is_its_formula() -> None:
    curve = load_perception("mpeg-psychohaptic")
    frequencies_hz = np.asarray(curve.frequencies_hz)
    b = 1.0 - 250.0 / 550.0
    formula = np.abs(50.0 / np.log10(b) ** 2 * np.log10(frequencies_hz / 550.0 + b) ** 2) - 45.0
    np.testing.assert_allclose(curve.threshold_db, formula, atol=0.006)


def test_the_iso_curve_is_the_standards_transfer_function() -> None:
    curve = load_perception("iso-2631-wk")
    frequencies_hz = np.asarray(curve.frequencies_hz)
    s = 2j * math.pi * frequencies_hz

    def corner(hz: float) -> float:
        return 2.0 * math.pi * hz

    high, low = corner(0.4), corner(100.0)
    limits = s**2 / (s**2 + math.sqrt(2.0) * high * s + high**2) * low**2 / (s**2 + math.sqrt(2.0) * low * s + low**2)
    transition = (1.0 + s / corner(12.5)) / (1.0 + s / (0.63 * corner(12.5)) + (s / corner(12.5)) ** 2)
    five, six = corner(2.37), corner(3.35)
    step = (1.0 + s / (0.91 * five) + (s / five) ** 2) / (1.0 + s / (0.91 * six) + (s / six) ** 2) * (five / six) ** 2
    weighting = np.abs(limits * transition * step)
    np.testing.assert_allclose(curve.threshold_db, 20.0 * np.log10(0.015 / weighting), atol=0.06)


@pytest.mark.parametrize("name", ["iso-2631-wk", "mpeg-psychohaptic"])
def test_skin_and_actuator_are_fitted_where_both_are_known(name: str) -> None:
    curve = load_perception(name)
    seat = Seat()

    def felt(frequencies_hz: np.ndarray) -> np.ndarray:
        return np.asarray(seat.level_db(frequencies_hz) + sensitivity_db(curve, frequencies_hz))

    found = fit_of(measured_as(seat.level_db), curve)
    low_hz, high_hz = found.target.band_hz
    assert curve.frequencies_hz[0] <= low_hz < high_hz <= curve.frequencies_hz[-1]
    assert found.best.error_db < 0.5
    assert off_db(found, felt, low_hz, high_hz) < 2.0
    profile = fitted_profile(found, name="both", source="a test", origin="a test", rules=RULES)
    assert profile.lowpass.corner_hz <= high_hz * 1.001
    assert profile.highpass.corner_hz >= low_hz * 0.999


@pytest.mark.parametrize(("resonance_hz", "q"), [(42.0, 3.0), (58.0, 2.0)])
def test_an_accelerometers_response_is_fitted_by_roots_that_a_profile_may_hold(resonance_hz: float, q: float) -> None:
    """Acceleration falls steeply below the resonance, and ISO's curve from 4 Hz down: slow zeros nearly fit there."""
    w = 2.0 * math.pi * resonance_hz

    def level(frequencies_hz: np.ndarray) -> np.ndarray:
        s = 2j * math.pi * frequencies_hz
        return np.asarray(20.0 * np.log10(np.abs(s * s / (s * s + w / q * s + w * w))))

    curve = load_perception("iso-2631-wk")
    found = fit_of(measured_as(level, np.geomspace(2.0, 2000.0, 300)), curve)
    felt = analogue(found.best.model)
    assert max(root.real for root in [*felt.zeros.tolist(), *felt.poles.tolist()]) <= SLOWEST_RAD_S
    assert found.best.error_db < 0.1
    check_stable(
        fitted_profile(found, name="seat", source="a test", origin="a test", rules=RULES, peak_db=-7.0), "seat"
    )


@pytest.mark.parametrize("order", [1, 2, 3])
def test_the_high_pass_of_a_profile_is_of_the_order_in_which_the_response_falls(order: int) -> None:
    """A steeper one would lose what is felt at the low end, a flatter one would boom."""
    corner = 2.0 * math.pi * 100.0

    def level(frequencies_hz: np.ndarray) -> np.ndarray:
        s = 2j * math.pi * frequencies_hz
        return np.asarray(20.0 * np.log10(np.abs((s / (s + corner)) ** order / (1.0 + s / (10.0 * corner)) ** 2)))

    profile = fitted_profile(fit_of(measured_as(level)), name="seat", source="a test", origin="a test", rules=RULES)
    assert profile.highpass.order == order


@pytest.mark.parametrize("order", [2, 3, 4])
def test_beyond_the_band_a_compensator_falls_by_six_decibels_an_octave(order: int) -> None:
    """A flatter one would play hiss, a steeper one would be late by more than it has to."""
    profile = fitted_profile(
        fit_of(measured_as(lambda f: -10.0 * order * np.log10(1.0 + (f / 30.0) ** 2))),
        name="seat",
        source="a test",
        origin="a test",
        rules=RULES,
    )
    low, high = 20.0 * np.log10(np.abs(compensator(profile).at(np.array([1e6, 2e6]))))
    assert high - low == pytest.approx(-20.0 * math.log10(2.0), abs=0.1)


@pytest.mark.parametrize("name", ["two\nlines", "a\tseat"])
def test_a_profile_is_not_named_what_could_not_be_read_again(name: str) -> None:
    with pytest.raises(RuleError, match="expected printable characters alone"):
        fitted_profile(fit_of(measured_as(Seat().level_db)), name=name, source="a test", origin="a test", rules=RULES)


def test_what_has_nothing_in_common_is_refused() -> None:
    far = measured_as(lambda f: np.zeros_like(f), np.geomspace(100.0, 2000.0, 30))
    with pytest.raises(
        RuleError, match=r"^seat.csv: 0 points from 5 to 80 Hz to fit: .*; expected at least 8 points over"
    ):
        fit_of(far, load_perception("iso-2631-wk"))
    lonely = measured_as(lambda f: np.where(np.arange(len(f)) == 50, 100.0, 0.0))
    with pytest.raises(RuleError, match=r"^seat.csv: .* to fit: .* no weaker than 60 dB below the peak"):
        fit_of(lonely)


def test_a_level_moves_with_the_profile_and_nothing_else_does() -> None:
    found = fit_of(measured_as(Seat().level_db))
    plain, moved = (
        fitted_profile(found, name="seat", source="a test", origin="a test", rules=RULES, peak_db=peak_db)
        for peak_db in (None, -7.0)
    )
    frequencies_hz = np.geomspace(5.0, 2000.0, 5000)
    levels = 20.0 * np.log10(np.abs(felt_response(moved).at(frequencies_hz)))
    assert np.max(levels) == pytest.approx(-7.0, abs=1e-3)
    change = levels - 20.0 * np.log10(np.abs(felt_response(plain).at(frequencies_hz)))
    assert np.ptp(change) < 1e-9

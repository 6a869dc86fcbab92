"""Identification: a known actuator is found again whatever rate, noise, delay and polarity; the rest is refused."""

import math

import numpy as np
import pytest
from scipy import signal

from actuator_signals import Seat, noise, recording, run_of, run_through
from blastline.actuator import (
    MeasuredResponse,
    excess_phase,
    identify,
    minimum_phase,
    require_running_along,
    require_unclipped_excitation,
)
from blastline.actuator.delay import coarse_delay
from blastline.actuator.identify import usable_band, welch
from blastline.errors import SoundtrackError
from blastline.ruleset import load_measuring

RULES = load_measuring().identify
MODELLED_HZ = load_measuring().fit.highest_hz


def errors_db(measured: MeasuredResponse, seat: Seat) -> np.ndarray:
    """Return measured less true levels from 20 to 1000 Hz, averaged over 1/12 octave."""
    inside = (measured.frequencies_hz >= 20.0) & (measured.frequencies_hz <= 1000.0)
    frequencies_hz = measured.frequencies_hz[inside]
    error = measured.gain_db[inside] - seat.level_db(frequencies_hz)
    _, group = np.unique(np.floor(12.0 * np.log2(frequencies_hz)), return_inverse=True)
    return np.asarray(np.bincount(group, error) / np.bincount(group))


@pytest.mark.parametrize("rate_hz", [8_000, 22_050, 44_100, 48_000, 96_000, 192_000])
def test_a_known_response_is_found_at_any_rate(rate_hz: int) -> None:
    seat = Seat(delay_s=0.0101234)
    found = identify(*run_of(seat, rate_hz=rate_hz, length_s=8.0, seed=rate_hz), rules=RULES)
    assert np.max(np.abs(errors_db(found.measured, seat))) < 0.15
    assert found.measured.delay_s == pytest.approx(seat.delay_s, abs=2e-5)
    assert found.measured.band_hz[0] < 20.0
    assert found.measured.band_hz[1] > 1000.0
    assert not found.excess.inverted


@pytest.mark.parametrize("delay_s", [-0.75, -1.3 / 48_000, 0.0, 0.4 / 48_000, 0.1, 1.9])
def test_a_delay_is_found_reported_and_taken_out(delay_s: float) -> None:
    rate_hz = 48_000
    seat = Seat(delay_s=delay_s + 1.0)
    sent = noise(16.0, rate_hz)
    came = run_through(seat, np.concatenate([sent, np.zeros(2 * rate_hz)]), rate_hz)[rate_hz:]
    found = identify(recording("x", sent, rate_hz), recording("y", came, rate_hz), rules=RULES)
    measured = found.measured
    assert measured.delay_s == pytest.approx(delay_s, abs=2e-5)
    assert measured.phase_rad is not None
    inside = (measured.frequencies_hz > 30.0) & (measured.frequencies_hz < 700.0)
    error = np.angle(np.exp(1j * measured.phase_rad) / seat.at(measured.frequencies_hz))
    assert np.degrees(np.sqrt(np.mean(error[inside] ** 2))) < 2.0


@pytest.mark.parametrize("snr_db", [0.0, 10.0, 60.0])
def test_noise_in_the_response_widens_the_error_and_biases_nothing(snr_db: float) -> None:
    seat = Seat()
    measured = identify(*run_of(seat, snr_db=snr_db), rules=RULES).measured
    inside = (measured.frequencies_hz > 20.0) & (measured.frequencies_hz < 700.0)
    error = (measured.gain_db - seat.level_db(measured.frequencies_hz))[inside]
    told = measured.error_db[inside]
    assert abs(np.mean(error)) < 4.0 * np.sqrt(np.mean(told**2) / np.sum(inside)) + 0.05
    if snr_db < 60.0:
        assert 0.7 < np.sqrt(np.mean((error / told) ** 2)) < 1.4


def test_polarity_is_told() -> None:
    found = identify(*run_of(Seat(sign=-1.0)), rules=RULES)
    assert found.excess.inverted
    assert found.measured.delay_s == pytest.approx(0.01234, abs=2e-5)


@pytest.mark.parametrize(("resonance_hz", "damping"), [(40.0, 0.15), (120.0, 0.05), (650.0, 0.3)])
def test_other_resonances_are_found(resonance_hz: float, damping: float) -> None:
    seat = Seat(resonance_hz=resonance_hz, damping=damping)
    measured = identify(*run_of(seat, length_s=32.0, snr_db=60.0), rules=RULES).measured
    assert np.max(np.abs(errors_db(measured, seat))) < 0.3


def test_spectra_agree_with_scipy() -> None:
    rate_hz, segment = 8_000, 2_000
    sent, came = noise(5.0, rate_hz), noise(5.0, rate_hz, seed=3)
    came[40:] += 0.7 * sent[:-40]
    ours = welch(recording("x", sent, rate_hz), recording("y", came, rate_hz), lag=0, segment=segment)
    options = {"fs": rate_hz, "window": "hann", "nperseg": segment, "detrend": "constant"}
    frequencies_hz, cross = signal.csd(sent, came, **options)
    _, power = signal.welch(sent, **options)
    _, coherence = signal.coherence(sent, came, **options)
    np.testing.assert_allclose(ours.frequencies_hz, frequencies_hz)
    inner = slice(1, -1)
    np.testing.assert_allclose((ours.cross / ours.excitation)[inner], (cross / power)[inner], rtol=1e-9)
    told = np.abs(ours.cross) ** 2 / (ours.excitation * ours.response)
    np.testing.assert_allclose(told[inner], coherence[inner], rtol=1e-9)


def test_what_is_known_well_throughout_is_known_from_the_first_frequency_to_the_last() -> None:
    frequencies_hz, rules = np.arange(1.0, 401.0), load_measuring().identify
    assert usable_band(frequencies_hz, np.full(400, 0.999), 50.0, rules) == (1.0, 400.0)
    assert usable_band(frequencies_hz, np.zeros(400), 50.0, rules) is None


def test_a_periodic_excitation_has_the_nearest_delay() -> None:
    rate_hz = 8_000
    sent = np.tile(noise(1.0, rate_hz), 12)
    came = np.roll(sent, 80)
    assert coarse_delay(recording("x", sent, rate_hz), recording("y", came, rate_hz), rules=RULES) == 80


def loop(kind: str, period_s: float, rate_hz: int) -> np.ndarray:
    """Return one period of noise, or of a sweep."""
    seconds = np.arange(round(period_s * rate_hz)) / rate_hz
    return noise(period_s, rate_hz) if kind == "noise" else 0.5 * signal.chirp(seconds, 5.0, period_s, 3500.0)


@pytest.mark.parametrize("missing_s", [0.0, 6.0, 10.0])
@pytest.mark.parametrize("period_s", [0.5, 1.0, 1.5])
@pytest.mark.parametrize("kind", ["sweep", "noise"])
def test_a_period_that_was_not_recorded_shifts_no_delay(kind: str, period_s: float, missing_s: float) -> None:
    """Silence before a run, and an end that is missing, leave less to add up at the true delay than at others."""
    rate_hz = 8_000
    seat = Seat(delay_s=0.012345)
    sent = np.concatenate([np.zeros(2 * rate_hz), np.tile(loop(kind, period_s, rate_hz), round(20.0 / period_s))])
    came = run_through(seat, sent, rate_hz)[: len(sent) - round(missing_s * rate_hz)]
    late = coarse_delay(recording("x", sent, rate_hz), recording("y", came, rate_hz), rules=RULES)
    assert late / rate_hz == pytest.approx(seat.delay_s, abs=0.002)


def test_lengths_may_differ_and_silence_around_the_run_does_no_harm() -> None:
    rate_hz = 16_000
    seat = Seat(delay_s=0.003)
    sent = noise(12.0, rate_hz)
    came = run_through(seat, sent, rate_hz)
    for sent_part, came_part in ((sent, came[: 8 * rate_hz]), (sent[: 8 * rate_hz], came)):
        found = identify(recording("x", sent_part, rate_hz), recording("y", came_part, rate_hz), rules=RULES)
        assert np.max(np.abs(errors_db(found.measured, seat))) < 0.3


def test_minimum_phase_is_that_of_exact_systems() -> None:
    frequencies_hz = np.geomspace(5.0, 2000.0, 500)
    for seat in (Seat(), Seat(damping=0.5), Seat(resonance_hz=100.0, damping=0.1)):
        exact = seat.at(frequencies_hz)
        error = np.angle(np.exp(1j * minimum_phase(frequencies_hz, np.abs(exact))) / exact)
        assert np.degrees(np.max(np.abs(error))) < 3.5
        assert np.degrees(np.sqrt(np.mean(error**2))) < 1.0  # the ends of the band, beyond which it is guessed


@pytest.mark.parametrize(("delay_s", "sign"), [(0.0, 1.0), (0.00123, -1.0), (-0.021, 1.0)])
def test_excess_phase_is_delay_and_sign(delay_s: float, sign: float) -> None:
    frequencies_hz = np.arange(5.0, 2000.0)
    turned = sign * Seat().at(frequencies_hz) * np.exp(-2j * math.pi * frequencies_hz * delay_s)
    measured = MeasuredResponse(frequencies_hz, np.abs(turned), np.angle(turned))
    found = excess_phase(measured)
    assert found is not None
    assert found.delay_s == pytest.approx(delay_s, abs=1e-5)
    assert found.inverted == (sign < 0.0)
    assert found.residual_rms_deg < 1.0
    assert excess_phase(MeasuredResponse(frequencies_hz, np.abs(turned))) is None


def test_an_all_pass_is_no_delay_and_is_told() -> None:
    frequencies_hz = np.arange(5.0, 2000.0)
    s = 2j * math.pi * frequencies_hz
    turned = Seat().at(frequencies_hz) * (600.0 - s) / (600.0 + s)
    found = excess_phase(MeasuredResponse(frequencies_hz, np.abs(turned), np.angle(turned)))
    assert found is not None
    assert found.residual_rms_deg > 20.0


def test_a_response_that_does_not_follow_is_refused() -> None:
    sent, came = noise(16.0, 16_000), noise(16.0, 16_000, seed=9)
    with pytest.raises(SoundtrackError, match=r"^y: follows x too little: the coherence reaches 0\.\d\d") as told:
        identify(recording("x", sent, 16_000), recording("y", came, 16_000), rules=RULES)
    assert "\n" not in str(told.value)


def test_clipping_is_refused_and_its_figure_told() -> None:
    sent = noise(16.0, 16_000)
    came = run_through(Seat(), sent, 16_000)
    hard = np.clip(came, -1.5 * np.std(came), 1.5 * np.std(came))
    with pytest.raises(SoundtrackError, match=r"^y: is clipped: 13\.\d % of its samples stand at its peak"):
        identify(recording("x", sent, 16_000), recording("y", hard, 16_000), rules=RULES)
    rare = np.clip(came, -3.0 * np.std(came), 3.0 * np.std(came))
    found = identify(recording("x", sent, 16_000), recording("y", rare, 16_000), rules=RULES)
    assert np.max(np.abs(errors_db(found.measured, Seat()))) < 0.3


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("cut_off", [0.02, 0.2])
def test_what_is_cut_off_on_one_side_is_clipped_as_well(side: float, cut_off: float) -> None:
    """A stop, or an amplifier with an offset, cuts off below the peak of the other side."""
    sent = noise(16.0, 16_000)
    came = side * run_through(Seat(), sent, 16_000)
    one_sided = side * np.minimum(came, np.quantile(came, 1.0 - cut_off))
    told = rf"^y: is clipped: {100.0 * cut_off:.1f} % of its samples stand at its peaks"
    with pytest.raises(SoundtrackError, match=told):
        identify(recording("x", sent, 16_000), recording("y", one_sided, 16_000), rules=RULES)


def require_as_sent(recorded: np.ndarray, came: np.ndarray) -> MeasuredResponse:
    """Return the response to an excitation of which no peaks were found to be cut off after it was sent."""
    heard = recording("x", recorded, 16_000), recording("y", came, 16_000)
    found = identify(*heard, rules=RULES)
    require_unclipped_excitation(*heard, found, rules=RULES)
    return found.measured


def pink_noise(length_s: float) -> np.ndarray:
    spectrum = np.fft.rfft(noise(length_s, 16_000))
    falling = np.fft.irfft(spectrum / np.sqrt(np.maximum(np.arange(len(spectrum)), 20 * length_s)))
    return np.asarray(0.1 * falling / np.std(falling))


@pytest.mark.parametrize("snr_db", [60.0, 20.0, 0.0])
@pytest.mark.parametrize("source", [noise(16.0, 16_000), pink_noise(16.0)], ids=["white", "pink"])
def test_an_excitation_that_was_clipped_later_is_refused(source: np.ndarray, snr_db: float) -> None:
    """Bussgang: Gaussian noise clipped at its rms holds erf(1/sqrt(2)) of itself in 0.516 of its power, + 2.4 dB."""
    came = run_through(Seat(), source, 16_000, snr_db=snr_db)
    told = r"^x: is clipped: 3\d\.\d % of its samples stand at its peaks, up to 0\.1, but y follows higher ones: gains "
    with pytest.raises(SoundtrackError, match=told + r"come out some [2-4]\.\d dB too strong; expected"):
        require_as_sent(np.clip(source, -0.1, 0.1), came)
    with pytest.raises(SoundtrackError, match=r"^x: is clipped: "):
        require_as_sent(np.minimum(source, 0.05), came)
    mild = np.clip(source, -0.24, 0.24)
    assert abs(np.median(errors_db(require_as_sent(mild, came), Seat()))) < 0.3


@pytest.mark.parametrize("snr_db", [60.0, 20.0, 0.0, -5.0])
@pytest.mark.parametrize(
    "sent",
    [
        np.clip(noise(16.0, 16_000), -0.1, 0.1),
        np.clip(pink_noise(16.0), -0.1, 0.1),
        np.minimum(noise(16.0, 16_000), 0.05),
        0.1 * np.sign(noise(16.0, 16_000)),
        0.1 * np.sign(pink_noise(16.0)),
        np.clip(np.round(10.0 * noise(16.0, 16_000)), -2.0, 2.0),
        0.1 * np.sign(noise(16.0, 16_000)) * np.minimum(np.arange(16 * 16_000) / 16_000.0, 1.0),
    ],
    ids=["clipped", "clipped-pink", "one-sided", "binary", "telegraph", "five-levels", "faded-in"],
)
def test_an_excitation_that_was_sent_with_its_flat_peaks_is_as_good_as_any(sent: np.ndarray, snr_db: float) -> None:
    measured = require_as_sent(sent, run_through(Seat(), sent, 16_000, snr_db=snr_db))
    if snr_db > 0.0:
        assert abs(np.mean(errors_db(measured, Seat()))) < 0.1


@pytest.mark.parametrize("samples", [np.zeros(8_000), np.full(8_000, 0.25), np.full(8_000, 1e-9)])
def test_silence_is_refused(samples: np.ndarray) -> None:
    with pytest.raises(SoundtrackError, match=r"^y: is silent; expected a recording of a measurement$"):
        recording("y", samples, 8_000)


def test_rates_that_differ_and_runs_too_short_are_refused() -> None:
    sent, came = run_of(Seat(), rate_hz=16_000, length_s=3.0)
    other = recording("z", noise(3.0, 8_000), 8_000)
    with pytest.raises(SoundtrackError, match=r"^z: has a sample rate of 8000 Hz; expected 16000 Hz, as sent.wav has"):
        identify(sent, other, rules=RULES)
    with pytest.raises(SoundtrackError, match=r"^came.wav: has \d\.\d\d s in common with sent.wav; expected at least"):
        identify(sent, came, rules=RULES)


def test_a_constant_changes_nothing() -> None:
    rate_hz = 16_000
    sent = noise(10.0, rate_hz)
    came = run_through(Seat(), sent, rate_hz)
    pure = identify(recording("x", sent, rate_hz), recording("y", came, rate_hz), rules=RULES).measured
    moved = identify(recording("x", sent + 0.2, rate_hz), recording("y", came - 0.3, rate_hz), rules=RULES).measured
    np.testing.assert_allclose(moved.gain_db, pure.gain_db, atol=1e-6)
    assert moved.delay_s == pytest.approx(pure.delay_s, abs=1e-9)


def require_along(sent: np.ndarray, came: np.ndarray, rate_hz: int) -> MeasuredResponse:
    """Return the response of recordings that were found to run along."""
    heard = recording("x", sent, rate_hz), recording("y", came, rate_hz)
    found = identify(*heard, rules=RULES)
    require_running_along(*heard, found, modelled_hz=MODELLED_HZ, rules=RULES)
    return found.measured


@pytest.mark.parametrize(
    ("lost", "share"), [(5, 0.15), (5, 0.8), (200, 0.5), (9_000, 0.15), (48_000, 0.5), (48_000, 0.8)]
)
def test_a_response_that_lost_samples_on_the_way_is_refused(lost: int, share: float) -> None:
    rate_hz = 48_000
    sent = noise(20.0, rate_hz)
    came = run_through(Seat(), sent, rate_hz)
    at = round(share * len(sent))
    with pytest.raises(
        SoundtrackError, match=rf"^y: slips by {lost}\.\d samples against x on the way, .*too weak"
    ) as told:
        require_along(sent, np.concatenate([came[:at], came[at + lost :]]), rate_hz)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("apart_ppm", [-60.0, -6.0, -3.0, 0.5, 3.0, 6.0, 20.0])
def test_a_clock_that_drifts_is_refused_where_it_spoils_what_is_modelled(apart_ppm: float) -> None:
    """Its delays are spread evenly over the run, so that a gain is measured too weak by sin(x) / x, x = pi f drift."""
    rate_hz, length_s = 16_000, 20.0
    sent = noise(length_s, rate_hz)
    seat = Seat(delay_s=0.01)
    came = run_through(seat, sent, rate_hz, snr_db=60.0)
    fine = signal.resample(came, 16 * len(came))
    came = np.interp(16 * np.arange(len(came)) * (1.0 + 1e-6 * apart_ppm), np.arange(len(fine)), fine)
    weak_db = -20.0 * np.log10(abs(np.sinc(MODELLED_HZ * 1e-6 * apart_ppm * length_s)))
    if weak_db > RULES.random_error_db:
        with pytest.raises(SoundtrackError, match=r"^y: slips by \d+\.\d samples against x on the way"):
            require_along(sent, came, rate_hz)
    else:
        assert np.max(np.abs(errors_db(require_along(sent, came, rate_hz), seat))) < RULES.random_error_db


@pytest.mark.parametrize("snr_db", [60.0, 20.0, 0.0, -10.0])
@pytest.mark.parametrize("seat", [Seat(), Seat(resonance_hz=40.0, damping=0.05), Seat(resonance_hz=20.0, damping=0.02)])
def test_neither_noise_nor_ringing_is_a_slip(seat: Seat, snr_db: float) -> None:
    for seed in range(2):
        sent = noise(20.0, 16_000, seed=seed)
        require_along(sent, run_through(seat, sent, 16_000, snr_db=snr_db, seed=seed), 16_000)


def test_neither_silence_around_a_run_nor_what_repeats_itself_is_a_slip() -> None:
    rate_hz = 16_000
    rest = np.zeros(4 * rate_hz)
    for sent in (np.concatenate([rest, noise(20.0, rate_hz), rest]), np.tile(noise(0.3, rate_hz), 66)):
        require_along(sent, run_through(Seat(), sent, rate_hz), rate_hz)

"""Bode's relation between gain and phase, and what a measured phase has beyond it, against exact systems."""

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.actuator import MeasuredResponse, excess_phase, minimum_phase

Values = NDArray[np.float64]


def points(low_hz: float, octaves: float, per_octave: float) -> Values:
    return np.asarray(low_hz * 2.0 ** (np.arange(round(octaves * per_octave) + 1) / per_octave), np.float64)


@pytest.mark.parametrize("slope", [-3.0, -1.0, 0.0, 0.5, 2.0])
@pytest.mark.parametrize("frequencies_hz", [points(20.0, 3.0, 0.5), points(3.0, 9.0, 48.0), np.arange(5.0, 400.0, 7.3)])
def test_a_straight_bode_plot_has_a_right_angle_of_phase_for_each_order(slope: float, frequencies_hz: Values) -> None:
    """Integrators and differentiators: s^n turns by n right angles at every frequency, whatever its gain."""
    for gain in (1e-6, 1.0, 300.0):
        phase = minimum_phase(frequencies_hz, gain * frequencies_hz**slope)
        np.testing.assert_allclose(phase, slope * math.pi / 2.0, atol=1e-9)


def bodes_relation(log_f: Values, log_gain: Values, slopes_beyond: tuple[float, float], at: int) -> float:
    """Return Bode's integral over straight pieces, as it is written, by numerical integration."""
    slopes = [slopes_beyond[0], *np.diff(log_gain) / np.diff(log_f), slopes_beyond[1]]
    edges = [-mpmath.inf, *log_f, mpmath.inf]

    def weight(u: mpmath.mpf) -> mpmath.mpf:
        return mpmath.log(mpmath.coth(abs(u - log_f[at]) / 2))

    pieces = zip(slopes, edges[:-1], edges[1:], strict=True)
    return float(sum(slope * mpmath.quad(weight, [a, b]) for slope, a, b in pieces) / mpmath.pi)


def test_between_points_the_bode_plot_is_straight_and_beyond_them_it_goes_on() -> None:
    log_f = np.log(points(10.0, 4.0, 2.0)) + 0.05 * np.sin(np.arange(9.0))
    log_gain = np.array([0.0, 0.5, 1.1, 0.4, -0.9, -1.0, 0.2, 0.1, -0.6])
    beyond = tuple(float(np.polyfit(log_f[part], log_gain[part], 1)[0]) for part in (slice(3), slice(-3, None)))
    phase = minimum_phase(np.exp(log_f), np.exp(log_gain))
    for at in range(9):
        assert phase[at] == pytest.approx(bodes_relation(log_f, log_gain, (beyond[0], beyond[1]), at), abs=1e-8)


@pytest.mark.parametrize("wobble_octaves", [0.45, 0.55])
def test_the_slope_beyond_is_that_of_the_last_half_octave(wobble_octaves: float) -> None:
    """A bend further inside does not tilt what goes on beyond: the phase there is the one of straight ends."""
    log_f = np.log(points(10.0, 6.0, 24.0))
    inside = (log_f > log_f[0] + wobble_octaves * math.log(2.0)) & (log_f < log_f[-1] - wobble_octaves * math.log(2.0))
    log_gain = -2.0 * log_f + 0.02 * inside * np.sin(40.0 * log_f)
    wanted = [bodes_relation(log_f, log_gain, (-2.0, -2.0), at) for at in (0, len(log_f) - 1)]
    found = minimum_phase(np.exp(log_f), np.exp(log_gain))[[0, -1]]
    assert np.allclose(found, wanted, atol=1e-6, rtol=0.0) == (wobble_octaves > 0.5)


def test_the_inverse_of_a_system_turns_the_other_way() -> None:
    frequencies_hz, random = points(5.0, 8.0, 12.0), np.random.default_rng(1)
    gain = np.exp(np.cumsum(random.normal(0.0, 0.3, len(frequencies_hz))))
    phase = minimum_phase(frequencies_hz, gain)
    np.testing.assert_allclose(minimum_phase(frequencies_hz, 7.0 / gain), -phase, atol=1e-9)
    # the mirrored plot falls where the other rises
    np.testing.assert_allclose(minimum_phase(1.0 / frequencies_hz[::-1], gain[::-1]), -phase[::-1], atol=1e-9)


def straight(frequencies_hz: Values, slope: int, extra_rad: Values | float = 0.0) -> MeasuredResponse:
    """Return s^n with something beyond its own phase."""
    phase = np.angle(np.exp(1j * (slope * math.pi / 2.0 + extra_rad)))
    phase = np.broadcast_to(phase, frequencies_hz.shape)
    return MeasuredResponse(frequencies_hz, frequencies_hz**slope, phase)


@pytest.mark.parametrize("delay_s", [0.0, 3e-6, -0.0042, 0.0123, -0.0311, 0.0489])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("slope", [-2, 0, 1])
def test_a_delay_and_a_polarity_beyond_a_minimum_phase_are_told_exactly(
    delay_s: float, sign: float, slope: int
) -> None:
    """Also where it turns the phase by whole turns within the 24th of an octave over which that is averaged."""
    frequencies_hz = np.arange(5.0, 2000.0, 0.5)
    turned = -2.0 * math.pi * frequencies_hz * delay_s + (0.0 if sign > 0.0 else math.pi)
    found = excess_phase(straight(frequencies_hz, slope, turned))
    assert found is not None
    assert found.delay_s == pytest.approx(delay_s, abs=1e-8, rel=1e-6)
    assert found.inverted == (sign < 0.0)
    assert found.residual_rms_deg < 2e-3


@pytest.mark.parametrize("off_deg", [2.0, 25.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_is_neither_delay_nor_polarity_is_left(off_deg: float, sign: float) -> None:
    """Phases that are off by turns one way and the other, each in a 24th of an octave of its own."""
    frequencies_hz = points(16.5, 6.0, 24.0)
    off = np.radians(off_deg) * (-1.0) ** np.arange(len(frequencies_hz)) + (0.0 if sign > 0.0 else math.pi)
    found = excess_phase(straight(frequencies_hz, 1, off))
    assert found is not None
    assert found.residual_rms_deg == pytest.approx(off_deg, rel=1e-3)
    assert found.inverted == (sign < 0.0)


def test_only_what_is_known_well_tells() -> None:
    frequencies_hz = np.arange(5.0, 2000.0, 0.5)
    turned, random = -2.0 * math.pi * frequencies_hz * 0.0017, np.random.default_rng(2)
    band_hz = (20.0, 1000.0)
    beyond = (frequencies_hz < band_hz[0]) | (frequencies_hz > band_hz[1])
    wild = np.where(beyond, random.uniform(-3.0, 3.0, len(frequencies_hz)), 0.0)
    found = excess_phase(replace(straight(frequencies_hz, 1, turned + wild), band_hz=band_hz))
    assert found is not None
    assert found.delay_s == pytest.approx(0.0017, abs=1e-8)
    assert found.residual_rms_deg < 1e-3


def test_rows_count_as_they_are_known() -> None:
    """Two neighbours of one 24th of an octave, half a turn apart: the mean is that of the one which is coherent."""
    frequencies_hz = np.repeat(points(16.5, 6.0, 24.0), 2) * np.tile([1.0, 1.001], 145)
    coherence = np.tile([0.999, 0.011], 145)
    turned = np.tile([0.0, 2.5], 145)
    measured = replace(straight(frequencies_hz, 1, turned), coherence=coherence, averages=100.0)
    found = excess_phase(measured)
    assert found is not None
    share = 1.0 / (measured.error_db[:2] ** 2 + 0.25)
    assert share[1] < 0.05 * share[0]
    left = np.angle(share[0] + share[1] * np.exp(2.5j))
    # what is left is alike in all rows, but a delay makes up for some of it
    assert found.residual_rms_deg <= np.degrees(left) * (1.0 + 1e-6)
    assert abs(found.delay_s) < 1e-4


def test_what_is_left_counts_as_it_is_known() -> None:
    """Of a table whose upper half hardly follows what was sent, and is off by 40 degrees one way and the other."""
    frequencies_hz = points(16.5, 6.0, 24.0)
    upper = np.arange(145) >= 73
    off = np.where(upper, np.radians(40.0) * (-1.0) ** np.arange(145), 0.0)
    measured = replace(straight(frequencies_hz, 1, off), coherence=np.where(upper, 0.011, 0.999), averages=100.0)
    known = 1.0 / (measured.error_db**2 + 0.25)
    found = excess_phase(measured)
    assert found is not None
    assert found.residual_rms_deg == pytest.approx(40.0 * math.sqrt(np.sum(known[upper]) / np.sum(known)), rel=0.02)


def test_without_a_phase_there_is_nothing_beyond_it() -> None:
    assert excess_phase(MeasuredResponse(points(10.0, 5.0, 12.0), np.ones(61))) is None

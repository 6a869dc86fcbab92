"""Rows about filters: the sections as rounded, evaluated in 50 digits, against the analogue prototype in 50 digits."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..ruleset import DEFAULT_ACTUATOR, ActuatorProfile, load_actuator
from .bars import Bar, exact

RATES_HZ = (8_000, 11_025, 16_000, 22_050, 32_000, 44_100, 48_000, 88_200, 96_000, 176_400, 192_000, 384_000)
FILM_RATE_HZ = 44_100
_DIGITS = 50

Samples = NDArray[np.float64]


def filter_rows(folder: Path) -> Iterator[Bar]:
    """Yield the rows about filters; needs no files."""
    profile, _ = load_actuator(DEFAULT_ACTUATOR)
    for rate_hz in RATES_HZ:
        yield from _compensator_rows(profile, rate_hz)
    for rate_hz in (8_000, 48_000, 384_000):
        for name, corner_rad_s in (("0.01 rad/s", 0.01), ("0.9 of Nyquist", 0.9 * math.pi * rate_hz)):
            yield _corner_row(f"pole at {name}, {rate_hz} Hz", single_pole(corner_rad_s), rate_hz)
    yield from _unit_circle_rows()
    yield from _time_rows(profile)


def bar_db(rate_hz: int) -> float:
    """Return what the error of a compensator may be at a sample rate, against the prototype's peak below 2 kHz."""
    return -60.0 if rate_hz >= FILM_RATE_HZ else -40.0


def top_hz(rate_hz: int) -> float:
    """Return up to where the bar holds: 2 kHz in films, 0.4 of the sample rate below them."""
    return 2000.0 if rate_hz >= FILM_RATE_HZ else 0.4 * rate_hz


def response_error_db(
    analogue: dsp.Analogue, sections: Samples, rate_hz: int, *, start_hz: float = 1.0, points: int = 60
) -> float:
    """Return the largest complex error of sections up to `top_hz`, against the prototype's peak below 2 kHz."""
    stop_hz = top_hz(rate_hz)
    frequencies = np.concatenate([np.geomspace(start_hz, stop_hz, points), np.linspace(0.5, 1.0, points) * stop_hz])
    wanted = analogue_response(analogue, frequencies)
    found = sections_response(sections, frequencies, rate_hz)
    peak = max(abs(value) for value, hz in zip(wanted, frequencies, strict=True) if hz <= 2000.0)
    worst = max(abs(one - other) for one, other in zip(found, wanted, strict=True)) / peak
    return 20.0 * math.log10(max(float(worst), 1e-30))


def analogue_response(analogue: dsp.Analogue, frequencies_hz: Samples) -> list[Any]:
    """Return H(2 pi i f) in 50 digits."""
    import mpmath

    with mpmath.workdps(_DIGITS):
        values = []
        for frequency in frequencies_hz:
            s = 2j * mpmath.pi * mpmath.mpf(float(frequency))
            value = mpmath.mpf(analogue.gain)
            for zero in analogue.zeros:
                value *= s - mpmath.mpc(complex(zero))
            for pole in analogue.poles:
                value /= s - mpmath.mpc(complex(pole))
            values.append(value)
        return values


def sections_response(sections: Samples, frequencies_hz: Samples, rate_hz: int) -> list[Any]:
    """Return the response of sections as they are, in 50 digits."""
    import mpmath

    with mpmath.workdps(_DIGITS):
        rows = [[mpmath.mpf(float(number)) for number in row] for row in sections]
        values = []
        for frequency in frequencies_hz:
            delay = mpmath.expj(-2 * mpmath.pi * mpmath.mpf(float(frequency)) / rate_hz)
            value = mpmath.mpc(1)
            for b0, b1, b2, a0, a1, a2 in rows:
                value *= (b0 + delay * (b1 + delay * b2)) / (a0 + delay * (a1 + delay * a2))
            values.append(value)
        return values


def exactly_filtered(sections: Samples, samples: Sequence[float]) -> list[Any]:
    """Return samples through the sections, each product and sum in 50 digits."""
    import mpmath

    with mpmath.workdps(_DIGITS):
        signal = [mpmath.mpf(float(sample)) for sample in samples]
        for row in sections:
            b0, b1, b2, _, a1, a2 = (mpmath.mpf(float(number)) for number in row)
            first = second = mpmath.mpf(0)
            for index, sample in enumerate(signal):
                out = b0 * sample + first
                first, second = b1 * sample - a1 * out + second, b2 * sample - a2 * out
                signal[index] = out
        return signal


def time_error_db(sections: Samples, samples: Samples) -> float:
    """Return the largest error of `dsp.run_filter` against the same sections in 50 digits, relative to their peak."""
    exactly = exactly_filtered(sections, samples.tolist())
    found = dsp.run_filter(sections, samples)
    peak = max(abs(value) for value in exactly)
    worst = max(abs(value - float(one)) for value, one in zip(exactly, found, strict=True)) / peak
    return 20.0 * math.log10(max(float(worst), 1e-30))


def single_pole(corner_rad_s: float, times: int = 1) -> dsp.Analogue:
    """Return a low-pass of real poles, 1 at DC."""
    return dsp.Analogue(np.array([], np.complex128), np.full(times, -corner_rad_s + 0j), corner_rad_s**times)


def _compensator_rows(profile: ActuatorProfile, rate_hz: int) -> Iterator[Bar]:
    halves = {"causal": dsp.compensator(profile), "zero-phase": dsp.inverse(profile) * dsp.half_band(profile)}
    for phase, analogue in halves.items():
        error_db = response_error_db(analogue, dsp.discretise(analogue, rate_hz, lean=True), rate_hz)
        yield Bar(f"compensator, {phase}, {rate_hz} Hz", error_db, bar_db(rate_hz), "dB")


def _corner_row(name: str, analogue: dsp.Analogue, rate_hz: int) -> Bar:
    error_db = response_error_db(analogue, dsp.discretise(analogue, rate_hz), rate_hz, start_hz=1e-4)
    return Bar(name, error_db, bar_db(rate_hz), "dB")


def _unit_circle_rows() -> Iterator[Bar]:
    """Yield what rounding does to the slowest poles at the highest rate: their exact place is their gain at DC."""
    slow = dsp.discretise(single_pole(0.01, 3), 384_000)
    (at_dc,) = sections_response(slow, np.zeros(1), 384_000)
    error_db = 20.0 * math.log10(max(float(abs(at_dc - 1)), 1e-30))
    yield Bar("three poles at 0.01 rad/s, 384 kHz: gain at DC", error_db, -120.0, "dB")
    for order in (1, 2, 3, 4):
        band = dsp.butterworth(order, 1.0, "highpass") * dsp.butterworth(3, 1000.0, "lowpass")
        error_db = response_error_db(band, dsp.discretise(band, 384_000), 384_000)
        yield Bar(f"high-pass at 1 Hz, order {order}, 384 kHz", error_db, -120.0, "dB")
    sharp = complex(-math.pi, 2000.0 * math.pi)
    ringing = dsp.Analogue(np.array([], np.complex128), np.array([sharp, sharp.conjugate()]), abs(sharp) ** 2)
    error_db = response_error_db(ringing, dsp.discretise(ringing, 384_000), 384_000)
    yield Bar("resonance of Q 1000 at 1 kHz, 384 kHz", error_db, -60.0, "dB")


def _time_rows(profile: ActuatorProfile) -> Iterator[Bar]:
    """Yield the rounding of the filters on samples: a square at full scale, and noise at the highest rate."""
    square = np.where(np.arange(1500) // 40 % 2 == 0, 1.0, -1.0)
    sections = dsp.discretise(dsp.compensator(profile), 48_000)
    yield Bar("compensator on a full-scale square, 48 kHz", time_error_db(sections, square), -200.0, "dB")
    noise = np.random.default_rng(0).uniform(-1.0, 1.0, 1500)
    sections = dsp.discretise(dsp.compensator(profile), 384_000)
    yield Bar("compensator on noise, 384 kHz", time_error_db(sections, noise), -180.0, "dB")
    slow = dsp.discretise(single_pole(0.01, 3), 384_000)
    yield Bar("three poles at 0.01 rad/s on noise, 384 kHz", time_error_db(slow, noise), -180.0, "dB")
    stuck = np.flatnonzero(dsp.run_filter(sections, np.zeros(100_000)))
    yield exact("compensator on digital silence", len(stuck))

"""From what was sent to an actuator and what came of it to its frequency response.

    H1(f) = Sxy(f) / Sxx(f)          coherence(f) = |Sxy|^2 / (Sxx Syy)

with Welch's averaged spectra of Hann segments that overlap by half. Noise in the response averages out of H1; the
excitation is known. The delay between the recordings is found first and taken out, because a response that lies
partly outside its segment would be measured too weak. Both recordings are read segment by segment: memory does not grow
with their length.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import SoundtrackError
from ..medians import weighted_median
from ..model import Span
from ..ruleset import IdentifyRules
from .delay import coarse_delay
from .measured import MeasuredResponse, standard_error_db, unbiased
from .phase import ExcessPhase, excess_phase
from .recording import Recording

Values = NDArray[np.float64]
Spectrum = NDArray[np.complex128]

INDEPENDENT = 0.947
"""Of Hann segments that overlap by half, the share that counts as independent (Welch 1967)."""

RELATED = 1.94
"""By so much neighbouring bins of a Hann window, correlated by 2/3 and 1/6, raise the variance of a sum over them."""

_HIGHEST_OF_RATE = 0.45
"""Nearer to half the sample rate the converters' own filters are measured as well."""

_LEAST_STEADY = 0.2
"""Of a sweep each frequency is heard in one or two of 30 segments and more; of noise, in the mean, in half of them."""

_FAINT = 1e-3
"""A recording that peaks lower has 33 steps of 16 bits at most: many of its samples stand at its peaks."""

_TOLERATED_SHIFT = 0.005
"""A response that lies this share of a segment late is measured 0.04 dB too weak."""


@dataclass(frozen=True, eq=False)
class Spectra:
    """Averaged power spectra of excitation and response and their cross spectrum, over `segments` segments.

    `steady` is the share of these segments that hold a frequency of the excitation: half of them in the mean for noise,
    all for what repeats itself in each, one for a sweep.
    """

    frequencies_hz: Values
    excitation: Values
    response: Values
    cross: Spectrum
    steady: Values
    segments: int


@dataclass(frozen=True, eq=False)
class Identified:
    """A measured response, how long its segments were, and what its phase says beyond the magnitude."""

    measured: MeasuredResponse
    segment_s: float
    segments: int
    excess: ExcessPhase


def identify(excitation: Recording, response: Recording, *, rules: IdentifyRules) -> Identified:
    """Return an actuator's response from two recordings of one run, which may start and end at different times.

    Raises SoundtrackError for recordings of different rates, too short a common part, a clipped response, a sweep, or
    a response that has nothing to do with the excitation.
    """
    _check(excitation, response, rules)
    rate_hz = excitation.rate_hz
    lag = coarse_delay(excitation, response, rules=rules)
    segment = _segment(excitation, response, lag, rules)
    measured, excess = _measure(excitation, response, lag, segment, rules)
    late = round(excess.delay_s * rate_hz)
    if abs(late) > _TOLERATED_SHIFT * segment:
        lag += late
        segment = _segment(excitation, response, lag, rules)
        measured, excess = _measure(excitation, response, lag, segment, rules)
    segments = _count(common(excitation, response, lag), segment)
    return Identified(measured, segment / rate_hz, segments, excess)


def common(excitation: Recording, response: Recording, lag: int) -> Span:
    """Return the part of the excitation that both recordings hold."""
    start = max(0, -lag)
    return Span(start, max(start, min(excitation.frames, response.frames - lag)))


def welch(excitation: Recording, response: Recording, *, lag: int, segment: int, within: Span | None = None) -> Spectra:
    """Return the averaged spectra of segments of `segment` samples, the response taken `lag` samples later.

    They are those of all that both recordings hold, or of the part `within` of the excitation.
    """
    from scipy.fft import rfft, rfftfreq

    window = np.hanning(segment + 1)[:-1]
    heard = within or common(excitation, response, lag)
    frequencies_hz = rfftfreq(segment, 1.0 / excitation.rate_hz)
    power_in, squared_in, power_out = (np.zeros(len(frequencies_hz)) for _ in range(3))
    cross = np.zeros(len(frequencies_hz), dtype=np.complex128)
    count = _count(heard, segment)
    for index in range(count):
        place = heard.start + index * (segment // 2)
        samples_in, samples_out = excitation.read(place, segment), response.read(place + lag, segment)
        spectrum_in = rfft(window * (samples_in - np.mean(samples_in)))
        spectrum_out = rfft(window * (samples_out - np.mean(samples_out)))
        power_in += np.abs(spectrum_in) ** 2
        squared_in += np.abs(spectrum_in) ** 4
        power_out += np.abs(spectrum_out) ** 2
        cross += np.conj(spectrum_in) * spectrum_out
    steady = power_in**2 / np.maximum(count * squared_in, 1e-300)
    return Spectra(frequencies_hz, power_in / count, power_out / count, cross / count, steady, count)


def usable_band(
    frequencies_hz: Values, coherence: Values, averages: float, rules: IdentifyRules
) -> tuple[float, float] | None:
    """Return the widest range (in octaves) of well-known gains; None where there is none.

    `coherence` is of `averages` independent segments. Known well is what it says of the third of an octave around a
    frequency: its mean without the bias of chance, and the standard error of the gain averaged over it.
    """
    coherence = unbiased(coherence, averages)
    error_db = standard_error_db(coherence, averages)
    low = np.searchsorted(frequencies_hz, frequencies_hz * 2.0 ** (-1.0 / 6.0))
    high = np.searchsorted(frequencies_hz, frequencies_hz * 2.0 ** (1.0 / 6.0), side="right")

    def summed(values: Values) -> Values:
        total = np.concatenate([[0.0], np.cumsum(values)])
        return np.asarray(total[high] - total[low], dtype=np.float64)

    mean = summed(coherence) / (high - low)
    weight = np.maximum(summed(1.0 / np.maximum(error_db, 1e-6) ** 2), 1e-12)  # rounding may leave 0 of the faintest
    together_db = 1.0 / np.sqrt(weight)
    good = (mean >= rules.least_coherence) & (together_db <= rules.random_error_db)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(np.int8)))
    runs = [(float(frequencies_hz[a]), float(frequencies_hz[b - 1])) for a, b in edges.reshape(-1, 2)]
    return max(runs, key=lambda run: run[1] / run[0], default=None)


def _measure(
    excitation: Recording, response: Recording, lag: int, segment: int, rules: IdentifyRules
) -> tuple[MeasuredResponse, ExcessPhase]:
    """Return the response with its delay taken out of the phase, and what was found beyond `lag`."""
    spectra = welch(excitation, response, lag=lag, segment=segment)
    highest_hz = min(rules.highest_hz, _HIGHEST_OF_RATE * excitation.rate_hz)
    rows = (spectra.frequencies_hz <= highest_hz) & (np.arange(len(spectra.frequencies_hz)) >= 2)
    floor = 1e-12 * float(np.max(spectra.excitation))
    rows &= spectra.excitation > floor
    _require_steady(excitation, spectra, rows)
    power_in, power_out, cross = spectra.excitation[rows], spectra.response[rows], spectra.cross[rows]
    transfer = cross / power_in
    coherence = np.minimum(np.abs(cross) ** 2 / np.maximum(power_in * power_out, 1e-300), 1.0)
    frequencies_hz, averages = spectra.frequencies_hz[rows], INDEPENDENT * spectra.segments
    band_hz = usable_band(frequencies_hz, coherence, averages, rules)
    if band_hz is None or band_hz[1] < 2.0 * band_hz[0]:
        best = float(np.max(coherence, initial=0.0))
        raise SoundtrackError(
            f"{response.name}: follows {excitation.name} too little: the coherence reaches {best:.2f}, and not over an "
            "octave what a response needs; expected excitation and response of one run"
        )
    measured = MeasuredResponse(
        frequencies_hz, np.abs(transfer), np.angle(transfer), coherence, averages, band_hz=band_hz
    )
    excess = excess_phase(measured)
    assert excess is not None
    turned = np.angle(transfer * np.exp(2j * math.pi * frequencies_hz * excess.delay_s))
    return replace(measured, phase_rad=turned, delay_s=lag / excitation.rate_hz + excess.delay_s), excess


def _require_steady(excitation: Recording, spectra: Spectra, rows: NDArray[np.bool_]) -> None:
    """Raise SoundtrackError where most of what is sent is sent once only: no segment then bears another out.

    Most by power: the rounding of a file of 16 bits is steady, in all the frequencies that a sweep never comes to.
    """
    typical = weighted_median(spectra.steady[rows], spectra.excitation[rows]) if rows.any() else 1.0
    if typical < _LEAST_STEADY:
        raise SoundtrackError(
            f"{excitation.name}: most frequencies are heard in about {typical * spectra.segments:.0f} of "
            f"{spectra.segments} segments, as in a sweep; expected noise, or what repeats itself in each segment: only "
            "where segments agree is a gain known"
        )


def _check(excitation: Recording, response: Recording, rules: IdentifyRules) -> None:
    if excitation.rate_hz != response.rate_hz:
        raise SoundtrackError(
            f"{response.name}: has a sample rate of {response.rate_hz} Hz; expected {excitation.rate_hz} Hz, "
            f"as {excitation.name} has"
        )
    if response.at_peak > rules.clipped_ratio:
        what, level = ("has few steps", "higher") if response.peak < _FAINT else ("is clipped", "lower")
        raise SoundtrackError(
            f"{response.name}: {what}: {100.0 * response.at_peak:.1f} % of its samples stand at its peaks, up to "
            f"{response.peak:.3g}; expected at most {100.0 * rules.clipped_ratio:g} %: record it at a {level} level"
        )


def _count(span: Span, segment: int) -> int:
    return max(0, (len(span) - segment) // (segment // 2) + 1)


def _segment(excitation: Recording, response: Recording, lag: int, rules: IdentifyRules) -> int:
    """Return the length of a segment in samples: even, and one that transforms fast."""
    from scipy.fft import next_fast_len

    shared = common(excitation, response, lag)
    for segment_s in sorted(rules.segments_s, reverse=True):
        segment = int(next_fast_len(round(segment_s * excitation.rate_hz / 2.0), real=True)) * 2
        if _count(shared, segment) >= rules.fewest_segments:
            return segment
    needed_s = min(rules.segments_s) * (rules.fewest_segments + 1) / 2.0
    raise SoundtrackError(
        f"{response.name}: has {len(shared) / excitation.rate_hz:.2f} s in common with {excitation.name}; "
        f"expected at least {needed_s:.2g} s"
    )

"""Whether a response runs along with its excitation: a recorder that lost samples, or a clock of its own, slips.

Where the delay differs from part to part, the parts' responses are averaged with different phases and cancel. With
delays d_k of the parts, a gain is measured too weak by

    |mean_k exp(-2 pi i f d_k)|

however the slip came about. So a slip is judged by that, up to where a model is fitted, against what a gain has to be
known to.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..correlate import parabolic_offsets
from ..errors import SoundtrackError
from ..model import Span
from ..ruleset import IdentifyRules
from .delay import coarse_delay, nearest_peak
from .identify import INDEPENDENT, Identified, Spectrum, Values, common, usable_band, welch
from .recording import Recording

_PARTS = 8
_FINE = 4
"""Into so many steps a sample is divided where delays are compared; between them a parabola is laid."""

_SURE = 10.0
"""Standard deviations of chance above which a peak tells a delay; the highest of 10^5 that chance makes is at 7, the
bins of a Hann window being related. A part that tells none, a silent one, is not judged."""

_TRIED = 4096  # frequencies at which a slip is judged
_LEAST_GAIN = 1e-3  # a gain below this is as good as none


@dataclass(frozen=True)
class _Part:
    """A part of a run: its delay to within the ringing, and the complex coherence at that delay, of `averages`."""

    lag: int
    coherency: Spectrum
    averages: float
    power: float


def require_running_along(
    excitation: Recording, response: Recording, identified: Identified, *, modelled_hz: float, rules: IdentifyRules
) -> None:
    """Raise SoundtrackError where a slip makes a gain that was identified too weak, up to `modelled_hz`."""
    delays = part_delays(excitation, response, identified, rules=rules)
    low_hz, high_hz = identified.measured.band_hz
    # not the bins of the spectrum: a slip of a whole segment turns each of them by whole turns
    frequencies_hz = np.geomspace(low_hz, max(low_hz, min(modelled_hz, high_hz)), _TRIED)
    gains = np.abs(np.mean(np.exp(-2j * np.pi * np.outer(frequencies_hz, delays) / excitation.rate_hz), axis=1))
    worst = int(np.argmin(gains))
    weak_db = -20.0 * np.log10(max(float(gains[worst]), _LEAST_GAIN))
    if weak_db > rules.random_error_db:
        raise SoundtrackError(
            f"{response.name}: slips by {np.ptp(delays):.1f} samples against {excitation.name} on the way, as where "
            f"samples were lost or two clocks drift: a gain at {frequencies_hz[worst]:.0f} Hz comes out {weak_db:.1f} "
            f"dB too weak; expected recordings that run along, so that it is known to {rules.random_error_db:g} dB"
        )


def part_delays(excitation: Recording, response: Recording, identified: Identified, *, rules: IdentifyRules) -> Values:
    """Return by how many samples the response is later in each part of a run than in the loudest one.

    Parts that cannot tell are left out; by what chance displaces the others, a gain comes out some hundredths of a dB
    too weak.
    """
    rate_hz = excitation.rate_hz
    segment = round(identified.segment_s * rate_hz)
    lag = round(identified.measured.delay_s * rate_hz)
    shared = common(excitation, response, lag)
    count = max(1, min(_PARTS, identified.segments // 3))  # so that each holds two segments
    edges = np.linspace(shared.start, shared.stop, count + 1).astype(np.int64).tolist()
    parts = [
        _part(excitation, response, Span(start, stop), lag=lag, segment=segment, rules=rules)
        for start, stop in pairwise(edges)
    ]
    coherence: Values = np.mean([np.abs(part.coherency) ** 2 for part in parts], axis=0, dtype=np.float64)
    frequencies_hz = np.asarray(np.fft.rfftfreq(segment, 1.0 / rate_hz), dtype=np.float64)
    band_hz = usable_band(frequencies_hz, coherence, parts[0].averages, rules)
    loudest = max(parts, key=lambda part: part.power)
    told = [
        part.lag - loudest.lag + found
        for part in parts
        if band_hz is not None
        and (found := _delay(part.coherency * np.conj(loudest.coherency), band_hz, segment, rate_hz)) is not None
    ]
    return np.array(told or [0.0], dtype=np.float64)


def _part(
    excitation: Recording, response: Recording, span: Span, *, lag: int, segment: int, rules: IdentifyRules
) -> _Part:
    near = coarse_delay(excitation, response, rules=rules, within=span, near=lag)
    spectra = welch(excitation, response, lag=near, segment=segment, within=span)
    power = spectra.excitation * spectra.response
    coherency = np.where(power > 0.0, spectra.cross / np.sqrt(np.maximum(power, 1e-300)), 0.0)
    coherency[(spectra.frequencies_hz > rules.highest_hz) | (np.arange(len(power)) < 2)] = 0.0
    return _Part(near, coherency, INDEPENDENT * spectra.segments, float(np.sum(np.abs(spectra.cross))))


def _delay(coherence: Spectrum, band_hz: tuple[float, float], segment: int, rate_hz: int) -> float | None:
    """Return the delay in samples that turns the phases in a band; None where chance might."""
    size = _FINE * segment
    frequencies_hz = np.fft.rfftfreq(segment, 1.0 / rate_hz)
    coherence = np.where((frequencies_hz >= band_hz[0]) & (frequencies_hz <= band_hz[1]), coherence, 0.0)
    heights = np.roll(np.fft.irfft(coherence, size), size // 2) * (size / 2.0)
    lags: NDArray[np.int64] = np.arange(size) - size // 2
    peak = nearest_peak(heights, lags, reach=_FINE * rate_hz // 100)
    if heights[peak] <= _SURE * np.sqrt(np.sum(np.abs(coherence) ** 2) / 2.0) or not 0 < peak < size - 1:
        return None
    return float(lags[peak] + parabolic_offsets(heights, np.array([peak]))[0]) / _FINE

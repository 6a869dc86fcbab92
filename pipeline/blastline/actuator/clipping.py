"""Whether an excitation was clipped after it had been sent, as a recording of it at the amplifier may be.

Noise that was clipped before it was sent is as good as any other; some has nothing but peaks. What was clipped later
lacks what was sent beyond its peaks, and the response, which has it, is measured too strong: by 2.4 dB for Gaussian
noise clipped at its rms. The response y tells the two apart. With p, the excitation x where it stands at its peaks and
0 elsewhere, and n what is left,

    Y = H X + G P + n,    G = H r

holds with r = 0 for what was sent as it is, and else with the share r of their height that the peaks lack in the mean.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import SoundtrackError
from ..ruleset import IdentifyRules
from .identify import INDEPENDENT, RELATED, Identified, common
from .recording import Recording

_LIKELY = 4.0
"""Standard errors that chance exceeds once in 30000 runs."""

_LEAST_APART = 1e-6
"""Peaks that differ from what the excitation explains by less than this share of their power are all that there is."""


@dataclass(frozen=True)
class _Lacking:
    """The share of their height that an excitation's peaks lack, its standard error, and how much of it they are."""

    share: float
    error: float
    peaks_in_excitation: float


def require_unclipped_excitation(
    excitation: Recording, response: Recording, identified: Identified, *, rules: IdentifyRules
) -> None:
    """Raise SoundtrackError where gains were measured too strong because the excitation's peaks were cut off later."""
    if excitation.at_peak <= rules.clipped_ratio:
        return
    lacking = _lacking(_cross_spectra(excitation, response, identified), identified, excitation.rate_hz)
    strong_db = 20.0 * np.log10(1.0 + max(lacking.share, 0.0) * max(lacking.peaks_in_excitation, 0.0))
    if lacking.share > _LIKELY * lacking.error and strong_db > rules.random_error_db:
        raise SoundtrackError(
            f"{excitation.name}: is clipped: {100.0 * excitation.at_peak:.1f} % of its samples stand at its peaks, up "
            f"to {excitation.peak:.3g}, but {response.name} follows higher ones: gains come out some {strong_db:.1f} "
            "dB too strong; expected the signal as it was sent"
        )


def _cross_spectra(excitation: Recording, response: Recording, identified: Identified) -> NDArray[np.complex128]:
    """Return the cross spectra of excitation, its peaks, and response, shape (3, 3, bins), summed over segments."""
    from scipy.fft import rfft

    segment = round(identified.segment_s * excitation.rate_hz)
    lag = round(identified.measured.delay_s * excitation.rate_hz)
    shared = common(excitation, response, lag)
    window = np.hanning(segment + 1)[:-1]
    total = np.zeros((3, 3, segment // 2 + 1), dtype=np.complex128)
    for place in range(shared.start, shared.stop - segment + 1, segment // 2):
        sent = excitation.read(place, segment)
        peaks = np.where(excitation.stand_at_peak(sent), sent, 0.0)
        samples = np.stack([sent, peaks, response.read(place + lag, segment)])
        spectra = rfft(window * (samples - np.mean(samples, axis=1, keepdims=True)))
        total += np.conj(spectra)[:, None] * spectra[None, :]
    return total


def _lacking(cross: NDArray[np.complex128], identified: Identified, rate_hz: int) -> _Lacking:
    """Return what peaks lack: the least-squares G / H over the usable band, each bin by what it can tell."""
    frequencies_hz = np.fft.rfftfreq(2 * (cross.shape[2] - 1), 1.0 / rate_hz)
    low_hz, high_hz = identified.measured.band_hz
    cross = cross[..., (frequencies_hz >= low_hz) & (frequencies_hz <= high_hz)]
    sent = cross[0, 0].real
    # what the excitation does not explain of its peaks, of the response, and of both together
    peaks = cross[1, 1].real - np.abs(cross[0, 1]) ** 2 / sent
    response = cross[2, 2].real - np.abs(cross[0, 2]) ** 2 / sent
    both = cross[1, 2] - cross[1, 0] * cross[0, 2] / sent
    told = peaks > _LEAST_APART * cross[1, 1].real
    of_peaks = np.where(told, both / np.where(told, peaks, 1.0), 0.0)
    of_excitation = (cross[0, 2] - of_peaks * cross[0, 1]) / sent
    weights = np.where(told, peaks / np.maximum(response, 1e-12 * cross[2, 2].real), 0.0)
    known = float(np.sum(weights * np.abs(of_excitation) ** 2))
    if known == 0.0:
        return _Lacking(0.0, 0.0, 0.0)
    share = float(np.sum(weights * (of_peaks * np.conj(of_excitation)).real)) / known
    error = float(np.sqrt(RELATED / (2.0 * INDEPENDENT * identified.segments * known)))
    return _Lacking(share, error, float(np.sum(cross[0, 1].real) / np.sum(sent)))

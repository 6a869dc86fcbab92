"""By how much a response is late: the peak of its correlation with the excitation, to within the actuator's ringing.

What repeats itself has a peak every period, and all are equally true. But they do not come out equally high where less
of one recording lies beside the other, or silence does. So peaks are compared by the share of the power that they
explain:

    |sum x(n) y(n + lag)| / sqrt(sum x(n)^2  sum y(n + lag)^2),  over all n at which both were recorded
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Span
from ..ruleset import IdentifyRules
from .recording import Recording

Values = NDArray[np.float64]

_PIECES = 8

_ALIKE = 0.9
"""Peaks that reach this share of the highest may each be that of the delay."""

_LEAST_HEARD = 0.5
"""Where the sum itself is below this share of the highest, too little lies side by side: chance explains much of it."""


@dataclass(frozen=True)
class _Piece:
    """`frames` of the excitation from `start` on, and where the response begins that is tried beside them."""

    start: int
    frames: int
    heard_from: int


def coarse_delay(
    excitation: Recording, response: Recording, *, rules: IdentifyRules, within: Span | None = None, near: int = 0
) -> int:
    """Return by how many samples the response is late, to within the actuator's own ringing.

    At most eight pieces of the recordings are compared, or of the part `within` of the excitation; of peaks alike, as
    a periodic excitation has them, the one nearest to a delay of `near` is taken.
    """
    longest = round(rules.longest_delay_s * excitation.rate_hz)
    heard = within or Span(0, excitation.frames)
    frames = min(longest, len(heard))
    last = heard.stop - frames
    pieces = min(_PIECES, 1 + math.ceil((last - heard.start) / longest))
    starts = np.unique(np.linspace(heard.start, last, pieces).astype(np.int64))
    sums, power_in, power_out = (np.zeros(2 * longest + 1) for _ in range(3))
    for start in starts.tolist():
        piece = _Piece(start, frames, start + near - longest)
        for total, part in zip(
            (sums, power_in, power_out), _compared(excitation, response, piece, longest), strict=True
        ):
            total += part
    heights = np.abs(sums)
    explained = heights / np.sqrt(np.maximum(power_in * power_out, 1e-300))
    explained[heights < _LEAST_HEARD * np.max(heights)] = 0.0
    lags = np.arange(-longest, longest + 1)
    return near + int(lags[nearest_peak(explained, lags, reach=excitation.rate_hz // 100)])


def nearest_peak(heights: Values, lags: NDArray[np.int64], *, reach: int) -> int:
    """Return the index of the highest value within `reach` of the one nearest to no lag among those that are alike."""
    alike = np.flatnonzero(heights >= _ALIKE * np.max(heights))
    nearest = int(alike[np.argmin(np.abs(lags[alike]))])
    begin = max(0, nearest - reach)
    return begin + int(np.argmax(heights[begin : nearest + reach]))


def _compared(excitation: Recording, response: Recording, piece: _Piece, longest: int) -> tuple[Values, Values, Values]:
    """Return the sums of products of a piece and the response, and of their squares, for 2 `longest` + 1 lags."""
    from scipy.fft import irfft, rfft

    size = 4 * longest
    sent, came = excitation.read(piece.start, piece.frames), response.read(piece.heard_from, 3 * longest)
    spectrum_in, spectrum_out = rfft(sent, size), rfft(came, size)
    spectrum_in[0] = spectrum_out[0] = 0.0
    first = np.arange(2 * longest + 1)
    products = irfft(np.conj(spectrum_in) * spectrum_out, size)[first]
    begin = np.clip(-piece.heard_from - first, 0, piece.frames)
    end = np.clip(response.frames - piece.heard_from - first, 0, piece.frames)
    squares_in, squares_out = (np.concatenate([[0.0], np.cumsum(samples**2)]) for samples in (sent, came))
    return products, squares_in[end] - squares_in[begin], squares_out[first + piece.frames] - squares_out[first]

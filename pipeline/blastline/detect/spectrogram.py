"""Two log-spectrograms of a candidate: a fine one of 24 ms and a coarse one of half a second.

              onset
    near  ....|..................     24 frames 1 ms apart, of 4 ms each, 20 bands, from 5 ms before to 18 ms after
    wide  ........|.............      48 frames 10 ms apart, of 20 ms each, 32 bands, from 120 ms before to 350 after

Levels are in dB against the candidate's own attack, and each frame's mean is taken off: neither a film's gain nor a
constant changes anything.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..units import samples_from_ms
from .gather import gather

FLOOR = 1e-11
"""Power of a sine 110 dB under the loudest around: beneath the rounding of 16 bits where that is full scale."""

LOWEST_DB, HIGHEST_DB = -60.0, 30.0
_AT_ONCE = 100_000  # samples that are worked on together: with their spectra they stay in the cache
_DB_PER_LOG = np.float32(10.0 / np.log(10.0))
_FULL_SCALE, _SMALLEST = np.ones(1, np.float32), np.finfo(np.float32).tiny


@dataclass(frozen=True)
class SpectrogramLayout:
    """How a spectrogram is laid out: frames and bands, the first frame's start against the onset, all in ms and Hz.

    The first `before` frames are over before the onset. `transform_ms` is how long the transforms are, the window
    padded: a power of two at 48 kHz, a percent or so more where that is faster. It sets which frequencies they hear,
    and so must not depend on the rate.
    """

    frames: int
    before: int
    bands: int
    start_ms: float
    hop_ms: float
    window_ms: float
    transform_ms: float
    low_hz: float
    high_hz: float


NEAR = SpectrogramLayout(
    frames=24,
    before=4,
    bands=20,
    start_ms=-7.0,
    hop_ms=1.0,
    window_ms=4.0,
    transform_ms=256 / 48,
    low_hz=150.0,
    high_hz=18_000.0,
)
WIDE = SpectrogramLayout(
    frames=48,
    before=11,
    bands=32,
    start_ms=-130.0,
    hop_ms=10.0,
    window_ms=20.0,
    transform_ms=1024 / 48,
    low_hz=40.0,
    high_hz=17_000.0,
)

ATTACK = slice(6, 12)
"""The near frames that hear the attack."""


@dataclass(frozen=True, eq=False)
class Spectrograms:
    """The spectrograms of n candidates: `near` (n, frames, bands) and `wide`, in dB against the attack, float32."""

    near: NDArray[np.float32]
    wide: NDArray[np.float32]


def spectrograms(
    samples: NDArray[np.float32],
    onsets: NDArray[np.intp],
    rate_hz: int,
    loudest: NDArray[np.float32] = _FULL_SCALE,
    *,
    speed: float = 1.0,
) -> Spectrograms:
    """Return the spectrograms of candidates whose onsets are indices into `samples`; beyond its ends it is still.

    `loudest` is the largest peak around each, shape (n,) or (1,): what is silence in a film is so in a quieter copy.
    At another `speed` they are as if the film ran so many times as fast, its pitch with it.
    """
    floor = np.maximum(np.float32(FLOOR) * np.square(loudest), _SMALLEST)[:, None, None]
    near, wide = (
        _levels(samples, onsets, layout, rate_hz, floor) for layout in (_at_speed(NEAR, speed), _at_speed(WIDE, speed))
    )
    attack = near[:, ATTACK].mean(axis=2).max(axis=1, initial=-np.inf)[:, None, None]
    return Spectrograms(np.clip(near - attack, LOWEST_DB, HIGHEST_DB), np.clip(wide - attack, LOWEST_DB, HIGHEST_DB))


def _at_speed(layout: SpectrogramLayout, speed: float) -> SpectrogramLayout:
    """Return the layout that sees of a film what the given one would see of it at another speed."""
    return replace(
        layout,
        start_ms=layout.start_ms * speed,
        hop_ms=layout.hop_ms * speed,
        window_ms=layout.window_ms * speed,
        transform_ms=layout.transform_ms * speed,
        low_hz=layout.low_hz / speed,
        high_hz=layout.high_hz / speed,
    )


def _levels(
    samples: NDArray[np.float32],
    onsets: NDArray[np.intp],
    layout: SpectrogramLayout,
    rate_hz: int,
    floor: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Return the mean power of each band in each frame over a floor, in dB, shape (n, frames, bands)."""
    from scipy.fft import rfft

    window, filterbank = _window_and_filterbank(layout, rate_hz)
    mean_of = window / window.sum()
    starts = [samples_from_ms(layout.start_ms + layout.hop_ms * frame, rate_hz) for frame in range(layout.frames)]
    levels = np.empty((onsets.size, layout.frames, layout.bands), np.float32)
    at_once = max(1, _AT_ONCE // (layout.frames * window.size))
    for first in range(0, onsets.size, at_once):
        some = onsets[first : first + at_once]
        frames = gather(samples, (some[:, None] + np.array(starts)).ravel(), window.size)
        frames -= (frames @ mean_of)[:, None]
        frames *= window
        parts = rfft(frames, axis=1).view(np.float32)[:, : 2 * filterbank.shape[0]]
        np.square(parts, out=parts)
        power = parts[:, ::2] + parts[:, 1::2]
        levels[first : first + at_once] = (power @ filterbank).reshape(some.size, layout.frames, layout.bands)
    levels += floor
    return np.multiply(np.log(levels, out=levels), _DB_PER_LOG, out=levels)


@cache
def _window_and_filterbank(layout: SpectrogramLayout, rate_hz: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the window, and the bands' triangular weights on the bins, scaled so that a full-scale sine has power 1.

    The window is padded with zeros to the size of the transform: what is multiplied by them costs less than to pad each
    frame. Bands above what the rate can hold are silent.
    """
    count = samples_from_ms(layout.window_ms, rate_hz)
    size = _transform_size(layout, rate_hz)
    window = np.zeros(size)
    window[:count] = np.hanning(count + 2)[1:-1]
    # as if the transform were exactly as long as the layout's: so each band has the same bins at every rate
    hz = np.arange(size // 2 + 1) * 1000.0 / layout.transform_ms
    edges = np.geomspace(layout.low_hz, layout.high_hz, layout.bands + 2)
    rising = (hz[:, None] - edges[:-2]) / (edges[1:-1] - edges[:-2])
    falling = (edges[2:] - hz[:, None]) / (edges[2:] - edges[1:-1])
    weights = np.maximum(0.0, np.minimum(rising, falling))
    nearest = np.abs(hz[:, None] - edges[1:-1]).argmin(axis=0)
    between = weights.sum(axis=0) <= 0.0  # a band narrower than the bins takes the nearest one
    weights[nearest[between], np.flatnonzero(between)] = 1.0
    weights /= weights.sum(axis=0)
    weights[:, edges[1:-1] > 0.48 * rate_hz] = 0.0
    heard = 1 + int(np.flatnonzero(weights.any(axis=1))[-1])  # no band reaches beyond
    return (window * (2.0 / window.sum())).astype(np.float32), weights[:heard].astype(np.float32)


def _transform_size(layout: SpectrogramLayout, rate_hz: int) -> int:
    """Return the number of samples that is near to the layout's and fast to transform."""
    from scipy.fft import next_fast_len

    return int(next_fast_len(samples_from_ms(layout.transform_ms, rate_hz)))

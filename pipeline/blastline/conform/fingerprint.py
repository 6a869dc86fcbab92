"""What a film sounds like, a hundred times a second: small enough to hold, and the same in every copy of it.

    z(n, b) = clip( y(n, b) - mean of y over 1 s ) / spread of band b,    y = log(power of band b around frame n)

The logarithm without its local mean forgets level, equaliser and mastering; what is left is how each octave moves,
which survives codecs, other sample rates and a change of speed by some percent.
"""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Clip

FRAME_HZ = 100
WINDOW_S = 0.04
EDGES_HZ = (100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0, 6400.0)

_FLOOR = 1e-7
"""What lies 70 dB under a band's mean power is silence: codecs and dither differ there."""

_MEAN_S = 1.0
_CLIP = 4.0
_BATCH = 1024

Frames = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Fingerprint:
    """Frames, shape (frames, bands), centred on n / FRAME_HZ seconds; zero where the film is silent."""

    frames: Frames
    duration_s: float

    def __len__(self) -> int:
        """Return the number of frames."""
        return int(self.frames.shape[0])

    def at(self, times_s: NDArray[np.float64]) -> Frames:
        """Return the frames at any times by linear interpolation, zero outside the film."""
        place = times_s * FRAME_HZ
        inside = (place >= 0.0) & (place <= len(self) - 1)
        before = np.clip(np.floor(place), 0, max(0, len(self) - 2)).astype(np.intp)
        share = (place - before).astype(np.float32)[:, None]
        after = np.minimum(before + 1, len(self) - 1)
        mixed = (1.0 - share) * self.frames[before] + share * self.frames[after]
        return np.where(inside[:, None], mixed, np.float32(0.0))


def fingerprint(blocks: Iterable[Clip], rate_hz: int) -> Fingerprint:
    """Return the fingerprint of a film that comes as clips following each other; block size changes nothing."""
    powers: list[Frames] = []
    duration = 0
    half = round(WINDOW_S / 2.0 * rate_hz)
    start = -half  # of `held` in the film: the first frame is centred on the first sample
    held = np.zeros(half, np.float32)
    done = 0
    for clip in blocks:
        held = np.concatenate([held, np.asarray(clip.heard, np.float32)])
        duration = clip.span.stop
        done, held, start = _consume(held, start, done, rate_hz, powers)
    held = np.concatenate([held, np.zeros(2 * half, np.float32)])
    last = int(duration * FRAME_HZ / rate_hz)
    _consume(held, start, done, rate_hz, powers, last=last)
    power = np.concatenate(powers) if powers else np.zeros((0, len(EDGES_HZ) - 1), np.float32)
    return Fingerprint(_normalised(power), duration / rate_hz)


def _consume(
    held: NDArray[np.float32],
    start: int,
    done: int,
    rate_hz: int,
    powers: list[Frames],
    last: int | None = None,
) -> tuple[int, NDArray[np.float32], int]:
    """Append the powers of all frames that lie in what is held; return the next frame and what it still needs."""
    size = 2 * round(WINDOW_S / 2.0 * rate_hz)
    while True:
        numbers = np.arange(done, done + _BATCH if last is None else min(done + _BATCH, last + 1))
        first = (numbers * rate_hz + FRAME_HZ // 2) // FRAME_HZ - size // 2 - start
        first = first[first + size <= held.shape[0]]
        if not first.size:
            break
        powers.append(_band_powers(_windows(held, first, size), rate_hz))
        done += first.size
    gone = max(0, min(held.shape[0], (done * rate_hz + FRAME_HZ // 2) // FRAME_HZ - size // 2 - start))
    return done, held[gone:], start + gone


def _windows(held: NDArray[np.float32], first: NDArray[np.intp], size: int) -> NDArray[np.float32]:
    """Return the windows that start at some places, shape (windows, size); a view where they are evenly spaced."""
    hops = np.unique(np.diff(first))
    if hops.size > 1:
        return np.asarray(held[first[:, None] + np.arange(size)], np.float32)
    every = np.lib.stride_tricks.sliding_window_view(held, size)[first[0] :]
    return every[: (first.size - 1) * int(hops[0]) + 1 : int(hops[0])] if hops.size else every[:1]


def _band_powers(windows: NDArray[np.float32], rate_hz: int) -> Frames:
    from scipy import fft

    size = windows.shape[1]
    shape = np.hanning(size + 1)[:-1].astype(np.float32)
    spectra = fft.rfft(windows * shape, axis=1)
    power = spectra.real**2 + spectra.imag**2
    bins = np.minimum(np.round(np.array(EDGES_HZ) * size / rate_hz).astype(int), power.shape[1] - 1)
    sums = [power[:, low : max(high, low + 1)].sum(axis=1) for low, high in itertools.pairwise(bins)]
    return np.asarray(np.stack(sums, axis=1) / np.float32(size * size), np.float32)


def _normalised(power: Frames) -> Frames:
    """Return what of the powers does not depend on level."""
    if not power.any():
        return np.zeros_like(power)
    frames = np.empty_like(power)
    for band, values in enumerate(power.T):  # one at a time: a long film's sums are large
        level = np.log(values + _FLOOR * values.mean() + 1e-20).astype(np.float32)
        level -= _running_mean(level, round(_MEAN_S * FRAME_HZ))
        spread = np.sqrt(np.mean(level**2)) + np.float32(1e-6)
        frames[:, band] = np.clip(level / spread, -_CLIP, _CLIP)
    return frames


def _running_mean(values: NDArray[np.float32], size: int) -> NDArray[np.float32]:
    """Return the mean over each frame and `size // 2` to either side, fewer at the ends."""
    return np.asarray(summed_around(values, size) / summed_around(np.ones(len(values)), size), np.float32)


def summed_around(values: NDArray[np.floating], size: int) -> NDArray[np.float64]:
    """Return the sum over each value and `size // 2` to either side, what lies outside counting as nothing."""
    sums = np.concatenate([[0.0], np.cumsum(values, dtype=np.float64)])
    index = np.arange(len(values))
    low, high = np.maximum(index - size // 2, 0), np.minimum(index + size // 2 + 1, len(values))
    return np.asarray(sums[high] - sums[low], np.float64)

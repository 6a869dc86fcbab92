"""What the scan keeps of the film: peaks per millisecond step and band energies per two steps.

    samples   |-----|-----|-----|-----|      step = 1 ms, hop = 2 steps
    peak        p0    p1    p2    p3         half of max x - min x, of a step and the sample before it
    slope       d0    d1    d2    d3         largest |x[n] - x[n-1]| of a step
    bands      [    frame 1     ]            Hann-windowed energies of two hops: frame k ends with hop k

No track hears a constant: before its first sample a film rests at that sample's level, after its last at the last's.
Tracks advance in pieces of a fixed number of hops, counted from the film's first sample, so that the size of the
blocks that a reader delivers changes nothing.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..model import Clip

HOPS_PER_PIECE = 256  # half a second at most rates: arrays that stay in the cache
STEPS_PER_HOP = 2

# Two frequencies to a band, spread so that the band's share of a broadband burst is steady from shot to shot; the
# first band is the low-pass of the window itself. Hz.
BAND_FREQUENCIES_HZ = (
    (400.0, 700.0),
    (1000.0, 1400.0),
    (1900.0, 2500.0),
    (3300.0, 4200.0),
    (5400.0, 6800.0),
    (8500.0, 10500.0),
    (13000.0, 15500.0),
)
BANDS = 1 + len(BAND_FREQUENCIES_HZ)

# adds the squared cosine and sine parts of a band's two frequencies
_SUMS = np.zeros((1 + 4 * len(BAND_FREQUENCIES_HZ), BANDS), np.float32)
_SUMS[0, 0] = 1.0
for _band in range(1, BANDS):
    _SUMS[4 * _band - 3 : 4 * _band + 1, _band] = 1.0


@dataclass(frozen=True)
class Grid:
    """The scan's time grid at a sample rate, in samples."""

    rate_hz: int

    @property
    def step(self) -> int:
        """Return the length of a step, one millisecond."""
        return max(1, self.rate_hz // 1000)

    @property
    def hop(self) -> int:
        """Return the distance of band frames."""
        return STEPS_PER_HOP * self.step

    @property
    def piece(self) -> int:
        """Return the number of samples that the scan works on at a time."""
        return HOPS_PER_PIECE * self.hop

    def steps(self, duration_ms: float) -> int:
        """Return a duration in whole steps, at least one."""
        return max(1, round(duration_ms * self.rate_hz / 1000.0 / self.step))


@dataclass(frozen=True, eq=False)
class Piece:
    """One piece of the film with its tracks; `samples` beyond the film's end stay at the last one's level."""

    samples: NDArray[np.float32]
    peak: NDArray[np.float32]
    slope: NDArray[np.float32]
    bands: NDArray[np.float32]
    frames: int


def pieces(blocks: Iterable[Clip], rate_hz: int) -> Iterator[Piece]:
    """Cut the heard column of any blocks into pieces of one size and yield each with its tracks."""
    grid = Grid(rate_hz)
    before = np.zeros(0, np.float32)
    for samples in _rechunk(blocks, grid.piece):
        frames = samples.shape[0]
        padded = np.full(grid.piece, samples[-1], np.float32)
        padded[:frames] = samples
        before = before if before.size else np.full(2 * grid.hop, samples[0], np.float32)
        yield _track(padded, frames, before, grid)
        before = padded[-2 * grid.hop :]


def _track(samples: NDArray[np.float32], frames: int, before: NDArray[np.float32], grid: Grid) -> Piece:
    slope = np.empty_like(samples)
    np.subtract(samples[1:], samples[:-1], out=slope[1:])
    slope[0] = samples[0] - before[-1]
    steps = np.arange(0, samples.shape[0], grid.step)
    last = np.concatenate([before[-1:], samples[steps[1:] - 1]])
    highest = np.maximum(np.maximum.reduceat(samples, steps), last)
    lowest = np.minimum(np.minimum.reduceat(samples, steps), last)
    return Piece(
        samples=samples,
        peak=np.float32(0.5) * (highest - lowest),
        slope=np.maximum.reduceat(np.abs(slope, out=slope), steps),
        bands=_bands(samples, before, grid),
        frames=frames,
    )


def _bands(samples: NDArray[np.float32], before: NDArray[np.float32], grid: Grid) -> NDArray[np.float32]:
    """Return band energies, shape (hops, BANDS): a Hann-windowed DFT at a few frequencies as two matrix products.

    `before` holds two hops: one for the first frame, and one more for the frame that it is compared with.
    """
    early, late = _kernels(grid)
    hops = np.concatenate([before, samples]).reshape(-1, grid.hop)
    parts = hops[:-1] @ early + hops[1:] @ late
    # the low band is a slow level, its change from frame to frame is what sounds
    parts[1:, 0] = np.diff(parts[:, 0])
    parts = parts[1:]
    return np.square(parts, out=parts) @ _SUMS


@cache
def _kernels(grid: Grid) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the window times cosines and sines, for the earlier and the later hop of a frame.

    Scaled so that a full-scale sine gives energy 1 in its band. Frequencies a film's sample rate cannot hold give 0.
    What a constant would give is taken off, so that it gives 0 as well; but for the first, whose changes are heard.
    """
    length = 2 * grid.hop
    time = np.arange(length)
    window = np.sin(math.pi * (time + 0.5) / length) ** 2 * (2.0 / length)
    columns = [window]
    for frequency_hz in (f for pair in BAND_FREQUENCIES_HZ for f in pair):
        phase = 2.0 * math.pi * frequency_hz / grid.rate_hz * time
        held = 2.0 if frequency_hz < 0.48 * grid.rate_hz else 0.0
        columns += [held * window * np.cos(phase), held * window * np.sin(phase)]
    exact = np.stack(columns, axis=1)
    exact[:, 1:] -= window[:, None] * (exact[:, 1:].sum(axis=0) / window.sum())
    matrix = exact.astype(np.float32)
    return np.ascontiguousarray(matrix[: grid.hop]), np.ascontiguousarray(matrix[grid.hop :])


def _rechunk(blocks: Iterable[Clip], size: int) -> Iterator[NDArray[np.float32]]:
    """Yield arrays of exactly `size` samples, the last one shorter."""
    held: list[NDArray[np.float32]] = []
    have = 0
    for clip in blocks:
        samples = np.asarray(clip.heard, np.float32)
        while have + samples.shape[0] >= size:
            held.append(samples[: size - have])
            yield np.concatenate(held) if len(held) > 1 else held[0]
            samples = samples[size - have :]
            held, have = [], 0
        if samples.shape[0]:
            held.append(samples.copy())  # the reader may reuse its block
            have += samples.shape[0]
    if have:
        yield np.concatenate(held)

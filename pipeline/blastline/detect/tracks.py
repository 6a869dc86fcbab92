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
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..model import Clip

HOPS_PER_PIECE = 512  # a second at most rates: arrays that stay in the cache
STEPS_PER_HOP = 2
_AT_ONCE = 256  # steps turned over, or hops multiplied, at a time: twice as many take three times as long

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


def _band_pooling() -> NDArray[np.float32]:
    pooling = np.zeros((1 + 4 * len(BAND_FREQUENCIES_HZ), BANDS), np.float32)
    pooling[0, 0] = 1.0
    for band in range(1, BANDS):
        pooling[4 * band - 3 : 4 * band + 1, band] = 1.0
    pooling.setflags(write=False)
    return pooling


BAND_POOLING = _band_pooling()
"""Adds the squared cosine and sine parts of a band's two frequencies, shape (parts, BANDS)."""


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
    """One piece of the film with its tracks; `samples` beyond the film's end stay at the last one's level.

    `samples` has shape (Grid.piece,), of which the first `frames` are the film's; `peak` and `slope`, amplitudes, have
    shape (steps,), `bands`, energies, (hops, BANDS), or (0, BANDS) where nobody scans them.
    """

    samples: NDArray[np.float32]
    peak: NDArray[np.float32]
    slope: NDArray[np.float32]
    bands: NDArray[np.float32]
    frames: int


@dataclass(frozen=True, eq=False)
class PieceBefore:
    """What a piece needs of the one before: its last sample, the last hop's share in a frame, the last low band."""

    sample: np.float32
    early: NDArray[np.float32]
    low: np.float32

    @property
    def is_silent(self) -> bool:
        """Return whether nothing but zeros came before."""
        return not (self.sample or self.low or self.early.any())


def pieces(blocks: Iterable[Clip], rate_hz: int, *, with_bands: bool = True) -> Iterator[Piece]:
    """Cut the heard column of any blocks into pieces of one size and yield each with its tracks."""
    grid = Grid(rate_hz)
    before: PieceBefore | None = None
    bands = np.zeros((0, BANDS), np.float32)
    for samples, frames in _rechunk(blocks, grid.piece):
        before = before or _at_rest(samples[0], grid)
        if before.is_silent and not samples.any():
            yield _silent(samples, frames, with_bands=with_bands)
            continue
        peak, slope = _peaks(samples, before.sample, grid)
        if with_bands:
            bands, before = _bands(samples, before, grid)
        else:
            before = replace(before, sample=samples[-1])
        yield Piece(samples, peak, slope, bands, frames)


def _silent(samples: NDArray[np.float32], frames: int, *, with_bands: bool) -> Piece:
    """Return a piece of zeros, of which there is nothing to measure: two equal channels have such sides."""
    hops = HOPS_PER_PIECE if with_bands else 0
    still = np.zeros(HOPS_PER_PIECE * STEPS_PER_HOP, np.float32)
    return Piece(samples, still, still, np.zeros((hops, BANDS), np.float32), frames)


def _peaks(
    samples: NDArray[np.float32], before: np.float32, grid: Grid
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return half the range, and the largest difference, of each step and the sample before it, shape (steps,).

    Step beside step, so that the largest of each is found in long runs: three times as fast as step after step.
    """
    steps = np.empty((grid.step, samples.shape[0] // grid.step), np.float32)
    for some in _parts(steps.shape[1]):
        steps[:, some] = samples.reshape(-1, grid.step)[some].T
    last = np.concatenate([[before], steps[-1, :-1]])
    highest = np.maximum(steps.max(axis=0), last)
    lowest = np.minimum(steps.min(axis=0), last)
    slopes = np.empty_like(steps)
    np.subtract(steps[1:], steps[:-1], out=slopes[1:])
    np.subtract(steps[0], last, out=slopes[0])
    return np.float32(0.5) * (highest - lowest), np.abs(slopes, out=slopes).max(axis=0)


def _parts(count: int) -> Iterator[slice]:
    """Yield slices of so many steps or hops that are worked on together."""
    return (slice(first, first + _AT_ONCE) for first in range(0, count, _AT_ONCE))


def _at_rest(sample: np.float32, grid: Grid) -> PieceBefore:
    """Return what comes before a film's first sample: that sample's level for ever."""
    early, late = np.split(np.full(grid.hop, sample) @ kernels(grid), 2)
    return PieceBefore(sample, early, early[0] + late[0])


def _bands(samples: NDArray[np.float32], before: PieceBefore, grid: Grid) -> tuple[NDArray[np.float32], PieceBefore]:
    """Return band energies, shape (hops, BANDS): a Hann-windowed DFT at a few frequencies as a matrix product.

    And what the next piece needs of this one.
    """
    hops = samples.reshape(-1, grid.hop)
    products = np.empty((hops.shape[0], 2 * BAND_POOLING.shape[0]), np.float32)
    for some in _parts(hops.shape[0]):
        np.matmul(hops[some], kernels(grid), out=products[some])
    early, late = products[:, : BAND_POOLING.shape[0]], products[:, BAND_POOLING.shape[0] :]
    parts = np.empty(late.shape, np.float32)
    np.add(late[1:], early[:-1], out=parts[1:])
    np.add(late[0], before.early, out=parts[0])
    following = PieceBefore(samples[-1], early[-1].copy(), parts[-1, 0])
    # the low band is a slow level, its change from frame to frame is what sounds
    parts[1:, 0] = np.diff(parts[:, 0])
    parts[0, 0] -= before.low
    return np.square(parts, out=parts) @ BAND_POOLING, following


@cache
def kernels(grid: Grid) -> NDArray[np.float32]:
    """Return the window times cosines and sines for the earlier and the later hop of a frame, shape (hop, 2 * parts).

    Side by side, so that a hop is read once for both. Scaled so that a full-scale sine gives energy 1 in its band.
    Frequencies a film's sample rate cannot hold give 0. What a constant would give is taken off, so that it gives 0 as
    well; but for the first, whose changes are heard.
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
    return np.concatenate([matrix[: grid.hop], matrix[grid.hop :]], axis=1)


def _rechunk(blocks: Iterable[Clip], size: int) -> Iterator[tuple[NDArray[np.float32], int]]:
    """Yield arrays of `size` samples and how many of them are the film's: what its last one lacks, stays level."""
    room, have = np.empty(size, np.float32), 0
    for clip in blocks:
        heard, taken = clip.heard, 0
        while taken < heard.shape[0]:
            part = heard[taken : taken + size - have]
            room[have : have + part.shape[0]] = part
            taken, have = taken + part.shape[0], have + part.shape[0]
            if have == size:
                yield room, size
                room, have = np.empty(size, np.float32), 0
    if have:
        room[have:] = room[have - 1]
        yield room, have

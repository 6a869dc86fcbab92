"""The scan's tracks: what they say is what the samples say, wherever steps, hops and pieces begin."""

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect.tracks import Grid, Piece, PieceBefore, pieces
from blastline.model import Clip

RATE_HZ = 48_000
GRID = Grid(RATE_HZ)


def tracks_of(samples: NDArray[np.float32]) -> list[Piece]:
    return list(pieces([Clip(samples[:, None], RATE_HZ)], RATE_HZ))


def joined(samples: NDArray[np.float32], name: str) -> NDArray[np.float32]:
    """Return one of the tracks of a film, its pieces joined."""
    return np.concatenate([getattr(piece, name) for piece in tracks_of(samples)])


@pytest.mark.parametrize("at", [GRID.step, 257 * GRID.step, 256 * GRID.hop, GRID.piece, GRID.piece + 256 * GRID.step])
@pytest.mark.parametrize("edge", [1.0, -0.5])
def test_an_edge_of_one_sample_is_seen_in_the_step_that_it_begins(at: int, edge: float) -> None:
    """Nothing else of the step rises: the edge is the difference to the last sample of the step before."""
    samples = np.zeros(2 * GRID.piece, np.float32)
    samples[at:] = edge
    slope, peak = (joined(samples, name) for name in ("slope", "peak"))
    assert np.flatnonzero(slope).tolist() == np.flatnonzero(peak).tolist() == [at // GRID.step]
    assert slope[at // GRID.step] == abs(edge)
    assert peak[at // GRID.step] == 0.5 * abs(edge)


def test_each_step_has_the_largest_difference_and_half_the_range_of_its_samples_and_the_one_before() -> None:
    samples = np.random.default_rng(1).standard_normal(2 * GRID.piece).astype(np.float32)
    before = np.concatenate([samples[:1], samples])
    steps = np.lib.stride_tricks.sliding_window_view(before, GRID.step + 1)[:: GRID.step]
    np.testing.assert_array_equal(joined(samples, "slope"), np.abs(np.diff(steps, axis=1)).max(axis=1))
    np.testing.assert_allclose(joined(samples, "peak"), 0.5 * np.ptp(steps, axis=1), rtol=1e-6)


@pytest.mark.parametrize("frequency_hz", [25.0, 60.0])
@pytest.mark.parametrize("hops", [1, 100, 300])
def test_bands_are_the_same_wherever_pieces_are_cut(frequency_hz: float, hops: int) -> None:
    """A low thump at the border of two pieces sounds as it does inside of one."""
    time_s = np.arange(-GRID.piece, GRID.piece) / RATE_HZ
    thump = 0.5 * np.sin(2.0 * np.pi * frequency_hz * time_s + 1.0) * np.exp(-np.square(time_s / 0.03))
    faint = 1e-4 * np.random.default_rng(2).standard_normal(time_s.size)
    samples = (thump + faint).astype(np.float32)
    later = np.concatenate([np.full(hops * GRID.hop, samples[0]), samples])
    here, there = joined(samples, "bands"), joined(later, "bands")[hops:]
    assert here[GRID.piece // GRID.hop, 0] > 1e3 * here[:400, 0].max()
    np.testing.assert_allclose(np.sqrt(here), np.sqrt(there[: here.shape[0]]), rtol=1e-3, atol=1e-7)


@pytest.mark.parametrize("with_bands", [True, False])
def test_silence_that_is_not_measured_has_the_tracks_that_it_would_have(
    monkeypatch: pytest.MonkeyPatch, with_bands: bool
) -> None:
    """Sound that ends anywhere in a piece, some pieces of silence, sound again, and a short end."""
    samples = np.zeros(5 * GRID.piece + 777, np.float32)
    rng = np.random.default_rng(5)
    for start, stop in ((0, GRID.piece - 3), (3 * GRID.piece + 5, 4 * GRID.piece), (5 * GRID.piece + 10, samples.size)):
        samples[start:stop] = rng.standard_normal(stop - start)
    clip = Clip(samples[:, None], RATE_HZ)
    quick = list(pieces([clip], RATE_HZ, with_bands=with_bands))
    monkeypatch.setattr(PieceBefore, "is_silent", False)
    slow = list(pieces([clip], RATE_HZ, with_bands=with_bands))
    for one, other in zip(quick, slow, strict=True):
        assert one.frames == other.frames
        for name in ("samples", "peak", "slope", "bands"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))

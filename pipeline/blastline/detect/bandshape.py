"""How a candidate rises and decays in each band: mean levels of the band tracks around its onset."""

import numpy as np
from numpy.typing import NDArray

from .tracks import BANDS, Grid

# segments of the band tracks around the onset, in milliseconds
SEGMENTS_MS = (
    (-500, -200),
    (-200, -50),
    (-50, -12),
    (-12, -4),
    (-2, 4),
    (4, 8),
    (8, 16),
    (16, 32),
    (32, 64),
    (64, 128),
    (128, 256),
    (256, 500),
)
ATTACK = SEGMENTS_MS.index((-2, 4))
LOWEST_DB, HIGHEST_DB = -70.0, 30.0
_BLOCK = 16


def bandshape_names() -> tuple[str, ...]:
    """Return the names of the columns of `bandshape`, in order."""
    rows = [*(f"band{band}" for band in range(BANDS)), "total"]
    return tuple(f"{row}_{start}_{stop}_db" for row in rows for start, stop in SEGMENTS_MS)


def bandshape(levels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return band levels against the attack's total, shape (n, (BANDS + 1) * segments).

    So the gain of a film changes nothing; bounded, so that digital silence is a number.
    """
    relative = np.clip(levels - levels[:, -1:, ATTACK, None], LOWEST_DB, HIGHEST_DB)
    return relative.reshape(levels.shape[0], (BANDS + 1) * len(SEGMENTS_MS))


def band_levels(bands: NDArray[np.float32], onsets: NDArray[np.intp], grid: Grid) -> NDArray[np.float64]:
    """Return the mean level of each band, and of all together, in each segment: (n, BANDS + 1, segments), in dB."""
    sums = _running_sums(bands)
    frame = onsets[:, None] // grid.hop
    edges = np.array(SEGMENTS_MS, np.float64) * (grid.rate_hz / 1000.0 / grid.hop)
    starts = np.clip(frame + np.round(edges[:, 0]).astype(np.intp), 0, bands.shape[0])
    stops = np.clip(frame + np.round(edges[:, 1]).astype(np.intp), 0, bands.shape[0])
    energy = (sums[:, stops] - sums[:, starts]) / np.maximum(stops - starts, 1)
    energy = np.moveaxis(np.maximum(energy, 0.0), 0, 1)
    energy = np.concatenate([energy, energy.sum(axis=1, keepdims=True)], axis=1)
    energy += 1e-16
    return np.asarray(np.log(energy, out=energy) * (10.0 / np.log(10.0)), np.float64)


def _running_sums(bands: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the sum of all frames before each one, shape (BANDS, at least frames + 1).

    Within blocks by a matrix product, then from block to block: half the time of adding one frame after the other.
    """
    blocks = np.zeros((BANDS, bands.shape[0] // _BLOCK + 1, _BLOCK))
    blocks.reshape(BANDS, -1)[:, 1 : bands.shape[0] + 1] = bands.T
    blocks = blocks @ np.triu(np.ones((_BLOCK, _BLOCK)))
    blocks[:, 1:] += np.cumsum(blocks[:, :-1, -1], axis=1)[:, :, None]
    return blocks.reshape(BANDS, -1)

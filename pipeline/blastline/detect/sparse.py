"""Band energies where candidates are, for a tier that does not scan the bands.

    frames       | . . . . X . . . . . . . X x x x . . . . X . . .
    candidate                              ^                                 x  all frames near it
                                                                     X  one in eight stands for its neighbours

The attack of a candidate needs every frame; what is far from it counts as the mean of many, and fewer give the same.
"""

import numpy as np
from numpy.typing import NDArray

from .gather import gather
from .tracks import BAND_POOLING, BANDS, Grid, kernels

_BEFORE_MS, _AFTER_MS = 14.0, 34.0
_EVERY = 8
_AT_ONCE = 256


def bands_near(samples: NDArray[np.float32], places: NDArray[np.intp], grid: Grid) -> NDArray[np.float32]:
    """Return band energies of a chunk, shape (hops, BANDS), exact from 14 ms before to 34 after each place."""
    hops = samples.shape[0] // grid.hop
    ms_per_hop = 1000.0 * grid.hop / grid.rate_hz
    reach = np.arange(-round(_BEFORE_MS / ms_per_hop), round(_AFTER_MS / ms_per_hop))
    near = np.zeros(hops, bool)
    near[np.clip((places // grid.hop)[:, None] + reach, 0, hops - 1)] = True
    own = np.arange(hops)
    like = np.where(near, own, np.minimum(own // _EVERY * _EVERY + _EVERY // 2, hops - 1))
    asked = np.zeros(hops, bool)
    asked[like] = True
    energies = _energies(samples, np.flatnonzero(asked), grid)
    return energies.take(np.cumsum(asked)[like] - 1, axis=0)


def _energies(samples: NDArray[np.float32], frames: NDArray[np.intp], grid: Grid) -> NDArray[np.float32]:
    """Return the band energies of some frames, shape (n, BANDS), as the scan has them."""
    early, late = np.split(kernels(grid), 2, axis=1)
    still = np.zeros(grid.hop, np.float32)
    low = early[:, 0], late[:, 0]
    change = np.concatenate([still, *low]) - np.concatenate([*low, still])
    energies = np.empty((frames.size, BANDS), np.float32)
    for first in range(0, frames.size, _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        # a frame ends with its hop; the hop before it is for the change of the low band
        windows = gather(samples, (frames[some] - 2) * grid.hop, 3 * grid.hop)
        parts = windows[:, grid.hop : 2 * grid.hop] @ early
        parts += windows[:, 2 * grid.hop :] @ late
        parts[:, 0] = windows @ change
        energies[some] = np.square(parts, out=parts) @ BAND_POOLING
    return energies

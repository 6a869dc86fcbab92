"""What begins at once and goes on as loud: a cut to another scene, which no shot is.

▂▂▂▂▂▂▂▂█▇▅▄▃▂▂▂▂▂   a shot is over in a while, in some band at least, and automatic fire is so between its rounds
▂▂▂▂▂▂▂▂▇█▇▇▇█▇▇█▇   rain, surf, a street, from the first frame of a scene on
"""

import numpy as np
from numpy.typing import NDArray

from .tracks import Grid

_BEFORE_MS = (-50.0, -12.0)
_ATTACK_MS = (2.0, 20.0)
_GOES_ON_MS, _FRAME_MS = 1_000.0, 20.0
_RISEN_DB = 6.0  # a band that rises by less has little to lose
_SILENCE = 1e-16


def goes_on(
    bands: NDArray[np.float32], onsets: NDArray[np.intp], grid: Grid, least_fall_db: float
) -> NDArray[np.bool_]:
    """Return which of n onsets begin a sound that falls by less than that for a second, shape (n,).

    In each 20 ms, the bands that rise at the onset are held against what they have in its first 20 ms, in the mean of
    their levels. Without bands nothing is known to go on, nor where the film is over before.
    """
    if not bands.shape[0] or not onsets.size:
        return np.zeros(onsets.size, np.bool_)
    before, attack = (_levels_db(bands, onsets, grid, *span)[:, 0] for span in (_BEFORE_MS, _ATTACK_MS))
    risen = attack - before >= _RISEN_DB
    later = _levels_db(bands, onsets, grid, _ATTACK_MS[1], _GOES_ON_MS, _FRAME_MS)
    falls_db = np.where(risen[:, None], attack[:, None] - later, 0.0).sum(axis=2)
    return np.asarray(falls_db.max(axis=1) < least_fall_db * np.count_nonzero(risen, axis=1))


def _levels_db(
    bands: NDArray[np.float32],
    onsets: NDArray[np.intp],
    grid: Grid,
    start_ms: float,
    stop_ms: float,
    frame_ms: float | None = None,
) -> NDArray[np.float64]:
    """Return the mean level of each band in each frame, from one time after the onsets to another.

    Shape (n, frames, BANDS); before the film and after it is silence.
    """
    start, stop, frame = (
        round(ms * grid.rate_hz / 1000.0 / grid.hop) for ms in (start_ms, stop_ms, frame_ms or stop_ms - start_ms)
    )
    hops = onsets[:, None] // grid.hop + np.arange(start, stop - (stop - start) % frame)
    inside = (hops >= 0) & (hops < len(bands))
    energies = np.where(inside[..., None], bands[np.clip(hops, 0, len(bands) - 1)], 0.0)
    means = energies.reshape(onsets.size, -1, frame, bands.shape[1]).mean(axis=2)
    return np.asarray(10.0 * np.log10(means + _SILENCE), np.float64)

"""The last link of a scene: a limiter without memory, and the rounding to the file's bits."""

import numpy as np
from numpy.typing import NDArray

from ..units import gain_from_db
from .chance import generator
from .scene import Master
from .tone import Samples

_DITHER_CHUNK = 1 << 16


def limited(samples: Samples, master: Master) -> Samples:
    """Return the samples below the ceiling: unchanged up to the knee, bent by tanh above it.

    y = k + (c - k) tanh((|x| - k) / (c - k)) with the sign of x. Without memory, so that it moves nothing in time.
    """
    ceiling = gain_from_db(master.ceiling_dbfs)
    knee = gain_from_db(master.ceiling_dbfs - master.knee_db)
    size = np.abs(samples)
    if not np.any(size > knee):
        return samples
    bent = knee + (ceiling - knee) * np.tanh((size - knee) / (ceiling - knee))
    return np.where(size > knee, np.copysign(bent, samples), samples)


def quantised(samples: Samples, start: int, *, master: Master, seed: int) -> NDArray[np.int32]:
    """Return the samples as whole steps of the file's bits, left-justified in 32 bits, with triangular dither.

    The dither of a frame depends on its index alone, so blocks of any size give the same file.
    """
    scale = float(2 ** (master.bits - 1))
    steps = samples * scale
    if master.dither:
        steps = steps + _dither(start, len(samples), samples.shape[1], seed=seed)
    whole = np.clip(np.floor(steps + 0.5), -scale, scale - 1.0).astype(np.int32)
    return whole << (32 - master.bits)


def _dither(start: int, count: int, channels: int, *, seed: int) -> Samples:
    parts = []
    for chunk in range(start // _DITHER_CHUNK, (start + max(count, 1) - 1) // _DITHER_CHUNK + 1):
        rng = generator(seed, "dither", chunk)
        noise = rng.random((_DITHER_CHUNK, channels)) - rng.random((_DITHER_CHUNK, channels))
        first = chunk * _DITHER_CHUNK
        parts.append(noise[max(0, start - first) : start + count - first])
    return np.concatenate(parts)

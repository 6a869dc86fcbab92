"""Fades between two signals that are one and the same sound."""

import math

import numpy as np
from numpy.typing import NDArray


def fade(samples: int) -> NDArray[np.float64]:
    """Return the rising half of an equal-gain cross-fade, sin^2 at the middle of each of its samples, shape (samples,).

    Dry and compensated sound are one signal, so the weights of a fade, not their squares, sum to one:
    `fade(n) + fade(n)[::-1]` is 1, to the last bit or two.
    """
    phase = (np.arange(samples) + 0.5) / max(samples, 1) * (math.pi / 2.0)
    return np.asarray(np.sin(phase) ** 2, dtype=np.float64)


def cross_fade(dry: NDArray[np.float64], wet: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return `dry` where the weight is 0 and `wet` where it is 1, exactly, and a straight mix between.

    Written as dry + w (wet - dry), so that fading a signal into itself changes nothing.
    """
    mixed = dry + weights * (wet - dry)
    return np.where(weights == 1.0, wet, mixed)

"""Which channel carries what: dialogue in the centre, music left and right, ambience all around, shots anywhere."""

from dataclasses import dataclass

import numpy as np

from .beds import BedKind
from .chance import between
from .scene import Layout
from .tone import Samples

CHANNELS: dict[Layout, int] = {"mono": 1, "stereo": 2, "5.1": 6}
LFE = 3
"""Index of the low-frequency channel in 5.1: left, right, centre, LFE, left surround, right surround."""


@dataclass(frozen=True)
class Feed:
    """How strongly a channel carries a bed, and how much later in the bed it plays (another take, not a copy)."""

    channel: int
    gain: float
    later_s: float = 0.0


def bed_feeds(layout: Layout, kind: BedKind) -> tuple[Feed, ...]:
    """Return the channels that carry a bed."""
    around = kind in ("ambience", "wind", "rain", "crowd")
    if layout == "mono":
        return (Feed(0, 1.0),)
    if layout == "stereo":
        return (Feed(0, 1.0), Feed(1, 1.0, 7.3 if around else 0.0))
    if around:
        return (Feed(0, 1.0), Feed(1, 1.0, 7.3), Feed(4, 0.7, 13.1), Feed(5, 0.7, 19.7))
    if kind in ("music", "drums"):
        return (Feed(0, 1.0), Feed(1, 1.0, 0.011), Feed(4, 0.35, 0.023), Feed(5, 0.35, 0.031))
    return (Feed(2, 1.0),)


def sound_gains(rng: np.random.Generator, layout: Layout) -> Samples:
    """Return the gain of each channel for a sound somewhere in the picture; the mains' gains have a mean of 1."""
    if layout == "mono":
        return np.ones(1)
    side = between(rng, (-0.8, 0.8))
    if layout == "stereo":
        return np.array([1.0 - side, 1.0 + side])
    behind = between(rng, (0.0, 0.5))
    gains = np.array([max(0.0, -side), max(0.0, side), 1.0 - abs(side), 0.0, behind * 0.5, behind * 0.5])
    return np.asarray(gains * (5.0 / gains.sum()), dtype=np.float64)


def mains(samples: Samples) -> Samples:
    """Return the mean of the main channels, which is where levels are stated; the LFE is not one of them."""
    if samples.shape[1] == CHANNELS["5.1"]:
        samples = np.delete(samples, LFE, axis=1)
    return np.asarray(samples.mean(axis=1), dtype=np.float64)

"""Which channel carries what: dialogue in the centre, music left and right, ambience all around, shots anywhere."""

import math
from dataclasses import dataclass

import numpy as np

from .beds import BedKind
from .chance import between
from .scene import Layout
from .tone import Samples

CHANNELS: dict[Layout, int] = {"mono": 1, "stereo": 2, "5.1": 6, "7.1": 8}
LFE = 3
"""Index of the low-frequency channel in 5.1: left, right, centre, LFE, left surround, right surround.

In 7.1 these two are the back surrounds and left and right side surround follow.
"""

WITH_LFE = frozenset({6, 8})

LOUDSPEAKERS_DEG: dict[Layout, dict[int, float]] = {
    "mono": {0: 0.0},
    "stereo": {0: -30.0, 1: 30.0},
    "5.1": {0: -30.0, 1: 30.0, 2: 0.0, 4: -110.0, 5: 110.0},
    "7.1": {0: -30.0, 1: 30.0, 2: 0.0, 4: -135.0, 5: 135.0, 6: -90.0, 7: 90.0},
}
"""Where each channel's loudspeaker stands, 0 in front, positive to the right: ITU-R BS.775 and BS.2051."""


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
        feeds = (Feed(0, 1.0), Feed(1, 1.0, 7.3), Feed(4, 0.7, 13.1), Feed(5, 0.7, 19.7))
        return (*feeds, Feed(6, 0.7, 23.9), Feed(7, 0.7, 31.3)) if layout == "7.1" else feeds
    if kind in ("music", "drums"):
        feeds = (Feed(0, 1.0), Feed(1, 1.0, 0.011), Feed(4, 0.35, 0.023), Feed(5, 0.35, 0.031))
        return (*feeds, Feed(6, 0.35, 0.017), Feed(7, 0.35, 0.027)) if layout == "7.1" else feeds
    return (Feed(2, 1.0),)


def sound_gains(rng: np.random.Generator, layout: Layout, azimuth_deg: float | None) -> Samples:
    """Return the gain of each channel for a sound; the mains' gains have a mean of 1.

    Without an azimuth it is somewhere in the picture, and a little of it behind.
    """
    if layout == "mono":
        return np.ones(1)
    if azimuth_deg is not None:
        gains = _panned(layout, azimuth_deg)
        return np.asarray(gains * (len(LOUDSPEAKERS_DEG[layout]) / gains.sum()), dtype=np.float64)
    side = between(rng, (-0.8, 0.8))
    if layout == "stereo":
        return np.array([1.0 - side, 1.0 + side])
    behind = between(rng, (0.0, 0.5))
    gains = np.array([max(0.0, -side), max(0.0, side), 1.0 - abs(side), 0.0, behind * 0.5, behind * 0.5])
    if layout == "7.1":
        gains = np.concatenate([gains, gains[4:]])
    return np.asarray(gains * (len(LOUDSPEAKERS_DEG[layout]) / gains.sum()), dtype=np.float64)


def mains(samples: Samples) -> Samples:
    """Return the mean of the main channels, which is where levels are stated; the LFE is not one of them."""
    if samples.shape[1] in WITH_LFE:
        samples = np.delete(samples, LFE, axis=1)
    return np.asarray(samples.mean(axis=1), dtype=np.float64)


def _panned(layout: Layout, azimuth_deg: float) -> Samples:
    """Return gains of a sound between two loudspeakers, by the tangent law (Pulkki 1997); stereo has no back."""
    gains = np.zeros(CHANNELS[layout])
    around = sorted((deg, channel) for channel, deg in LOUDSPEAKERS_DEG[layout].items())
    if layout == "stereo":
        azimuth_deg = min(max(azimuth_deg, around[0][0]), around[-1][0])
    for (left_deg, left), (right_deg, right) in zip(around, around[1:] + around[:1], strict=True):
        apart = math.radians((right_deg - left_deg) % 360.0)
        inside = math.radians((azimuth_deg - left_deg) % 360.0)
        if inside <= apart:
            gains[left], gains[right] = math.sin(apart - inside), math.sin(inside)
            break
    return gains

"""A drive as what made it knew it: with an end, and ringing on after that, since what comes next was not known."""

import math
from dataclasses import dataclass

import numpy as np

from .. import dsp
from .comparison import Comparison, Samples
from .feeling import Felt
from .hearing import Heard

_FADED = 1e-3
"""A drive that is faded out by more than this is no longer told from the rounding of its file."""


@dataclass(frozen=True, eq=False)
class KnownDrive:
    """A drive that ends, what was wanted of it and what is felt of it; shape (frames,) each, over the span of `Heard`.

    A solver does not know what comes after: it expects its drive to ring on as the compensator's would within the
    limit, if it were felt no more strongly than what is wanted.
    """

    drive: Samples
    wanted: Samples
    vibration: Samples


def as_known(shared: Comparison, heard: Heard, felt: Felt, *, gain: float, since: int, stop: int) -> KnownDrive:
    """Return a drive as what made it knew it, which began at `since` and had an end at `stop`, samples of the span."""
    at = np.arange(len(heard.span))
    limit, early = shared.rules.peak, at < stop
    first_guess = np.where(early & (at >= since), gain * heard.wet, 0.0)
    rings = dsp.run_filter(shared.felt, np.clip(first_guess, -limit, limit))
    drive = np.where(early, np.where(heard.fading < 1.0, without_fade(shared, heard, felt), felt.drive), 0.0)
    vibration = felt.own - dsp.run_filter(shared.felt, felt.drive - drive)
    before = dsp.run_filter(shared.felt, np.where((at < since) & (heard.weights == 1.0), drive, 0.0))
    piece = slice(max(0, since), max(0, stop))
    asked, guessed = energy((gain * heard.intended - before)[piece]), energy(rings[piece])
    share = math.sqrt(asked / guessed) if asked < guessed else 1.0
    return KnownDrive(drive, np.where(early, gain * heard.intended, share * rings), vibration)


def own_drive(heard: Heard, felt: Felt) -> Samples:
    """Return the drive without the background that fades in over a window's end."""
    return felt.drive - (1.0 - heard.fading) * heard.background


def without_fade(shared: Comparison, heard: Heard, felt: Felt) -> Samples:
    """Return the drive as if its window's end did not fade it, within the limit."""
    limit = shared.rules.peak
    return np.clip(own_drive(heard, felt) / np.maximum(heard.fading, _FADED), -limit, limit)


def energy(samples: Samples) -> float:
    """Return the sum of the squares of samples."""
    return float(np.sum(samples**2))

"""What lies between a sound and the film's track: air, microphone, recorder, and the hand of the mixer."""

from dataclasses import dataclass

import numpy as np

from ..units import gain_from_db
from .chance import between, chance, log_between
from .tone import Samples, compress, highpass, lowpass, peak, saturate, tilt


@dataclass(frozen=True)
class Colour:
    """A recording chain; None for a link that is left out."""

    highpass_hz: float
    highpass_order: int
    tilts: tuple[tuple[float, float], ...] = ()
    bandwidth_hz: float | None = None
    drive_db: float | None = None
    squash: tuple[float, float, float] | None = None
    clip: float | None = None


CLEAN = Colour(highpass_hz=5.0, highpass_order=1)
"""A measuring microphone: nothing but the loss of the static pressure."""


def draw_colour(rng: np.random.Generator) -> Colour:
    """Return a chain anywhere between a measuring microphone and a telephone."""
    tilts = tuple((between(rng, (-9.0, 9.0)), log_between(rng, (150.0, 4_000.0))) for _ in range(rng.integers(0, 3)))
    squash = (between(rng, (-24.0, -3.0)), log_between(rng, (1.5, 20.0)), log_between(rng, (15.0, 500.0)))
    return Colour(
        highpass_hz=log_between(rng, (18.0, 120.0)) if chance(rng, 0.85) else log_between(rng, (120.0, 350.0)),
        highpass_order=int(rng.integers(1, 3)),
        tilts=tilts,
        bandwidth_hz=log_between(rng, (3_400.0, 18_000.0)) if chance(rng, 0.45) else None,
        drive_db=between(rng, (0.0, 18.0)) if chance(rng, 0.4) else None,
        squash=squash if chance(rng, 0.5) else None,
        clip=log_between(rng, (0.25, 0.95)) if chance(rng, 0.2) else None,
    )


def record(samples: Samples, colour: Colour, *, rate_hz: int) -> Samples:
    """Return the samples through the chain; levels inside it are against the sound's own peak, which stays."""
    top = peak(samples)
    if top == 0.0:
        return samples
    sound = highpass(samples / top, colour.highpass_hz, rate_hz=rate_hz, order=colour.highpass_order)
    for level_db, pivot_hz in colour.tilts:
        sound = tilt(sound, level_db, pivot_hz=pivot_hz, rate_hz=rate_hz)
    sound = sound / max(peak(sound), 1e-9)
    if colour.squash is not None:
        threshold_db, ratio, release_ms = colour.squash
        threshold = gain_from_db(threshold_db)
        sound = compress(sound, threshold=threshold, ratio=ratio, release_ms=release_ms, rate_hz=rate_hz)
    if colour.drive_db is not None:
        sound = saturate(sound / peak(sound), colour.drive_db)
    if colour.clip is not None:
        sound = np.clip(sound, -colour.clip * peak(sound), colour.clip * peak(sound))
    if colour.bandwidth_hz is not None:
        sound = lowpass(sound, colour.bandwidth_hz, rate_hz=rate_hz, order=4)
    return np.asarray(sound * (top / peak(sound)), dtype=np.float64)


def filtered(samples: Samples, colour: Colour, *, rate_hz: int) -> Samples:
    """Return the samples, shape (..., frames), through what is linear in the chain: what is left of each part of a sum.

    Dynamics weigh all parts that sound at one time alike.
    """
    sound = highpass(samples, colour.highpass_hz, rate_hz=rate_hz, order=colour.highpass_order)
    for level_db, pivot_hz in colour.tilts:
        sound = tilt(sound, level_db, pivot_hz=pivot_hz, rate_hz=rate_hz)
    if colour.bandwidth_hz is not None:
        sound = lowpass(sound, colour.bandwidth_hz, rate_hz=rate_hz, order=4)
    return sound


def air(samples: Samples, distance_m: float, *, rate_hz: int, muffle: float = 1.0) -> Samples:
    """Return the samples as they arrive through the air: two poles at 18 kHz near by, below 1 kHz from far away.

    The corner falls with the root of the distance, as absorption in dB grows with the distance and with the square
    of the frequency (ISO 9613-1). `muffle` below 1 lowers it further: a wall, a corner, cloth.
    """
    corner_hz = muffle * min(18_000.0, 18_000.0 * (8.0 / max(distance_m, 8.0)) ** 0.5)
    once = lowpass(samples, corner_hz, rate_hz=rate_hz)
    return lowpass(once, corner_hz, rate_hz=rate_hz)

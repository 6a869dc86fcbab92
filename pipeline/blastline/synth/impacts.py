"""Things that are struck: modes that ring and die, excited by a contact that takes its time.

    x(t) = sum over modes  a sin(2 pi f t) exp(-t / d)     convolved with the force of the contact, half a sine

A hard contact is short and excites every mode; a soft one is long and excites the low ones (van den Doel and
Pai 1998 call the same model modal synthesis).
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..units import gain_from_db
from .chance import between, fork, log_between
from .echoes import overlaid
from .tone import Samples
from .waves import band_burst, normalised

Material = Literal["wood", "metal", "sheet", "glass", "plastic", "stone", "earth", "membrane"]


@dataclass(frozen=True)
class Stuff:
    """The ranges of a material: lowest mode, spread of the modes, their number, and how long they ring.

    The decay falls with frequency as (f / lowest)^-`damping`. `noise_db` is the level of the contact's own noise.
    """

    lowest_hz: tuple[float, float]
    stretch: tuple[float, float]
    modes: tuple[int, int]
    decay_ms: tuple[float, float]
    damping: tuple[float, float]
    contact_ms: tuple[float, float]
    noise_db: tuple[float, float]


STUFF: dict[Material, Stuff] = {
    "wood": Stuff((70.0, 900.0), (1.2, 1.9), (5, 14), (8.0, 70.0), (0.3, 1.0), (0.2, 2.5), (-24.0, -4.0)),
    "metal": Stuff((200.0, 2_500.0), (1.1, 1.8), (8, 22), (60.0, 900.0), (0.1, 0.8), (0.03, 0.6), (-30.0, -6.0)),
    "sheet": Stuff((50.0, 300.0), (1.1, 1.35), (14, 30), (40.0, 500.0), (0.0, 0.5), (0.2, 3.0), (-24.0, -3.0)),
    "glass": Stuff((900.0, 3_500.0), (1.1, 1.6), (6, 16), (15.0, 250.0), (0.1, 0.7), (0.02, 0.3), (-20.0, -3.0)),
    "plastic": Stuff((150.0, 1_500.0), (1.2, 1.9), (4, 10), (4.0, 30.0), (0.3, 1.0), (0.2, 2.0), (-20.0, -2.0)),
    "stone": Stuff((300.0, 3_000.0), (1.2, 1.8), (5, 12), (3.0, 25.0), (0.2, 0.9), (0.05, 0.6), (-16.0, 0.0)),
    "earth": Stuff((35.0, 140.0), (1.3, 2.0), (3, 7), (10.0, 60.0), (0.6, 1.2), (2.0, 14.0), (-26.0, -8.0)),
    "membrane": Stuff((55.0, 260.0), (1.45, 1.6), (5, 9), (40.0, 400.0), (0.4, 1.0), (0.6, 4.0), (-24.0, -8.0)),
}
MATERIALS: tuple[Material, ...] = tuple(STUFF)


@dataclass(frozen=True, eq=False)
class Body:
    """A thing with its modes; it sounds a little different at every blow, for it is never struck at the same point."""

    frequencies_hz: Samples
    decays_s: Samples
    levels: Samples
    contact_ms: float
    noise_db: float
    noise_band_hz: tuple[float, float]
    noise_decay_ms: float


def draw_body(rng: np.random.Generator, material: Material) -> Body:
    """Return a random thing made of a material."""
    stuff = STUFF[material]
    count = int(rng.integers(stuff.modes[0], stuff.modes[1] + 1))
    lowest = log_between(rng, stuff.lowest_hz)
    stretch = between(rng, stuff.stretch)
    spread = (1.0 + np.arange(count)) ** stretch * np.exp(0.06 * rng.standard_normal(count))
    frequencies = lowest * spread
    decays = log_between(rng, stuff.decay_ms) * 1e-3 * (frequencies / lowest) ** -between(rng, stuff.damping)
    levels = np.exp(0.7 * rng.standard_normal(count)) * (1.0 + np.arange(count)) ** -between(rng, (0.0, 0.9))
    low = log_between(rng, (200.0, 2_500.0))
    return Body(
        frequencies_hz=np.asarray(frequencies, dtype=np.float64),
        decays_s=np.asarray(decays, dtype=np.float64),
        levels=np.asarray(levels, dtype=np.float64),
        contact_ms=log_between(rng, stuff.contact_ms),
        noise_db=between(rng, stuff.noise_db),
        noise_band_hz=(low, low * log_between(rng, (1.5, 8.0))),
        noise_decay_ms=log_between(rng, (0.5, 25.0)),
    )


def struck(rng: np.random.Generator, rate_hz: int, body: Body, *, hardness: float = 1.0) -> Samples:
    """Return one blow with a peak of 1; a `hardness` above 1 shortens the contact."""
    from scipy.signal import fftconvolve

    levels = body.levels * np.exp(0.25 * rng.standard_normal(len(body.levels)))
    ringing = modes(rate_hz, body.frequencies_hz, body.decays_s, levels)
    contact = max(1, round(body.contact_ms / hardness * between(rng, (0.85, 1.15)) * 1e-3 * rate_hz))
    force = np.sin((np.arange(contact) + 0.5) / contact * math.pi)
    ringing = normalised(np.asarray(fftconvolve(ringing, force), dtype=np.float64))
    noise = band_burst(
        fork(rng), rate_hz, band_hz=body.noise_band_hz, attack_ms=0.5 * body.contact_ms, decay_ms=body.noise_decay_ms
    )
    return normalised(overlaid([(0, ringing), (0, noise * gain_from_db(body.noise_db))]))


def modes(rate_hz: int, frequencies_hz: Samples, decays_s: Samples, levels: Samples) -> Samples:
    """Return the sum of the modes until the last has died to -60 dB, three seconds at most; none above 0.45 rate."""
    count = math.ceil(min(3.0, 6.9 * float(np.max(decays_s))) * rate_hz)
    total = np.zeros(count)
    for frequency, decay, level in zip(frequencies_hz, decays_s, levels, strict=True):
        if frequency < 0.45 * rate_hz:
            times = np.arange(min(count, math.ceil(6.9 * decay * rate_hz))) / rate_hz
            total[: len(times)] += level * np.sin(2.0 * math.pi * frequency * times) * np.exp(-times / decay)
    return total


def series(
    rng: np.random.Generator, blows: list[Samples], *, gaps_s: Samples, levels_db: float, rate_hz: int
) -> Samples:
    """Return blows in turn, one after each gap, with levels that vary by `levels_db`, and a peak of 1."""
    parts = []
    at_s = 0.0
    for number, gap_s in enumerate([0.0, *gaps_s.tolist()]):
        at_s += gap_s
        blow = blows[number % len(blows)]
        parts.append((round(at_s * rate_hz), blow * gain_from_db(-abs(levels_db * rng.standard_normal()))))
    return normalised(overlaid(parts))

"""Household and workshop: doors, hammers, things that fall and break."""

import math

import numpy as np

from .chance import between, chance, fork, log_between, pick
from .echoes import overlaid
from .impacts import MATERIALS, Body, Material, draw_body, series, struck
from .tone import Samples, bandpass
from .waves import band_burst, noise_burst, normalised


def door(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a slam: the panel's thud, the frame, the latch a few milliseconds off, perhaps a rattle after it."""
    panel = struck(fork(rng), rate_hz, draw_body(rng, pick(rng, ("wood", "sheet", "earth"))))
    frame = struck(fork(rng), rate_hz, draw_body(rng, "wood"))
    latch = struck(fork(rng), rate_hz, draw_body(rng, "metal"), hardness=2.0)
    parts = [
        (0, panel),
        (_samples(rng, rate_hz, (0.0, 0.02)), frame * between(rng, (0.1, 0.9))),
        (_samples(rng, rate_hz, (0.0, 0.06)), latch * between(rng, (0.05, 0.6))),
    ]
    if chance(rng, 0.4):
        rattle = _bouncing(rng, rate_hz, draw_body(rng, pick(rng, ("metal", "wood", "glass"))), first_s=0.07)
        parts.append((_samples(rng, rate_hz, (0.02, 0.12)), rattle * between(rng, (0.05, 0.3))))
    return normalised(overlaid(parts))


def hammer(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return one blow of steel on a nail, a plank, a wall or an anvil: two bodies that ring together."""
    tool = struck(fork(rng), rate_hz, draw_body(rng, "metal"), hardness=between(rng, (1.0, 3.0)))
    work = struck(fork(rng), rate_hz, draw_body(rng, pick(rng, ("wood", "metal", "stone", "sheet"))))
    return normalised(overlaid([(0, tool * log_between(rng, (0.1, 1.0))), (0, work)]))


def hammering(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return 3-12 blows of one hammer, 0.25-0.9 s apart."""
    return _repeated(rng, rate_hz, (3, 12), (0.25, 0.9), 0.06, pick(rng, ("wood", "metal", "stone", "sheet")))


def knock(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return 1-5 knocks on wood, 0.12-0.4 s apart."""
    return _repeated(rng, rate_hz, (1, 5), (0.12, 0.4), 0.08, "wood")


def metal(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a blow on a pipe, a plate or a barrel."""
    return struck(fork(rng), rate_hz, draw_body(rng, pick(rng, ("metal", "sheet"))), hardness=between(rng, (0.5, 2.0)))


def drop(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a thing that falls and bounces, sooner and weaker each time."""
    return _bouncing(rng, rate_hz, draw_body(rng, pick(rng, MATERIALS)), first_s=log_between(rng, (0.04, 0.5)))


def glass(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a pane or a bottle that breaks: a crack, then shards that fall over half a second."""
    crack = band_burst(
        fork(rng), rate_hz, band_hz=(1_500.0, 14_000.0), attack_ms=0.1, decay_ms=log_between(rng, (2.0, 25.0))
    )
    parts = [(0, crack * between(rng, (0.3, 1.0))), (0, struck(fork(rng), rate_hz, draw_body(rng, "glass")))]
    shards = [struck(fork(rng), rate_hz, draw_body(rng, "glass"), hardness=2.0) for _ in range(8)]
    spread_s = log_between(rng, (0.1, 0.6))
    for _ in range(int(rng.integers(8, 60))):
        at_s = between(rng, (0.0, 0.03)) + spread_s * rng.exponential()
        parts.append((round(min(at_s, 3.0) * rate_hz), pick(rng, shards) * log_between(rng, (0.02, 0.6))))
    return normalised(overlaid(parts))


def weapon_handling(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a weapon or a tool that is cocked, loaded or put down: clicks and slides, no shot."""
    parts = []
    at_s = 0.0
    for _ in range(int(rng.integers(2, 6))):
        click = struck(fork(rng), rate_hz, draw_body(rng, pick(rng, ("metal", "plastic"))), hardness=2.0)
        parts.append((round(at_s * rate_hz), click[: round(0.2 * rate_hz)] * log_between(rng, (0.2, 1.0))))
        if chance(rng, 0.5):
            slide = noise_burst(fork(rng), rate_hz, attack_ms=between(rng, (10.0, 80.0)), decay_ms=20.0)
            low = log_between(rng, (800.0, 3_000.0))
            slide = normalised(bandpass(slide, low, 3.0 * low, rate_hz=rate_hz))
            parts.append((round(at_s * rate_hz), slide * between(rng, (0.05, 0.3))))
        at_s += log_between(rng, (0.02, 0.35))
    return normalised(overlaid(parts))


def snap(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a branch or a stick that breaks: 2-8 cracks within a tenth of a second."""
    body = draw_body(rng, "wood")
    cracks = [struck(fork(rng), rate_hz, body, hardness=4.0)[: round(0.05 * rate_hz)] for _ in range(4)]
    return series(rng, cracks, gaps_s=paced(rng, (1, 7), (0.002, 0.03), 0.5), levels_db=6.0, rate_hz=rate_hz)


def _repeated(
    rng: np.random.Generator,
    rate_hz: int,
    count: tuple[int, int],
    gap_s: tuple[float, float],
    jitter: float,
    material: Material,
) -> Samples:
    body = draw_body(rng, material)
    blows = [struck(fork(rng), rate_hz, body) for _ in range(4)]
    gaps = paced(rng, (count[0] - 1, count[1] - 1), gap_s, jitter)
    return series(rng, blows, gaps_s=gaps, levels_db=1.5, rate_hz=rate_hz)


def _bouncing(rng: np.random.Generator, rate_hz: int, body: Body, *, first_s: float) -> Samples:
    """Return bounces: each gap and each speed is a fixed part of the one before (the coefficient of restitution)."""
    restitution = between(rng, (0.3, 0.8))
    count = int(min(14, math.log(0.01 / first_s) / math.log(restitution))) if first_s > 0.01 else 1
    parts = []
    at_s = 0.0
    for number in range(max(count, 1) + 1):
        blow = struck(fork(rng), rate_hz, body, hardness=restitution ** (0.2 * number))
        parts.append((round(at_s * rate_hz), blow * restitution**number))
        at_s += first_s * restitution**number * between(rng, (0.85, 1.15))
    return normalised(overlaid(parts))


def paced(rng: np.random.Generator, count: tuple[int, int], gap_s: tuple[float, float], jitter: float) -> Samples:
    """Return the gaps of a row, in seconds: a random number of them about one length, each off by a random factor."""
    number = int(rng.integers(count[0], count[1] + 1))
    steady = log_between(rng, gap_s)
    return np.asarray(steady * np.exp(jitter * rng.standard_normal(number)), dtype=np.float64)


def _samples(rng: np.random.Generator, rate_hz: int, seconds: tuple[float, float]) -> int:
    return round(between(rng, seconds) * rate_hz)

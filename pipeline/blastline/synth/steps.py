"""What walks: steps of shoes, boots and bare feet on any floor, and hooves.

A foot that comes down is a low, soft blow without highs: the ground gives way, so it rises within milliseconds and is
gone in some tens of them. What is hard or loose in it comes on top: a heel that rings, a sole that slaps, grit.
"""

from collections.abc import Callable

import numpy as np

from .chance import between, chance, fork, log_between, pick
from .echoes import overlaid
from .impacts import draw_body, series, struck
from .knocks import paced
from .tone import Samples, lowpass
from .waves import band_burst, boom, noise_burst, normalised

_Foot = Callable[[np.random.Generator], Samples]
"""Makes one footfall after another of the same foot on the same floor."""


def footsteps(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return 1-8 steps, walking or running, on a floor that rings or one that gives way."""
    foot = pick(rng, (_on_a_floor_that_rings, _on_a_floor_that_gives_way))(rng, rate_hz)
    steps = [foot(fork(rng)) for _ in range(4)]
    return series(rng, steps, gaps_s=paced(rng, (0, 7), (0.25, 0.9), 0.05), levels_db=2.0, rate_hz=rate_hz)


def soft_step(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return one step, stomp or landing on a floor that gives way."""
    return _on_a_floor_that_gives_way(rng, rate_hz)(fork(rng))


def _on_a_floor_that_rings(rng: np.random.Generator, rate_hz: int) -> _Foot:
    """Return a heel that strikes boards, stone, earth or sheet, and a toe that scuffs after it."""
    ground = draw_body(rng, pick(rng, ("wood", "stone", "earth", "sheet")))
    scuff_hz = (log_between(rng, (200.0, 900.0)), log_between(rng, (1_500.0, 6_000.0)))

    def step(rng: np.random.Generator) -> Samples:
        heel = struck(fork(rng), rate_hz, ground, hardness=between(rng, (0.3, 1.2)))
        toe = band_burst(fork(rng), rate_hz, band_hz=scuff_hz, attack_ms=4.0, decay_ms=between(rng, (8.0, 40.0)))
        late = round(between(rng, (0.02, 0.12)) * rate_hz)
        return overlaid([(0, heel), (late, toe * between(rng, (0.05, 0.4)))])

    return step


def _on_a_floor_that_gives_way(rng: np.random.Generator, rate_hz: int) -> _Foot:
    """Return a weight that comes down softly, with a sole, a toe, a hollow floor and grit, or some of these."""
    corner_hz, order = log_between(rng, (150.0, 2_000.0)), pick(rng, (1, 2, 2))
    attack_ms, decay_ms = log_between(rng, (2.0, 14.0)), log_between(rng, (6.0, 60.0))
    sole_hz = (log_between(rng, (250.0, 1_000.0)), log_between(rng, (2_000.0, 6_000.0)))
    sole_ms, sole = log_between(rng, (3.0, 15.0)), chance(rng, 0.6) * log_between(rng, (0.05, 0.5))
    hollow_hz, hollow = log_between(rng, (40.0, 130.0)), chance(rng, 0.4) * log_between(rng, (0.1, 1.0))
    toe, toe_s = chance(rng, 0.5) * between(rng, (0.2, 0.9)), log_between(rng, (0.025, 0.15))
    grit = chance(rng, 0.3) * log_between(rng, (0.02, 0.3))

    def weight(rng: np.random.Generator, hardness: float) -> Samples:
        noise = noise_burst(fork(rng), rate_hz, attack_ms=attack_ms / hardness, decay_ms=decay_ms * hardness)
        return normalised(lowpass(noise, corner_hz * hardness, rate_hz=rate_hz, order=order))

    def step(rng: np.random.Generator) -> Samples:
        slap = band_burst(fork(rng), rate_hz, band_hz=sole_hz, attack_ms=between(rng, (0.0, 2.0)), decay_ms=sole_ms)
        floor = boom(rate_hz, start_hz=1.3 * hollow_hz, stop_hz=hollow_hz, attack_ms=attack_ms, decay_ms=2.0 * decay_ms)
        parts = [(0, weight(rng, between(rng, (0.8, 1.25)))), (0, slap * sole), (0, floor * hollow)]
        parts.append((round(toe_s * between(rng, (0.8, 1.25)) * rate_hz), weight(rng, 1.2) * toe))
        for _ in range(int(rng.integers(4, 30)) if grit else 0):
            grain = noise_burst(fork(rng), rate_hz, attack_ms=0.1, decay_ms=log_between(rng, (0.3, 3.0)))
            parts.append((round(0.06 * rng.random() * rate_hz), grain * grit * log_between(rng, (0.1, 1.0))))
        return normalised(overlaid(parts))

    return step


def hooves(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a horse that walks, trots or gallops: two to four beats a stride, on earth, stone or wood."""
    ground = draw_body(rng, pick(rng, ("earth", "stone", "wood")))
    stride_s, beats = pick(rng, ((1.1, (0.0, 0.25, 0.5, 0.75)), (0.65, (0.0, 0.5)), (0.48, (0.0, 0.2, 0.4))))
    scrape = (log_between(rng, (150.0, 900.0)), log_between(rng, (1_500.0, 6_000.0)))
    falls = []
    for _ in range(4):
        blow = struck(fork(rng), rate_hz, ground, hardness=between(rng, (0.5, 2.0)))
        dirt = band_burst(fork(rng), rate_hz, band_hz=scrape, attack_ms=2.0, decay_ms=between(rng, (5.0, 40.0)))
        falls.append(overlaid([(0, blow), (0, dirt * between(rng, (0.05, 0.6)))]))
    strides = int(rng.integers(1, 7))
    at_s = np.concatenate([stride_s * (number + np.array(beats)) for number in range(strides)])
    gaps = np.diff(at_s) * np.exp(0.06 * rng.standard_normal(len(at_s) - 1))
    return series(rng, falls, gaps_s=gaps, levels_db=2.5, rate_hz=rate_hz)

"""A bed of any length from half a minute of material: looped, each time from another place, cross-faded.

    material  [~~~~~~~~~~~~~~~~]   closed into a ring: its end fades into its start
    bed       [ from a  x from b  x from c  ...     x = equal-power cross-fade

A sample of the bed depends on its index alone, so the bed can be read anywhere, in blocks of any size.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .beds import BedKind, random_bed
from .chance import generator
from .tone import Samples

MATERIAL_S = 30.0
SHORTEST_S = 3.0
CROSS_FADE_S = 1.5


@dataclass(frozen=True, eq=False)
class BedLoop:
    """A ring of material and the length of the pieces that are played from it."""

    ring: NDArray[np.float32]
    piece: int
    cross_fade: int
    seed: int

    def read(self, start: int, stop: int) -> Samples:
        """Return the bed's samples from `start` to `stop`, counted from its first one."""
        total = np.zeros(stop - start)
        for number in range(max(0, (start - self.cross_fade) // self.piece), max(0, stop - 1) // self.piece + 1):
            first = number * self.piece
            low, high = max(start, first), min(stop, first + self.piece + self.cross_fade)
            if low < high:
                inside = np.arange(low - first, high - first)
                offset = 0 if number == 0 else int(generator(self.seed, "offset", number).integers(len(self.ring)))
                played = self.ring[(inside + offset) % len(self.ring)].astype(np.float64)
                total[low - start : high - start] += played * self._weights(inside, number)
        return total

    def _weights(self, inside: NDArray[np.int64], number: int) -> Samples:
        weights = np.ones(len(inside))
        rising, falling = inside < (self.cross_fade if number else 0), inside >= self.piece
        weights[rising] = np.sin((inside[rising] + 0.5) / self.cross_fade * (math.pi / 2.0))
        weights[falling] = np.cos((inside[falling] - self.piece + 0.5) / self.cross_fade * (math.pi / 2.0))
        return weights


def bed_loop(seed: int, kind: BedKind, *, duration_s: float, rate_hz: int) -> BedLoop:
    """Return the bed of its kind under a seed: with as much material as it is long, up to `MATERIAL_S`."""
    cross_fade = round(CROSS_FADE_S * rate_hz)
    seconds = min(max(duration_s, SHORTEST_S), MATERIAL_S) + CROSS_FADE_S
    material = random_bed(generator(seed, "material"), rate_hz, seconds, kind)
    ring, ending = material[: len(material) - cross_fade].copy(), material[len(material) - cross_fade :]
    fade = np.sin((np.arange(cross_fade) + 0.5) / cross_fade * (math.pi / 2.0))
    ring[:cross_fade] = ring[:cross_fade] * fade + ending * fade[::-1]
    return BedLoop(ring.astype(np.float32), len(ring), cross_fade, seed)

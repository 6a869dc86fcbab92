"""Echoes by geometry: every wall is a mirror, and behind it stands an image of the source.

    source *--------------------> listener      direct, path d
            \\__ wall or ground __/              image source, path p: delay (p - d) / c, gain d / p * R^hits

The image-source method of Allen and Berkley (1979), for a box, for two walls, or for the ground alone.
"""

import itertools
import math
from dataclasses import dataclass

from ..units import gain_from_db

SPEED_OF_SOUND_M_S = 343.0
"""At 20 degrees Celsius."""

FAINTEST_ECHO = gain_from_db(-40.0)
MOST_ECHOES = 60


@dataclass(frozen=True)
class Echo:
    """A reflection against the direct sound: later by `delay_s`, `gain` times as strong, darker above `corner_hz`."""

    delay_s: float
    gain: float
    corner_hz: float
    smear_ms: float = 0.0


@dataclass(frozen=True)
class Axis:
    """One axis of a box: its size (None for no far wall), source and listener on it, and the walls' reflection."""

    size_m: float | None
    source_m: float
    listener_m: float
    reflection: float

    def images(self, order: int) -> list[tuple[float, int]]:
        """Return the distance along the axis to each image of the source, and how often it was reflected."""
        if self.size_m is None:
            places = [(self.source_m, 0)] + ([(-self.source_m, 1)] if self.reflection > 0.0 else [])
        else:
            shifts = range(-order, order + 1)
            places = [(2 * m * self.size_m + self.source_m, abs(2 * m)) for m in shifts]
            places += [(2 * m * self.size_m - self.source_m, abs(2 * m - 1)) for m in shifts]
        return [(place - self.listener_m, hits) for place, hits in places]


def image_echoes(axes: tuple[Axis, Axis, Axis], *, order: int, corner_hz: float) -> tuple[float, tuple[Echo, ...]]:
    """Return the direct path in metres and the echoes of a box's image sources, strongest kept, by time.

    Every reflection lowers the corner: a wall absorbs more of the treble.
    """
    direct = math.dist([axis.source_m for axis in axes], [axis.listener_m for axis in axes])
    echoes = []
    for images in itertools.product(*(axis.images(order) for axis in axes)):
        path = math.hypot(*(along for along, _ in images))
        hits = sum(count for _, count in images)
        loss = math.prod(axis.reflection**count for axis, (_, count) in zip(axes, images, strict=True))
        gain = direct / path * loss
        if hits > 0 and gain > FAINTEST_ECHO:
            echoes.append(Echo((path - direct) / SPEED_OF_SOUND_M_S, gain, corner_hz / hits))
    strongest = sorted(echoes, key=lambda echo: -echo.gain)[:MOST_ECHOES]
    return direct, tuple(sorted(strongest, key=lambda echo: echo.delay_s))

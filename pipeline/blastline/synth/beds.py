"""The beds that lie under everything: dialogue, music, drums, ambience, wind, rain, crowds and engines."""

from collections.abc import Callable
from typing import Literal

import numpy as np

from .chance import pick
from .music import drum_music, music
from .noises import ambience, engine, rain, wind
from .speech import crowd, dialogue
from .tone import Samples

BedKind = Literal["dialogue", "music", "drums", "ambience", "wind", "rain", "crowd", "engine"]

_MAKERS: dict[BedKind, Callable[[np.random.Generator, int, float], Samples]] = {
    "dialogue": dialogue,
    "music": music,
    "drums": drum_music,
    "ambience": ambience,
    "wind": wind,
    "rain": rain,
    "crowd": crowd,
    "engine": engine,
}

BED_KINDS: tuple[BedKind, ...] = tuple(_MAKERS)


def random_bed(rng: np.random.Generator, rate_hz: int, seconds: float, kind: BedKind | None = None) -> Samples:
    """Return a bed of the given kind, or of any, with an rms of 1 over its whole length."""
    return _MAKERS[pick(rng, BED_KINDS) if kind is None else kind](rng, rate_hz, seconds)

"""How a lesson is finished: perhaps through a lossy codec or cut inside a shot; what is drowned counts neither way."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..synth import stands_out_db
from .codecs import BITS_PER_S, coded
from .mixes import RATE_HZ, Mix

CODED_SHARE, CUT_SHARE = 0.3, 0.2
DROWNED_DB = 3.0
"""A shot that stands out by less teaches nothing: it counts neither way."""


def perhaps_coded(samples: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the samples, or in three of ten lessons what a lossy codec leaves of them."""
    if rng.random() >= CODED_SHARE:
        return samples
    codec = list(BITS_PER_S)[int(rng.integers(len(BITS_PER_S)))]
    return coded(samples, codec, bits_per_s=int(rng.choice(BITS_PER_S[codec])), rate_hz=RATE_HZ)


def perhaps_cut(film: Mix, rng: np.random.Generator) -> Mix:
    """Return the film, or in one lesson of five the film until up to 0.4 s after one of its last shots' onsets."""
    if not film.onsets.size or rng.random() >= CUT_SHARE:
        return film
    last = film.onsets[int(rng.integers(3 * film.onsets.size // 4, film.onsets.size))]
    stop = int(last) + int(rng.uniform(0.002, 0.4) * RATE_HZ)
    heard = film.onsets < stop
    return Mix(film.samples[:stop], film.onsets[heard], film.level_db[heard], film.unsure[film.unsure < stop])


def without_drowned(film: Mix, places: Sequence[Iterable[int]]) -> Mix:
    """Return a mix in which a shot that hardly stands out of what is before it counts neither way.

    `places` are, for each shot, where it may be heard first: its onset, a bullet's shock, a bolt.
    """
    margins_db = [max(stands_out_db(film.samples, at, rate_hz=RATE_HZ) for at in each if at >= 0) for each in places]
    heard = np.array(margins_db, np.float64) >= DROWNED_DB
    unsure = np.concatenate([film.unsure, film.onsets[~heard]])
    return replace(film, onsets=film.onsets[heard], level_db=film.level_db[heard], unsure=unsure)

"""Data augmentation: a training film at another speed and tilt, over another one, overdriven, or cut at its start.

A film takes seconds to make and a network hears it many times: what it learns by heart is worth nothing on others.
All changes are the same for shots and for everything else.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..synth.tone import peak, rms, saturate, tilt
from ..units import gain_from_db
from .finishing import without_drowned
from .mixes import RATE_HZ, Mix, Samples, Sound, as_16_bit
from .variants import SPEEDS, at_speed

SPEED_CHANCE, TILT_CHANCE, BENEATH_CHANCE, DRIVE_CHANCE, CUT_CHANCE = 0.8, 0.8, 0.5, 0.2, 0.5
"""How often each of the changes is made."""

BENEATH_DB = (-20.0, -3.0)
TILT_DB, PIVOT_HZ, MOST_TILTS = 4.0, (80.0, 12_000.0), 3
DRIVE_DB = (0.0, 12.0)
CUT_SHARE = 0.05


def augmented(film: Mix, other: Mix, rng: np.random.Generator) -> Mix:
    """Return a film augmented, half of the time with the other one beneath it; its labels are moved along.

    A shot that hardly stands out of what is before it then counts neither way.
    """
    film = _tilted(_at_speed(film, rng), rng)
    if rng.random() < BENEATH_CHANCE:
        film = _over(film, _tilted(_at_speed(other, rng), rng), rng.uniform(*BENEATH_DB))
    film = _cut(film, rng)
    samples = film.samples.astype(np.float64)
    top = peak(samples) or 1.0
    if rng.random() < DRIVE_CHANCE:
        samples = top * saturate(samples / top, rng.uniform(*DRIVE_DB))
    film = replace(film, samples=as_16_bit(samples / max(1.0, peak(samples))))
    return without_drowned(film, [[at] for at in film.onsets.tolist()])


def _at_speed(film: Mix, rng: np.random.Generator) -> Mix:
    if rng.random() >= SPEED_CHANCE:
        return film
    sound = Sound(film.samples.astype(np.float64), tuple(film.onsets.tolist()), tuple(film.unsure.tolist()))
    played = at_speed(sound, float(np.exp(rng.uniform(*np.log(SPEEDS)))))
    return replace(film, samples=_single(played.samples), onsets=_places(played.onsets), unsure=_places(played.unsure))


def _tilted(film: Mix, rng: np.random.Generator) -> Mix:
    if rng.random() >= TILT_CHANCE:
        return film
    samples = film.samples.astype(np.float64)
    for _ in range(int(rng.integers(1, MOST_TILTS + 1))):
        pivot_hz = float(np.exp(rng.uniform(*np.log(PIVOT_HZ))))
        samples = tilt(samples, TILT_DB * rng.standard_normal(), pivot_hz=pivot_hz, rate_hz=RATE_HZ)
    return replace(film, samples=_single(samples))


def _over(film: Mix, other: Mix, level_db: float) -> Mix:
    """Return the film with the other one beneath it, as far as it goes; the level is between their mean powers."""
    length = min(film.samples.size, other.samples.size)
    gain = (
        gain_from_db(level_db) * rms(film.samples.astype(np.float64)) / max(rms(other.samples.astype(np.float64)), 1e-6)
    )
    samples = film.samples.copy()
    samples[:length] += np.float32(gain) * other.samples[:length]
    heard = other.onsets < length
    onsets = np.concatenate([film.onsets, other.onsets[heard]])
    order = np.argsort(onsets, kind="stable")
    level = np.concatenate([film.level_db, other.level_db[heard]])
    unsure = np.concatenate([film.unsure, other.unsure[other.unsure < length]])
    return Mix(samples, onsets[order], level[order], unsure)


def _cut(film: Mix, rng: np.random.Generator) -> Mix:
    """Return the film, half of the time without some of its beginning: then it is scanned otherwise."""
    if rng.random() >= CUT_CHANCE:
        return film
    start = int(rng.uniform(0.0, CUT_SHARE) * film.samples.size)
    kept = film.onsets >= start
    unsure = film.unsure[film.unsure >= start] - start
    return Mix(film.samples[start:], film.onsets[kept] - start, film.level_db[kept], unsure)


def _single(samples: Samples) -> NDArray[np.float32]:
    return samples.astype(np.float32)


def _places(places: tuple[int, ...]) -> NDArray[np.intp]:
    return np.array(places, np.intp)

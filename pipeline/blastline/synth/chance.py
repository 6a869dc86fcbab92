"""Randomness that is always the same: one generator for each item, made from the scene's seed and the item's name.

Adding an item to a scene, or moving its neighbours, does not change what the item sounds like. Parameters are drawn
from the item's own generator and noise from a fork of it, so that another sample rate draws the same parameters.
"""

import zlib
from collections.abc import Sequence
from typing import TypeVar

import numpy as np

_T = TypeVar("_T")


def generator(seed: int, *names: str | int) -> np.random.Generator:
    """Return the generator that belongs to the names under a seed."""
    key = tuple(name if isinstance(name, int) else zlib.crc32(name.encode()) for name in names)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))


def fork(rng: np.random.Generator) -> np.random.Generator:
    """Return a new generator seeded by one draw, so that what it draws leaves `rng` where it is."""
    return np.random.default_rng(int(rng.integers(2**62)))


def between(rng: np.random.Generator, limits: tuple[float, float]) -> float:
    """Return a value drawn evenly from a range."""
    return float(rng.uniform(*limits))


def log_between(rng: np.random.Generator, limits: tuple[float, float]) -> float:
    """Return a value drawn from a range of positive numbers, every octave equally often."""
    low, high = limits
    return float(low * (high / low) ** rng.random())


def chance(rng: np.random.Generator, probability: float) -> bool:
    """Return True as often as `probability` says."""
    return bool(rng.random() < probability)


def pick(rng: np.random.Generator, choices: Sequence[_T]) -> _T:
    """Return one of the choices, each equally often."""
    return choices[int(rng.integers(len(choices)))]

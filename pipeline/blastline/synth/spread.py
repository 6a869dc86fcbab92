"""Shots and negatives that nobody placed: drawn, and spread over time without running into each other."""

from typing import TypeVar

import msgspec
import numpy as np

from .chance import between, chance, generator, pick
from .negatives import NEGATIVE_KINDS, NegativeKind
from .rooms import ENVIRONMENTS
from .scene import BurstItem, NegativeItem, Scene, ShotItem
from .weapons import WEAPONS

BURST_CHANCE = 0.09
"""How many of the draws are bursts or double taps; with 3-12 shots each, about a third of the shots are theirs."""

ENDING_S = 1.0
"""The last second of a scene is left for what still sounds."""

_Item = TypeVar("_Item", ShotItem, NegativeItem)


def expanded(scene: Scene) -> Scene:
    """Return the scene with the shots and negatives that `[random]` asks for among its own, and without `[random]`."""
    asked = scene.random
    if asked is None:
        return scene
    rng = generator(scene.seed, "random")
    shots = draw_shots(rng, asked.shots, asked.shot_snr_db)
    negatives = draw_negatives(rng, asked.negatives, asked.negative_snr_db, kinds=asked.kinds or NEGATIVE_KINDS)
    stop_s = max(scene.duration_s - ENDING_S, 0.5 * scene.duration_s)
    shots, negatives = spread(rng, shots, negatives, start_s=0.0, stop_s=stop_s, spacing_s=asked.spacing_s)
    return msgspec.structs.replace(
        scene, random=None, shots=scene.shots + tuple(shots), negatives=scene.negatives + tuple(negatives)
    )


def draw_shots(rng: np.random.Generator, count: int, snr_db: tuple[float, float]) -> list[ShotItem]:
    """Return random items of so many shots altogether, some in bursts, without their times."""
    items: list[ShotItem] = []
    left = count
    while left > 0:
        burst = _draw_burst(rng, left) if left > 1 and chance(rng, BURST_CHANCE) else None
        items.append(_draw_shot(rng, snr_db, burst))
        left -= items[-1].burst.shots if items[-1].burst is not None else 1
    return items


def draw_negatives(
    rng: np.random.Generator, count: int, snr_db: tuple[float, float], *, kinds: tuple[NegativeKind, ...]
) -> list[NegativeItem]:
    """Return so many random negatives of the given kinds, without their times; each kind before any comes again."""
    order = [kinds[int(index)] for _ in range(count // len(kinds) + 1) for index in rng.permutation(len(kinds))]
    return [NegativeItem(at_s=0.0, kind=kind, snr_db=between(rng, snr_db)) for kind in order[:count]]


def spread(
    rng: np.random.Generator,
    shots: list[ShotItem],
    negatives: list[NegativeItem],
    *,
    start_s: float,
    stop_s: float,
    spacing_s: float,
) -> tuple[list[ShotItem], list[NegativeItem]]:
    """Return the items at random times from `start_s` to `stop_s`, `spacing_s` apart, or closer where they must be."""
    items: list[ShotItem | NegativeItem] = [*shots, *negatives]
    items = [items[int(index)] for index in rng.permutation(len(items))]
    lengths = np.array([_length_s(item) + spacing_s for item in items])
    free = stop_s - start_s - float(lengths.sum())
    if free < 0.0:
        lengths *= (stop_s - start_s) / float(lengths.sum())
    starts = start_s + np.sort(rng.uniform(0.0, max(free, 0.0), len(items))) + np.cumsum(lengths) - lengths
    placed = [msgspec.structs.replace(item, at_s=float(at)) for item, at in zip(items, starts, strict=True)]
    return (
        [item for item in placed if isinstance(item, ShotItem)],
        [item for item in placed if isinstance(item, NegativeItem)],
    )


def _draw_shot(rng: np.random.Generator, snr_db: tuple[float, float], burst: BurstItem | None) -> ShotItem:
    automatic = tuple(name for name, weapon in WEAPONS.items() if weapon.rpm is not None)
    return ShotItem(
        at_s=0.0,
        weapon=pick(rng, tuple(WEAPONS) if burst is None or burst.shots == 2 else automatic),
        environment=pick(rng, ENVIRONMENTS),
        snr_db=between(rng, snr_db),
        recording="clean" if chance(rng, 0.08) else "film",
        burst=burst,
    )


def _draw_burst(rng: np.random.Generator, most: int) -> BurstItem:
    """Return a double tap by hand, 60-250 ms apart, or 3-12 shots at 450-1200 a minute."""
    if most < 3 or chance(rng, 0.25):
        return BurstItem(shots=2, rpm=60.0 / between(rng, (0.06, 0.25)), jitter=0.0)
    shots = min(int(rng.integers(3, 13)), most)
    return BurstItem(shots=shots, rpm=between(rng, (450.0, 1_200.0)), jitter=between(rng, (0.0, 0.08)))


def _length_s(item: ShotItem | NegativeItem) -> float:
    burst = item.burst if isinstance(item, ShotItem) else None
    return 0.0 if burst is None else burst.shots * 60.0 / burst.rpm

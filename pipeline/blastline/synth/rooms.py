"""Where a sound happens: the echoes that geometry gives, and the diffuse tail that statistics give.

Two walls and a ground make a street, a box a room or a hall, the ground alone a field; trees and hills add far, smeared
echoes. Behind the early echoes lies noise that dies away, its energy from diffuse-field theory:
E_tail / E_direct = 16 pi d^2 (1 - a) / (S a), and its reverberation time by Eyring.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..units import gain_from_db
from .chance import between, chance, log_between
from .images import SPEED_OF_SOUND_M_S, Axis, Echo, image_echoes
from .tone import Samples, bandpass, lowpass

DAMPED_CHANCE = 0.4
_SABINE_S_M = 0.161  # 24 ln 10 / c, of the reverberation times of Sabine and Eyring, with c = 343 m/s

Environment = Literal["indoors", "street", "field", "hall", "far"]
ENVIRONMENTS: tuple[Environment, ...] = ("indoors", "street", "field", "hall", "far")


@dataclass(frozen=True)
class Tail:
    """The diffuse sound: its energy against the direct sound's, when it starts, how it grows, and how it dies.

    `low_s` and `high_s` are the reverberation times (to -60 dB) below and above `split_hz`.
    """

    level_db: float
    start_s: float
    growth_s: float
    low_s: float
    high_s: float
    split_hz: float
    band_hz: tuple[float, float]


@dataclass(frozen=True)
class Acoustics:
    """How a place sounds between a source and a listener: the echoes between them in order of time, and the tail."""

    distance_m: float
    echoes: tuple[Echo, ...]
    tail: Tail | None


def draw_acoustics(rng: np.random.Generator, environment: Environment, *, distance_m: float | None = None) -> Acoustics:
    """Return the acoustics of a random place of its kind; the source is `distance_m` away where it is given.

    Four in ten are damped: a directed microphone, a padded room or an edited clip keeps little of the place.
    """
    acoustics = _DRAWS[environment](rng, distance_m)
    if acoustics.tail is None or not chance(rng, DAMPED_CHANCE):
        return acoustics
    gain, shorter = log_between(rng, (0.05, 0.7)), log_between(rng, (0.3, 1.0))
    tail = replace(
        acoustics.tail,
        level_db=acoustics.tail.level_db - between(rng, (4.0, 25.0)),
        low_s=max(0.1, shorter * acoustics.tail.low_s),
        high_s=max(0.05, shorter * acoustics.tail.high_s),
    )
    return Acoustics(
        acoustics.distance_m, tuple(replace(echo, gain=gain * echo.gain) for echo in acoustics.echoes), tail
    )


def tail_noise(rng: np.random.Generator, rate_hz: int, tail: Tail) -> Samples:
    """Return the impulse response of the diffuse sound from its start, for a direct sound of one sample of height 1."""
    length_s = min(1.1 * max(tail.low_s, tail.high_s), 4.0)
    times = np.arange(math.ceil(length_s * rate_hz)) / rate_hz
    noise = bandpass(rng.standard_normal(len(times)), *tail.band_hz, rate_hz=rate_hz)
    low = lowpass(noise, tail.split_hz, rate_hz=rate_hz)
    decayed = low * 10.0 ** (-3.0 * times / tail.low_s) + (noise - low) * 10.0 ** (-3.0 * times / tail.high_s)
    grown = decayed * (1.0 - np.exp(-times / tail.growth_s))
    energy = float(np.sum(np.square(grown)))
    scale = math.sqrt(10.0 ** (tail.level_db / 10.0) / energy) if energy > 0.0 else 0.0
    return np.asarray(scale * grown, dtype=np.float64)


def _room(rng: np.random.Generator, distance_m: float | None, *, hall: bool) -> Acoustics:
    size = [log_between(rng, (14.0, 45.0) if hall else (2.6, 13.0)) for _ in range(2)]
    size.append(log_between(rng, (5.0, 16.0) if hall else (2.2, 4.5)))
    reflection = math.sqrt(1.0 - log_between(rng, (0.06, 0.5)))
    axes, direct = _inside(rng, size, reflection, distance_m)
    _, echoes = image_echoes(axes, order=1 if hall else 2, corner_hz=log_between(rng, (3_000.0, 16_000.0)))
    volume, surface = math.prod(size), 2.0 * sum(a * b for a, b in itertools.combinations(size, 2))
    absorption = 1.0 - reflection**2
    reverberation = _SABINE_S_M * volume / (-surface * math.log(1.0 - absorption))
    level = 16.0 * math.pi * direct**2 * (1.0 - absorption) / (surface * absorption)
    free_path = 4.0 * volume / surface / SPEED_OF_SOUND_M_S
    return Acoustics(direct, echoes, _room_tail(rng, 10.0 * math.log10(level), free_path, reverberation))


def _room_tail(rng: np.random.Generator, level_db: float, free_path_s: float, reverberation_s: float) -> Tail:
    low = min(max(reverberation_s, 0.12), 3.0)
    return Tail(
        level_db=min(level_db, 12.0) + between(rng, (-3.0, 3.0)),
        start_s=free_path_s * between(rng, (0.3, 1.0)),
        growth_s=free_path_s * between(rng, (0.5, 3.0)),
        low_s=low * between(rng, (0.9, 1.5)),
        high_s=low * between(rng, (0.3, 0.9)),
        split_hz=log_between(rng, (500.0, 3_000.0)),
        band_hz=(log_between(rng, (30.0, 150.0)), log_between(rng, (4_000.0, 16_000.0))),
    )


def _inside(
    rng: np.random.Generator, size: list[float], reflection: float, distance_m: float | None
) -> tuple[tuple[Axis, Axis, Axis], float]:
    """Return a box with a source and a listener in it, as far apart as asked for where the box allows."""
    source = [length * between(rng, (0.1, 0.9)) for length in size]
    source[2] = min(1.5, 0.6 * size[2])
    angle = between(rng, (0.0, 2.0 * math.pi))
    reach = distance_m if distance_m is not None else log_between(rng, (0.7, max(size)))
    listener = [source[0] + reach * math.cos(angle), source[1] + reach * math.sin(angle), source[2]]
    listener = [min(max(at, 0.05 * length), 0.95 * length) for at, length in zip(listener, size, strict=True)]
    listener[2] += between(rng, (-0.5, 0.5))
    walls = [min(0.98, reflection * between(rng, (0.9, 1.05))) for _ in size]
    x, y, z = (Axis(*values) for values in zip(size, source, listener, walls, strict=True))
    return (x, y, z), max(math.dist(source, listener), 0.3)


def _street(rng: np.random.Generator, distance_m: float | None) -> Acoustics:
    width = log_between(rng, (4.0, 40.0))
    reach = distance_m if distance_m is not None else log_between(rng, (2.0, 80.0))
    across = Axis(width, width * between(rng, (0.1, 0.9)), width * between(rng, (0.1, 0.9)), between(rng, (0.45, 0.92)))
    along = Axis(None, 0.0, reach, 0.0)
    axes = (across, along, _ground(rng))
    direct, echoes = image_echoes(axes, order=4, corner_hz=log_between(rng, (3_000.0, 14_000.0)))
    if chance(rng, 0.5):
        echoes += _far_reflectors(rng, direct, distances_m=(15.0, 150.0), loss_db=(4.0, 20.0), smear_ms=(0.0, 8.0))
    return Acoustics(
        direct, tuple(sorted(echoes, key=lambda echo: echo.delay_s)), _open_tail(rng, (-12.0, 6.0), (0.4, 2.0))
    )


def _field(rng: np.random.Generator, distance_m: float | None) -> Acoustics:
    reach = distance_m if distance_m is not None else log_between(rng, (0.7, 120.0))
    axes = (Axis(None, 0.0, reach, 0.0), Axis(None, 0.0, 0.0, 0.0), _ground(rng))
    direct, echoes = image_echoes(axes, order=0, corner_hz=log_between(rng, (2_000.0, 12_000.0)))
    if chance(rng, 0.7):
        echoes += _far_reflectors(rng, direct, distances_m=(20.0, 300.0), loss_db=(6.0, 30.0), smear_ms=(1.0, 60.0))
    return Acoustics(
        direct, tuple(sorted(echoes, key=lambda echo: echo.delay_s)), _open_tail(rng, (-24.0, 2.0), (0.5, 2.8))
    )


def _far(rng: np.random.Generator, distance_m: float | None) -> Acoustics:
    reach = distance_m if distance_m is not None else log_between(rng, (120.0, 1_500.0))
    axes = (Axis(None, 0.0, reach, 0.0), Axis(None, 0.0, 0.0, 0.0), _ground(rng))
    direct, echoes = image_echoes(axes, order=0, corner_hz=log_between(rng, (1_000.0, 4_000.0)))
    echoes += _far_reflectors(rng, direct, distances_m=(40.0, 500.0), loss_db=(0.0, 16.0), smear_ms=(4.0, 120.0))
    return Acoustics(
        direct, tuple(sorted(echoes, key=lambda echo: echo.delay_s)), _open_tail(rng, (-12.0, 8.0), (0.8, 3.2))
    )


def _ground(rng: np.random.Generator) -> Axis:
    """Return the ground under a weapon at 0.3-2 m and a microphone at 0.5-4 m; soft ground reflects less."""
    return Axis(None, between(rng, (0.3, 2.0)), log_between(rng, (0.5, 4.0)), between(rng, (0.25, 0.95)))


def _far_reflectors(
    rng: np.random.Generator,
    direct_m: float,
    *,
    distances_m: tuple[float, float],
    loss_db: tuple[float, float],
    smear_ms: tuple[float, float],
) -> tuple[Echo, ...]:
    """Return the echoes of buildings, trees or hills: a detour of twice their distance, smeared by their depth."""
    echoes = []
    for _ in range(int(rng.integers(1, 5))):
        detour = 2.0 * log_between(rng, distances_m)
        gain = math.sqrt(direct_m / (direct_m + detour)) * gain_from_db(-between(rng, loss_db))
        corner = log_between(rng, (600.0, 6_000.0))
        echoes.append(Echo(detour / SPEED_OF_SOUND_M_S, gain, corner, between(rng, smear_ms)))
    return tuple(echoes)


def _open_tail(rng: np.random.Generator, level_db: tuple[float, float], low_s: tuple[float, float]) -> Tail:
    low = log_between(rng, low_s)
    return Tail(
        level_db=between(rng, level_db),
        start_s=log_between(rng, (0.004, 0.06)),
        growth_s=log_between(rng, (0.005, 0.25)),
        low_s=low,
        high_s=low * between(rng, (0.2, 0.8)),
        split_hz=log_between(rng, (300.0, 2_000.0)),
        band_hz=(log_between(rng, (25.0, 200.0)), log_between(rng, (800.0, 10_000.0))),
    )


_DRAWS: dict[str, Callable[[np.random.Generator, float | None], Acoustics]] = {
    "indoors": lambda rng, distance_m: _room(rng, distance_m, hall=False),
    "hall": lambda rng, distance_m: _room(rng, distance_m, hall=True),
    "street": _street,
    "field": _field,
    "far": _far,
}

"""A dry sound put into a place: its echoes and its tail added."""

import math
from dataclasses import dataclass

import numpy as np

from .chance import fork
from .images import Echo
from .rooms import Acoustics, Tail, tail_noise
from .tone import Samples, lowpass, peak
from .waves import noise_burst

SMEAR_SPREAD = 3.8
"""How long a smeared echo is, in times of its `smear_ms`."""


HEAD_S = 0.016


@dataclass(frozen=True, eq=False)
class HeardEcho:
    """An echo as it came out: where it starts after the direct sound, and its peak against that of the direct one.

    `head` are its first 16 ms.
    """

    delay: int
    gain: float
    head: Samples


def with_acoustics(
    rng: np.random.Generator, direct: Samples, acoustics: Acoustics, *, rate_hz: int
) -> tuple[Samples, tuple[HeardEcho, ...]]:
    """Return the sound with its echoes and its tail, and the echoes as they came out; the direct sound comes first."""
    top = peak(direct)
    longest = max(
        (round((echo.delay_s + SMEAR_SPREAD * 1e-3 * echo.smear_ms) * rate_hz) for echo in acoustics.echoes), default=0
    )
    # added one by one: sixty copies of a long sound would fill the memory
    total = np.zeros(len(direct) + longest + 2)
    total[: len(direct)] = direct
    heard = []
    darker: dict[float, Samples] = {}
    for echo in acoustics.echoes:
        if echo.corner_hz not in darker:
            darker[echo.corner_hz] = lowpass(direct, echo.corner_hz, rate_hz=rate_hz)
        part = _smeared(rng, darker[echo.corner_hz], echo, rate_hz=rate_hz) * echo.gain
        delay = round(echo.delay_s * rate_hz)
        total[delay : delay + len(part)] += part
        heard.append(HeardEcho(delay, peak(part) / top, part[: math.ceil(HEAD_S * rate_hz)].copy()))
    if acoustics.tail is not None:
        start = round(acoustics.tail.start_s * rate_hz)
        total = overlaid([(0, total), (start, _diffuse(fork(rng), direct, acoustics.tail, rate_hz=rate_hz))])
    return total, tuple(heard)


def overlaid(parts: list[tuple[int, Samples]]) -> Samples:
    """Return the sum of sounds that start at the given samples, all of them 0 or later."""
    total = np.zeros(max((at + len(part) for at, part in parts), default=0))
    for at, part in parts:
        total[at : at + len(part)] += part
    return total


def _smeared(rng: np.random.Generator, sound: Samples, echo: Echo, *, rate_hz: int) -> Samples:
    """Return an echo off something deep or ragged: spread by noise of the same energy."""
    if echo.smear_ms <= 0.0:
        return sound
    from scipy.signal import fftconvolve

    spread = noise_burst(fork(rng), rate_hz, attack_ms=0.3 * echo.smear_ms, decay_ms=0.5 * echo.smear_ms)
    spread = spread[: round(SMEAR_SPREAD * 1e-3 * echo.smear_ms * rate_hz) + 1]
    spread /= np.sqrt(np.sum(np.square(spread)))
    return np.asarray(fftconvolve(sound, spread), dtype=np.float64)


def _diffuse(rng: np.random.Generator, direct: Samples, tail: Tail, *, rate_hz: int) -> Samples:
    from scipy.signal import fftconvolve

    return np.asarray(fftconvolve(direct, tail_noise(rng, rate_hz, tail)), dtype=np.float64)

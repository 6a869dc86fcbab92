"""What hands do near a microphone: bolts, magazines, latches, locks, tools, claps; dry, and often a few in a row.

knock = click + short ring of what is struck      some of them 10-250 ms apart
sound = knocks + what rubs between them           next to no room
"""

import numpy as np

from ..units import gain_from_db
from .chance import between, chance, fork, log_between, pick
from .echoes import overlaid
from .impacts import Material, draw_body, series, struck
from .noises import coloured
from .tone import Samples, bandpass, highpass, lowpass, saturate
from .waves import band_burst, normalised

_MATERIALS: tuple[Material, ...] = ("metal", "metal", "plastic", "sheet", "wood", "stone", "glass")


def handling(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return one movement or the same again and again, with a peak of 1."""
    sound = _movement(rng, rate_hz)
    if chance(rng, 0.3):
        again = [sound, *(_movement(fork(rng), rate_hz) for _ in range(int(rng.integers(0, 3))))]
        gap_s = log_between(rng, (0.07, 0.9))
        gaps_s = gap_s * (1.0 + pick(rng, (0.005, 0.03, 0.15)) * rng.standard_normal(int(rng.integers(1, 14))))
        sound = series(rng, again, gaps_s=np.abs(gaps_s), levels_db=between(rng, (0.3, 3.0)), rate_hz=rate_hz)
    if chance(rng, 0.3):
        sound = saturate(normalised(sound), between(rng, (0.0, 18.0)))
    if chance(rng, 0.4):
        sound = highpass(sound, log_between(rng, (30.0, 500.0)), rate_hz=rate_hz)
    if chance(rng, 0.3):
        sound = lowpass(sound, log_between(rng, (2_000.0, 16_000.0)), rate_hz=rate_hz, order=pick(rng, (1, 2)))
    return normalised(sound)


def _movement(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return one to six knocks of one thing, at random times and levels, and what rubs meanwhile."""
    parts, at_s = [], 0.0
    body = draw_body(fork(rng), pick(rng, _MATERIALS))
    for number in range(pick(rng, (1, 1, 2, 2, 3, 4, 6))):
        at_s += log_between(rng, (0.008, 0.25)) if number else 0.0
        ring = struck(fork(rng), rate_hz, body, hardness=log_between(rng, (0.7, 4.0)))
        ring = ring * np.exp(-np.arange(len(ring)) / (log_between(rng, (0.002, 0.06)) * rate_hz))
        knock = overlaid([(0, normalised(ring) * gain_from_db(between(rng, (-24.0, 3.0)))), (0, _click(rng, rate_hz))])
        parts.append((round(at_s * rate_hz), normalised(knock) * gain_from_db(between(rng, (-18.0, 0.0)))))
    if chance(rng, 0.5):
        frames = round((at_s + log_between(rng, (0.02, 0.4))) * rate_hz)
        low_hz = log_between(rng, (150.0, 3_000.0))
        rub = coloured(fork(rng), frames, slope=between(rng, (0.0, 1.0)), rate_hz=rate_hz)
        rub = bandpass(rub, low_hz, low_hz * log_between(rng, (2.0, 20.0)), rate_hz=rate_hz)
        bow = np.sin(np.pi * (np.arange(frames) + 0.5) / frames)
        parts.append((0, normalised(rub * bow) * gain_from_db(between(rng, (-50.0, -12.0)))))
    return normalised(overlaid(parts))


def _click(rng: np.random.Generator, rate_hz: int) -> Samples:
    low_hz = log_between(rng, (80.0, 4_000.0))
    return band_burst(
        fork(rng),
        rate_hz,
        band_hz=(low_hz, min(0.4 * rate_hz, low_hz * log_between(rng, (2.0, 60.0)))),
        attack_ms=pick(rng, (0.0, log_between(rng, (0.05, 4.0)))),
        decay_ms=log_between(rng, (0.2, 10.0)),
    )

"""Loud things that are not guns: thunder, fireworks, explosions, whips, sparks, blows of a film fight, splashes."""

import math

import numpy as np

from .chance import between, chance, fork, log_between, pick
from .echoes import overlaid
from .images import SPEED_OF_SOUND_M_S
from .impacts import draw_body, struck
from .noises import coloured, slow
from .tone import Samples, bandpass, lowpass, resonance
from .waves import band_burst, boom, friedlander, noise_burst, normalised


def thunder(rng: np.random.Generator, rate_hz: int, *, near: bool) -> Samples:
    """Return a stroke as the channel gives it: one pulse from each bend of kilometres of lightning, spread by distance.

    Near, the first bends arrive together as a ripping crack; far, only the rumble is left.
    """
    nearest_m, length_m = (log_between(rng, (80.0, 500.0)), log_between(rng, (500.0, 2_500.0)))
    if not near:
        nearest_m = log_between(rng, (1_200.0, 7_000.0))
    count = int(rng.integers(60, 260))
    along = np.cumsum(rng.exponential(length_m / count, count))
    paths = nearest_m + np.abs(along * between(rng, (0.3, 1.0)) + 20.0 * rng.standard_normal(count))
    strengths = np.exp(0.8 * rng.standard_normal(count)) * nearest_m / paths
    delays = np.round((paths - paths.min()) / SPEED_OF_SOUND_M_S * rate_hz).astype(np.int64)
    pulse = friedlander(rate_hz, positive_ms=log_between(rng, (3.0, 12.0)), rise_ms=0.5 if near else 3.0)
    parts = []
    for delay, strength, path in zip(delays, strengths, paths, strict=True):
        if delay < 6 * rate_hz:
            parts.append((int(delay), strength * pulse * pick(rng, (1.0, -1.0)) * min(1.0, 300.0 / path)))
    total = overlaid(parts)
    rumble = coloured(fork(rng), len(total), slope=2.0, rate_hz=rate_hz)
    fall = np.exp(-np.arange(len(total)) / (between(rng, (0.8, 2.5)) * rate_hz))
    swell = slow(fork(rng), len(total), step_s=0.4, depth_db=4.0, rate_hz=rate_hz)
    rise = np.minimum(np.arange(len(total)) / (0.25 * rate_hz), 1.0)
    total = normalised(total) + between(rng, (0.05, 0.4)) * normalised(rumble * fall * swell * rise)
    return normalised(lowpass(total, log_between(rng, (2_000.0, 7_000.0) if near else (150.0, 700.0)), rate_hz=rate_hz))


def firework(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a rocket as in life: the mortar's thump, a whistle that climbs, a burst, and a crackle that follows."""
    climb_s = between(rng, (0.7, 2.0))
    thump = boom(rate_hz, start_hz=120.0, stop_hz=between(rng, (45.0, 80.0)), attack_ms=3.0, decay_ms=60.0)
    count = round(climb_s * rate_hz)
    glide = np.geomspace(log_between(rng, (900.0, 2_500.0)), log_between(rng, (1_500.0, 5_000.0)), count)
    shake = 1.0 + 0.04 * np.sin(2.0 * math.pi * 14.0 * np.arange(count) / rate_hz)
    whistle = np.sin(2.0 * math.pi * np.cumsum(glide * shake) / rate_hz) * np.hanning(count)
    parts = [(0, thump * between(rng, (0.2, 0.8))), (0, whistle * between(rng, (0.05, 0.4)))]
    burst = band_burst(fork(rng), rate_hz, band_hz=(40.0, 2_500.0), attack_ms=6.0, decay_ms=between(rng, (20.0, 90.0)))
    parts.append((count, burst * between(rng, (0.6, 1.0))))
    sparks = [
        band_burst(fork(rng), rate_hz, band_hz=(2_000.0, 12_000.0), attack_ms=0.1, decay_ms=1.5) for _ in range(6)
    ]
    spread_s = between(rng, (0.3, 1.2))
    for _ in range(int(rng.integers(30, 160))):
        at = count + round((0.15 + spread_s * rng.random()) * rate_hz)
        parts.append((at, pick(rng, sparks) * log_between(rng, (0.05, 0.5))))
    return normalised(overlaid(parts))


def explosion(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a large charge: a long blast wave, a fireball's roar of a second or more, and debris."""
    blast = friedlander(rate_hz, positive_ms=log_between(rng, (4.0, 25.0)), rise_ms=log_between(rng, (0.1, 4.0)))
    length = round(between(rng, (1.5, 4.0)) * rate_hz)
    roar = coloured(fork(rng), length, slope=between(rng, (1.0, 2.0)), rate_hz=rate_hz)
    envelope = np.exp(-np.arange(length) / (between(rng, (0.25, 1.0)) * rate_hz))
    attack = np.minimum(np.arange(length) / (between(rng, (0.002, 0.06)) * rate_hz), 1.0)
    parts = [(0, blast), (0, normalised(roar * envelope * attack) * between(rng, (0.4, 1.2)))]
    shards = [struck(fork(rng), rate_hz, draw_body(rng, pick(rng, ("stone", "wood", "sheet")))) for _ in range(4)]
    for _ in range(int(rng.integers(0, 25))):
        parts.append((round(between(rng, (0.2, 2.5)) * rate_hz), pick(rng, shards) * log_between(rng, (0.01, 0.15))))
    return normalised(lowpass(overlaid(parts), log_between(rng, (800.0, 8_000.0)), rate_hz=rate_hz))


def whip(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a whip: a swish for a quarter of a second, then a crack of under a millisecond, without a blast's bass."""
    swish = whoosh(fork(rng), rate_hz)
    crack = band_burst(
        fork(rng),
        rate_hz,
        band_hz=(log_between(rng, (1_200.0, 3_500.0)), 16_000.0),
        attack_ms=0.05,
        decay_ms=log_between(rng, (0.3, 2.5)),
    )
    return normalised(overlaid([(0, swish * between(rng, (0.1, 0.4))), (round(0.7 * len(swish)), crack)]))


def whoosh(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a thing that flies past: noise that swells and fades within 0.15-0.8 s."""
    count = round(between(rng, (0.15, 0.8)) * rate_hz)
    centre = log_between(rng, (250.0, 2_500.0))
    band = resonance(rng.standard_normal(count), centre, bandwidth_hz=0.8 * centre, rate_hz=rate_hz)
    return normalised(band * np.hanning(count) ** between(rng, (1.0, 3.0)))


def punch(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a blow of a film fight: whoosh, slap and a dull thud."""
    swing = whoosh(fork(rng), rate_hz)
    at = round(between(rng, (0.4, 0.8)) * len(swing))
    thud = struck(fork(rng), rate_hz, draw_body(rng, "earth"))
    slap = band_burst(
        fork(rng),
        rate_hz,
        band_hz=(400.0, log_between(rng, (2_000.0, 7_000.0))),
        attack_ms=1.0,
        decay_ms=between(rng, (6.0, 40.0)),
    )
    return normalised(
        overlaid([(0, swing * between(rng, (0.05, 0.4))), (at, thud), (at, slap * between(rng, (0.2, 1.0)))])
    )


def spark(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return an electric arc or a vinyl record: a train of clicks at random times for up to a second."""
    click = band_burst(
        fork(rng),
        rate_hz,
        band_hz=(log_between(rng, (800.0, 4_000.0)), 16_000.0),
        attack_ms=0.03,
        decay_ms=log_between(rng, (0.1, 1.2)),
    )
    length_s = log_between(rng, (0.05, 1.2))
    times = np.sort(rng.random(int(rng.integers(3, 60)))) * length_s
    return normalised(
        overlaid([(round((at - times[0]) * rate_hz), click * log_between(rng, (0.1, 1.0))) for at in times.tolist()])
    )


def splash(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a body that falls into water: a slap, a swell of spray, and bubbles that ring and rise."""
    slap = struck(fork(rng), rate_hz, draw_body(rng, "earth"))
    spray = noise_burst(fork(rng), rate_hz, attack_ms=between(rng, (10.0, 70.0)), decay_ms=between(rng, (80.0, 350.0)))
    spray = normalised(bandpass(spray, 600.0, 9_000.0, rate_hz=rate_hz))
    parts = [(0, slap * between(rng, (0.2, 1.0))), (0, spray)]
    for _ in range(int(rng.integers(4, 25))):
        pitch = log_between(rng, (250.0, 1_800.0))
        bubble = boom(rate_hz, start_hz=pitch, stop_hz=1.3 * pitch, attack_ms=2.0, decay_ms=between(rng, (8.0, 40.0)))
        parts.append((round(between(rng, (0.05, 0.8)) * rate_hz), bubble * log_between(rng, (0.03, 0.3))))
    return normalised(overlaid(parts))


def crash(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return cars that collide or a shelf that falls: 8-40 blows on sheet, glass and wood, crowded at the start."""
    bodies = [draw_body(rng, pick(rng, ("sheet", "metal", "glass", "wood", "plastic"))) for _ in range(6)]
    blows = [struck(fork(rng), rate_hz, body) for body in bodies]
    parts = [(0, blows[0])]
    for _ in range(int(rng.integers(8, 40))):
        at_s = min(2.5, log_between(rng, (0.05, 0.6)) * rng.exponential())
        parts.append((round(at_s * rate_hz), pick(rng, blows) * log_between(rng, (0.05, 0.9))))
    if chance(rng, 0.5):
        parts.append((0, struck(fork(rng), rate_hz, draw_body(rng, "earth"))))
    return normalised(overlaid(parts))

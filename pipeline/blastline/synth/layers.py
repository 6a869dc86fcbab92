"""The layers that a designed gunshot is made of: crack, body, thump and tail, or a roar that is held; and mechanics."""

import numpy as np

from ..units import gain_from_db
from .chance import between, chance, fork, log_between, pick
from .impacts import draw_body, struck
from .noises import coloured, slow
from .tone import Samples, lowpass, resonance, saturate
from .waves import band_burst, boom, normalised

Layer = tuple[float, Samples]
"""A level in dB and a sound with a peak of 1."""


def draw_layers(rng: np.random.Generator, noise: np.random.Generator, rate_hz: int, *, dry: float) -> list[Layer]:
    """Return the layers of one round, drawn from `rng`, their noise from `noise`.

    A share `dry` of the rounds is the crack alone: as near as can be, or all else gated away. One in five is held.
    """
    crack = crack_layer(rng, noise, rate_hz)
    if chance(rng, dry):
        return [(0.0, crack)]
    if chance(rng, 0.2):
        layers = [(0.0, held_roar(rng, noise, rate_hz))]
        return [(between(rng, (-12.0, 6.0)), crack), *layers] if chance(rng, 0.6) else layers
    layers = [(0.0, crack), (between(rng, (-10.0, 8.0)), body_layer(rng, noise, rate_hz))]
    if chance(rng, 0.6):
        layers.append((between(rng, (-14.0, 6.0)), _thump(rng, rate_hz)))
    if chance(rng, 0.15):
        layers.append((between(rng, (-8.0, 8.0)), subsonic_swing(rng, rate_hz)))
    if chance(rng, 0.7):
        layers.append((between(rng, (-40.0, -8.0)), _tail(rng, noise, rate_hz)))
    return layers


def draw_mechanics(rng: np.random.Generator, noise: np.random.Generator, rate_hz: int) -> list[tuple[int, Samples]]:
    """Return a bolt or a case that rings after the shot, in a third of the designs, and where."""
    if not chance(rng, 0.35):
        return []
    at = round(log_between(rng, (0.02, 0.3)) * rate_hz)
    level = gain_from_db(between(rng, (-36.0, -8.0)))
    if chance(rng, 0.5):
        return [(at, struck(noise, rate_hz, draw_body(rng, pick(rng, ("metal", "plastic", "sheet")))) * level)]
    low_hz = log_between(rng, (500.0, 4_000.0))
    decay_ms = between(rng, (1.0, 12.0))
    click = band_burst(noise, rate_hz, band_hz=(low_hz, 3.0 * low_hz), attack_ms=0.2, decay_ms=decay_ms)
    return [(at, click * level)]


def crack_layer(rng: np.random.Generator, noise: np.random.Generator, rate_hz: int) -> Samples:
    """Return a short burst of noise; one in twelve rings at one frequency, as a bad microphone or a case does."""
    band_hz = (log_between(rng, (60.0, 2_500.0)), log_between(rng, (2_500.0, 18_000.0)))
    attack_ms = pick(rng, (0.0, log_between(rng, (0.1, 8.0))))
    decay_ms = log_between(rng, (0.4, 16.0))
    crack = band_burst(fork(noise), rate_hz, band_hz=band_hz, attack_ms=attack_ms, decay_ms=decay_ms)
    if not chance(rng, 1.0 / 12.0):
        return crack
    ring_hz = log_between(rng, (250.0, 4_000.0))
    room = np.concatenate([crack, np.zeros(round(0.1 * rate_hz))])
    return normalised(resonance(room, ring_hz, bandwidth_hz=ring_hz * log_between(rng, (0.03, 0.4)), rate_hz=rate_hz))


def body_layer(rng: np.random.Generator, noise: np.random.Generator, rate_hz: int) -> Samples:
    """Return a burst of noise, lower and longer than the crack."""
    band_hz = (log_between(rng, (30.0, 500.0)), log_between(rng, (500.0, 6_000.0)))
    attack_ms, decay_ms = log_between(rng, (0.05, 8.0)), log_between(rng, (4.0, 90.0))
    return band_burst(fork(noise), rate_hz, band_hz=band_hz, attack_ms=attack_ms, decay_ms=decay_ms)


def _thump(rng: np.random.Generator, rate_hz: int) -> Samples:
    start_hz = log_between(rng, (80.0, 500.0))
    stop_hz = start_hz * log_between(rng, (0.15, 0.8))
    attack_ms, decay_ms = log_between(rng, (0.2, 6.0)), log_between(rng, (12.0, 150.0))
    return boom(rate_hz, start_hz=start_hz, stop_hz=stop_hz, attack_ms=attack_ms, decay_ms=decay_ms)


def subsonic_swing(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return one to some slow swings beneath hearing, as an explosion that was slowed down leaves them."""
    start_hz = log_between(rng, (8.0, 50.0))
    attack_ms, decay_ms = log_between(rng, (0.5, 10.0)), log_between(rng, (60.0, 300.0))
    stop_hz = start_hz * log_between(rng, (0.4, 1.0))
    return boom(rate_hz, start_hz=start_hz, stop_hz=stop_hz, attack_ms=attack_ms, decay_ms=decay_ms)


def _tail(rng: np.random.Generator, noise: np.random.Generator, rate_hz: int) -> Samples:
    high_hz = log_between(rng, (600.0, 9_000.0))
    low_hz = high_hz * log_between(rng, (0.02, 0.4))
    attack_ms, decay_ms = log_between(rng, (0.5, 40.0)), log_between(rng, (40.0, 400.0))
    return band_burst(fork(noise), rate_hz, band_hz=(low_hz, high_hz), attack_ms=attack_ms, decay_ms=decay_ms)


def held_roar(rng: np.random.Generator, noise: np.random.Generator, rate_hz: int) -> Samples:
    """Return a roar that hardly falls for 20 to 300 ms, as a game has it: driven to the limit, then faded."""
    attack_s, hold_s = log_between(rng, (0.0001, 0.01)), log_between(rng, (0.02, 0.3))
    fade_s, bend = log_between(rng, (0.05, 0.5)), log_between(rng, (0.7, 4.0))
    times_s = np.arange(round((hold_s + fade_s) * rate_hz)) / rate_hz
    fade = np.clip((hold_s + fade_s - times_s) / fade_s, 0.0, 1.0) ** bend
    envelope = np.minimum(times_s / attack_s, 1.0) * fade
    roar = coloured(fork(noise), len(times_s), slope=between(rng, (0.0, 2.0)), rate_hz=rate_hz)
    dull = lowpass(roar, log_between(rng, (300.0, 6_000.0)), rate_hz=rate_hz)
    bright = np.exp(-times_s / log_between(rng, (0.02, 0.6)))
    roar = roar * bright + dull * (1.0 - bright)  # what is high dies first
    uneven = slow(fork(noise), len(times_s), step_s=log_between(rng, (0.003, 0.05)), depth_db=4.0, rate_hz=rate_hz)
    driven = saturate(normalised(roar * uneven), pick(rng, (0.0, between(rng, (6.0, 40.0)))))
    return normalised(driven * envelope)

"""Gunshots as sound designers and game makers build them: layers of noise and tones, cut, driven and copied.

    crack + body + thump + tail + mechanics      each begins within some milliseconds of the first (`layers`)
      perhaps in stages up to a quarter of a second apart, of other layers each: one shot all the same
      through overdrive, a sampler's rate and bits, a microphone, a place; cut short; repeated as it is or anew

`shots` follows the physics of a gun. Much of what films and games fire was never a gun: it is drier, it rises within
milliseconds instead of microseconds, and the rounds of a burst are often one sample again and again.
"""

import math
from collections.abc import Callable

import numpy as np

from ..units import gain_from_db
from .chance import between, chance, fork, log_between, pick
from .colour import draw_colour, record
from .echoes import overlaid, with_acoustics
from .impacts import series
from .layers import draw_layers, draw_mechanics
from .noises import coloured
from .rooms import ENVIRONMENTS, draw_acoustics
from .tone import Samples, bandpass, lowpass, saturate, trimmed
from .waves import band_burst, normalised

_LONGEST_S = 2.5
_SAMPLER_RATES_HZ = (8_000.0, 11_025.0, 16_000.0, 22_050.0)
_ROUNDS_PER_MINUTE = (400.0, 1_300.0)
_DRY, _DRY_IN_BURSTS = 0.08, 0.2  # a bare crack is a clap, several at a gun's pace are not


def designed_shot(rng: np.random.Generator, rate_hz: int) -> tuple[Samples, tuple[int, ...]]:
    """Return one shot or a burst of up to 16 rounds, with a peak of 1, and where the rounds begin."""
    design = fork(rng)
    rounds = 1 if chance(rng, 0.65) else int(rng.integers(2, 17))
    dry = _DRY if rounds == 1 else _DRY_IN_BURSTS
    if rounds == 1 and chance(rng, 0.4):
        sounds = [_finished(rng, staged_round(fork(design), rate_hz), rate_hz)]
    elif chance(rng, 0.6):
        one = _finished(rng, layered_round(fork(design), rate_hz, dry=dry), rate_hz)
        sounds = [one] * rounds
    else:
        seed = int(design.integers(2**62))
        layers = [layered_round(np.random.default_rng(seed), rate_hz, dry=dry, noise=fork(rng)) for _ in range(rounds)]
        chain = int(rng.integers(2**62))
        sounds = [_finished(np.random.default_rng(chain), sound, rate_hz) for sound in layers]
    return fired_in_a_row(rng, sounds, rate_hz)


def designed_negative(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return what is made of the same stuff and is no shot: a swell, a shot backwards, a bleep, a rattle, a hiss."""
    kind = pick(rng, _NEGATIVES)
    sound = _finished(rng, kind(fork(rng), rate_hz), rate_hz)
    if chance(rng, 0.75):
        return sound
    gap_s = log_between(rng, (0.07, 0.8))
    count = int(rng.integers(1, max(2, min(16, round(3.0 / gap_s)))))
    return series(rng, [sound], gaps_s=np.full(count, gap_s), levels_db=1.0, rate_hz=rate_hz)


def swell(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return the layers of a shot that take 15 to 150 ms to rise."""
    sound = layered_round(rng, rate_hz)
    rise = round(log_between(rng, (0.015, 0.15)) * rate_hz)
    longer = np.concatenate([sound, np.zeros(rise)])
    attack = np.minimum(np.arange(len(longer)) / rise, 1.0) ** between(rng, (0.7, 2.0))
    breath = band_burst(
        fork(rng),
        rate_hz,
        band_hz=(log_between(rng, (40.0, 800.0)), log_between(rng, (1_000.0, 12_000.0))),
        attack_ms=rise * 1e3 / rate_hz,
        decay_ms=log_between(rng, (20.0, 250.0)),
    )
    return normalised(overlaid([(0, longer * attack), (0, breath)]))


def backwards(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a round played from its end to its beginning."""
    sound = trimmed(layered_round(rng, rate_hz), floor=0.02)
    return sound[::-1].copy()


def _bleep(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return one to three gliding tones of a menu, a pick-up or an alarm, from a sine to a square wave."""
    parts, at_s = [], 0.0
    for _ in range(int(rng.integers(1, 4))):
        seconds = log_between(rng, (0.03, 0.4))
        frames = max(2, round(seconds * rate_hz))
        start_hz = log_between(rng, (120.0, 4_000.0))
        glide = np.geomspace(start_hz, start_hz * log_between(rng, (0.4, 2.5)), frames)
        wave = np.sin(2.0 * math.pi * np.cumsum(glide) / rate_hz)
        fall = np.exp(-np.arange(frames) / (between(rng, (0.15, 2.0)) * frames))
        attack = np.minimum(np.arange(frames) / (log_between(rng, (0.0003, 0.02)) * rate_hz), 1.0)
        parts.append((round(at_s * rate_hz), saturate(wave, pick(rng, (0.0, 6.0, 30.0))) * fall * attack))
        at_s += seconds * between(rng, (0.5, 1.2))
    return normalised(overlaid(parts))


def _rattle(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a ratchet, a chain or static: clicks of one or two kinds, fast, regular or at random."""
    low_hz = log_between(rng, (200.0, 4_000.0))
    band_hz = (low_hz, min(0.4 * rate_hz, low_hz * log_between(rng, (2.0, 20.0))))
    clicks = [
        band_burst(fork(rng), rate_hz, band_hz=band_hz, attack_ms=0.05, decay_ms=log_between(rng, (0.2, 6.0)))
        for _ in range(int(rng.integers(1, 3)))
    ]
    gap_s, loose = log_between(rng, (0.012, 0.12)), pick(rng, (0.02, 0.2, 1.0))
    count = int(rng.integers(4, max(5, min(120, round(2.5 / gap_s)))))
    gaps_s = gap_s * np.abs(1.0 + loose * rng.standard_normal(count))
    return series(rng, clicks, gaps_s=gaps_s, levels_db=between(rng, (0.5, 6.0)), rate_hz=rate_hz)


def hiss(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return steam, an air brake or static that bursts out, holds and dies away, without a blow."""
    attack_ms, hold_s = log_between(rng, (1.0, 60.0)), log_between(rng, (0.03, 1.0))
    noise = coloured(fork(rng), round((hold_s + 0.5) * rate_hz), slope=between(rng, (0.0, 1.0)), rate_hz=rate_hz)
    times_s = np.arange(len(noise)) / rate_hz
    after_s = np.maximum(times_s - hold_s, 0.0)
    envelope = np.minimum(times_s * 1e3 / attack_ms, 1.0) * np.exp(-after_s / log_between(rng, (0.003, 0.2)))
    low_hz = log_between(rng, (300.0, 4_000.0))
    return normalised(bandpass(noise * envelope, low_hz, low_hz * log_between(rng, (2.0, 20.0)), rate_hz=rate_hz))


_NEGATIVES: tuple[Callable[[np.random.Generator, int], Samples], ...] = (
    swell,
    backwards,
    _bleep,
    _rattle,
    hiss,
)


def fired_in_a_row(rng: np.random.Generator, sounds: list[Samples], rate_hz: int) -> tuple[Samples, tuple[int, ...]]:
    """Return rounds one after another at a gun's rate, each going on beneath the next or cut by it."""
    gap = 60.0 / log_between(rng, _ROUNDS_PER_MINUTE) * rate_hz
    jitter = pick(rng, (0.0, 0.01, 0.04))
    gaps = gap * (1.0 + jitter * rng.standard_normal(len(sounds) - 1))
    places = [0, *np.round(np.cumsum(gaps)).astype(int).tolist()]
    cut = chance(rng, 0.3)
    parts = []
    for number, (at, sound) in enumerate(zip(places, sounds, strict=True)):
        stop = places[number + 1] - at if cut and number + 1 < len(places) else len(sound)
        parts.append((at, sound[:stop] * gain_from_db(-abs(rng.standard_normal()))))
    return normalised(overlaid(parts)), tuple(places)


def layered_round(
    rng: np.random.Generator, rate_hz: int, *, dry: float = _DRY, noise: np.random.Generator | None = None
) -> Samples:
    """Return the layers of one round; they are drawn from `rng`, their noise from `noise` if that is another one."""
    noise = noise or fork(rng)
    layers = draw_layers(rng, noise, rate_hz, dry=dry)
    late_ms = pick(rng, (0.0, 0.0, 1.0)) * between(rng, (0.3, 4.0))  # all but one layer come so much after it
    first = int(rng.integers(len(layers)))
    parts = []
    for number, (level_db, layer) in enumerate(layers):
        delay_ms = 0.0 if number == first else late_ms + pick(rng, (0.0, 1.0)) * between(rng, (0.0, 3.0))
        parts.append((round(delay_ms * 1e-3 * rate_hz), layer * gain_from_db(level_db)))
    return normalised(overlaid(parts + draw_mechanics(rng, fork(noise), rate_hz))[: round(_LONGEST_S * rate_hz)])


def staged_round(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a round with one to three more stages of other layers, often louder than its beginning."""
    parts = [(0, layered_round(fork(rng), rate_hz))]
    for _ in range(pick(rng, (1, 1, 2, 3))):
        layers = draw_layers(fork(rng), fork(rng), rate_hz, dry=0.0)
        first = int(rng.integers(len(layers)))
        late_s = log_between(rng, (0.014, 0.26))
        level_db = between(rng, (-9.0, 6.0))
        stage = overlaid([(0, layer * gain_from_db(level)) for level, layer in layers[first:]])
        parts.append((round(late_s * rate_hz), normalised(stage) * gain_from_db(level_db)))
    return normalised(overlaid(parts)[: round(_LONGEST_S * rate_hz)])


def _finished(rng: np.random.Generator, sound: Samples, rate_hz: int) -> Samples:
    """Return a round through the chain of a sampler, a mixer and a place, cut short in two of five."""
    if chance(rng, 0.5):
        sound = saturate(sound, between(rng, (0.0, 30.0)))
    if chance(rng, 0.4):
        sound = played_by_sampler(rng, sound, rate_hz)
    if chance(rng, 0.4):
        sound = lowpass(sound, log_between(rng, (1_200.0, 9_000.0)), rate_hz=rate_hz, order=pick(rng, (1, 2)))
    if chance(rng, 0.4):
        sound = record(sound, draw_colour(rng), rate_hz=rate_hz)
    if chance(rng, 0.25):
        sound, _ = with_acoustics(rng, sound, draw_acoustics(rng, pick(rng, ENVIRONMENTS)), rate_hz=rate_hz)
    if chance(rng, 0.4):
        sound = sound[: round(log_between(rng, (0.07, 0.8)) * rate_hz)].copy()
    sound = sound[: round(_LONGEST_S * rate_hz)]
    fade = round(between(rng, (0.05, 0.5)) * len(sound))
    ending = np.linspace(1.0, 0.0, fade) ** between(rng, (0.5, 2.0))
    return normalised(np.concatenate([sound[: len(sound) - fade], sound[len(sound) - fade :] * ending]))


def played_by_sampler(rng: np.random.Generator, sound: Samples, rate_hz: int) -> Samples:
    """Return a sound as a sampler of few bits and a low rate plays it, with or without a filter behind it."""
    sampler_hz = pick(rng, _SAMPLER_RATES_HZ)
    dull = lowpass(sound, 0.45 * sampler_hz, rate_hz=rate_hz, order=6)
    held = np.floor(np.arange(len(dull)) * sampler_hz / rate_hz) * rate_hz / sampler_hz
    sampled = normalised(dull[np.minimum(np.ceil(held).astype(np.intp), len(dull) - 1)])
    if chance(rng, 0.5):
        steps = 2.0 ** int(rng.integers(4, 8))
        sampled = np.round(sampled * steps) / steps
    return lowpass(sampled, 0.5 * sampler_hz, rate_hz=rate_hz, order=4) if chance(rng, 0.6) else sampled

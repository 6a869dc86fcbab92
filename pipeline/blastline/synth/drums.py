"""Drums, hands and cymbals: single hits, rolls, loops and applause."""

import math

import numpy as np

from .chance import between, chance, fork, log_between, pick
from .echoes import overlaid
from .impacts import draw_body, modes, series, struck
from .tone import Samples, highpass
from .waves import band_burst, boom, normalised


def kick(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a bass drum: a tone that falls from a click to 40-70 Hz."""
    low = between(rng, (38.0, 75.0))
    tone = boom(
        rate_hz,
        start_hz=low * log_between(rng, (1.5, 8.0)),
        stop_hz=low,
        attack_ms=log_between(rng, (0.3, 4.0)),
        decay_ms=log_between(rng, (30.0, 250.0)),
    )
    beater = band_burst(
        fork(rng), rate_hz, band_hz=(1_500.0, 8_000.0), attack_ms=0.2, decay_ms=between(rng, (1.0, 8.0))
    )
    return normalised(overlaid([(0, tone), (0, beater * between(rng, (0.02, 0.5)))]))


def snare(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a snare drum: two modes of the head and the wires' noise."""
    pitch = log_between(rng, (140.0, 320.0))
    decay = log_between(rng, (0.02, 0.12))
    head = normalised(
        modes(
            rate_hz, pitch * np.array([1.0, 1.59, 2.14]), decay * np.array([1.0, 0.7, 0.5]), np.array([1.0, 0.6, 0.4])
        )
    )
    wires = band_burst(
        fork(rng),
        rate_hz,
        band_hz=(log_between(rng, (400.0, 2_500.0)), log_between(rng, (6_000.0, 16_000.0))),
        attack_ms=log_between(rng, (0.1, 1.5)),
        decay_ms=log_between(rng, (15.0, 140.0)),
    )
    return normalised(overlaid([(0, head * between(rng, (0.1, 1.0))), (0, wires * between(rng, (0.3, 1.0)))]))


def tom(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a tom, a conga or a kettledrum."""
    return struck(fork(rng), rate_hz, draw_body(rng, "membrane"), hardness=between(rng, (0.5, 2.0)))


def cymbal(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a hi-hat, a crash or a ride: dense high modes in noise."""
    body = draw_body(rng, "metal")
    ring = struck(fork(rng), rate_hz, body, hardness=3.0)
    wash = band_burst(
        fork(rng),
        rate_hz,
        band_hz=(log_between(rng, (2_000.0, 7_000.0)), 16_000.0),
        attack_ms=log_between(rng, (0.1, 2.0)),
        decay_ms=log_between(rng, (15.0, 500.0)),
    )
    return normalised(overlaid([(0, ring * between(rng, (0.05, 0.5))), (0, wash)]))


def clap(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return one hand clap: a band of noise around 0.6-2.5 kHz, at times in two or three flams."""
    centre = log_between(rng, (550.0, 2_600.0))
    decay_ms = log_between(rng, (1.5, 14.0))
    flams = int(rng.integers(1, 4)) if chance(rng, 0.4) else 1
    hits = [
        band_burst(fork(rng), rate_hz, band_hz=(0.7 * centre, 1.5 * centre), attack_ms=0.3, decay_ms=decay_ms)
        for _ in range(flams)
    ]
    slap = band_burst(fork(rng), rate_hz, band_hz=(2_000.0, 9_000.0), attack_ms=0.1, decay_ms=1.0)
    parts = [(round(0.011 * number * between(rng, (0.6, 1.4)) * rate_hz), hit) for number, hit in enumerate(hits)]
    return normalised(overlaid([*parts, (0, slap * between(rng, (0.0, 0.5)))]))


def applause(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return 3-60 people who clap at their own pace for 2-5 seconds, some of them in time."""
    length_s = between(rng, (2.0, 5.0))
    claps = [clap(fork(rng), rate_hz) for _ in range(12)]
    parts = []
    for _ in range(round(log_between(rng, (3.0, 60.0)))):
        own, pace_s = pick(rng, claps) * log_between(rng, (0.1, 1.0)), between(rng, (0.16, 0.45))
        at_s = rng.random() * pace_s
        while at_s < length_s:
            parts.append((round(at_s * rate_hz), own))
            at_s += pace_s * between(rng, (0.9, 1.1))
    return normalised(overlaid(parts))


def roll(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a drum roll or fill: 5-40 strokes of one drum that speed up, slow down or swell."""
    maker = pick(rng, (snare, tom, snare))
    seed = int(rng.integers(2**62))
    strokes = [maker(np.random.default_rng(seed), rate_hz) for _ in range(2)]
    count = int(rng.integers(4, 40))
    gaps = np.linspace(between(rng, (0.035, 0.16)), between(rng, (0.035, 0.16)), count)
    return series(rng, strokes, gaps_s=gaps, levels_db=between(rng, (0.5, 4.0)), rate_hz=rate_hz)


def loop(rng: np.random.Generator, rate_hz: int, seconds: float) -> Samples:
    """Return a drum kit that plays a pattern of sixteenths, with ghost notes and fills, with a peak of 1."""
    step_s = 60.0 / between(rng, (70.0, 170.0)) / 4.0
    kit = {
        maker: [maker(np.random.default_rng(seed), rate_hz) for seed in rng.integers(2**62, size=2)] for maker in KIT
    }
    kicks, snares = {0, 8, *rng.integers(0, 16, 2).tolist()}, {4, 12}
    hats = set(range(0, 16, int(pick(rng, (1, 2, 4)))))
    count = round(seconds * rate_hz)
    total = np.zeros(count)
    for step in range(math.ceil(seconds / step_s)):
        at = round((step * step_s + 0.004 * abs(rng.standard_normal())) * rate_hz)
        beat = step % 16
        fill = (step // 16) % 8 == 7 and beat >= 12
        for maker, hit in ((kick, beat in kicks), (snare, beat in snares or fill), (cymbal, beat in hats), (tom, fill)):
            level = between(rng, (0.6, 1.0)) if hit else 0.12 * float(chance(rng, 0.08))
            if level > 0.0 and at < count:
                part = pick(rng, kit[maker]) * level * (0.3 if maker is cymbal else 1.0)
                total[at : at + len(part)] += part[: count - at]
    return normalised(highpass(total, 30.0, rate_hz=rate_hz))


KIT = (kick, snare, cymbal, tom)

"""Shots as textbooks and sound toolkits draw them: a blast wave or a burst of noise, with or without all the rest.

`shots` imitates recordings, with everything that they bring along. Here any of it may be missing: the gas, the tail,
the echoes, the wave itself. So a model learns that a shot rises at once and decays, and does not ask for the richness
of recordings.
"""

import itertools
import math

import numpy as np

from ..units import gain_from_db
from .chance import between, chance, fork, log_between, pick
from .echoes import overlaid
from .plain import sloped_noise
from .tone import Samples, highpass, lowpass, saturate
from .waves import band_burst, boom, friedlander, normalised

_LONGEST_S = 3.0


def plain_shot(rng: np.random.Generator, rate_hz: int) -> tuple[Samples, tuple[int, ...]]:
    """Return one blast or a burst of up to 12, with a peak of 1, and where the blasts begin."""
    kind = pick(rng, (_rich_blast, _bare_blast, _noise_blast, _noise_blast, _banded_blast))
    blast = _finished(rng, kind(rng, rate_hz), rate_hz)
    if chance(rng, 0.7):
        return blast, (0,)
    gap_s = 60.0 / log_between(rng, (400.0, 1_300.0))
    rounds = int(rng.integers(2, 13))
    gaps = gap_s * (1.0 + 0.02 * rng.standard_normal(rounds - 1))
    places = [0, *np.round(np.cumsum(gaps) * rate_hz).astype(int).tolist()]
    levels_db = 1.5 * rng.standard_normal(rounds)
    parts = [(at, blast * gain_from_db(level)) for at, level in zip(places, levels_db.tolist(), strict=True)]
    return normalised(overlaid(parts)), tuple(places)


def _rich_blast(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a blast wave with its bounce off the ground, echoes and a tail of noise."""
    wave = _wave(rng, rate_hz)
    parts = [(0, wave), (round(between(rng, (1.0, 20.0)) * 1e-3 * rate_hz), wave * between(rng, (0.0, 0.8)))]
    parts += _echoes(rng, wave, int(rng.integers(0, 6)), rate_hz)
    tail = _decaying_noise(rng, log_between(rng, (0.1, 2.5)) / math.log(1e3), rate_hz)
    tail = lowpass(tail, log_between(rng, (300.0, 20_000.0)), rate_hz=rate_hz)
    parts.append((round(between(rng, (0.0, 5.0)) * 1e-3 * rate_hz), tail * log_between(rng, (0.003, 0.5))))
    return lowpass(overlaid(parts), log_between(rng, (1_500.0, 22_000.0)), rate_hz=rate_hz, order=pick(rng, (1, 2)))


def _bare_blast(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a blast wave with up to four echoes and nothing else."""
    wave = _wave(rng, rate_hz)
    return overlaid([(0, wave), *_echoes(rng, wave, int(rng.integers(0, 5)), rate_hz)])


def _noise_blast(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return noise that decays from its first sample on, perhaps with a longer body, a low boom and a wave."""
    noise = _decaying_noise(rng, log_between(rng, (0.005, 0.3)), rate_hz)
    if chance(rng, 0.4):
        noise = lowpass(noise, log_between(rng, (1_000.0, 16_000.0)), rate_hz=rate_hz, order=pick(rng, (1, 2)))
    parts = [(0, noise)]
    if chance(rng, 0.4):
        body = lowpass(_decaying_noise(rng, log_between(rng, (0.04, 0.3)), rate_hz), 3_000.0, rate_hz=rate_hz)
        parts.append((0, body * log_between(rng, (0.1, 2.0))))
    if chance(rng, 0.5):
        parts.append((0, _boom(rng, rate_hz) * log_between(rng, (0.2, 3.0))))
    if chance(rng, 0.3):
        parts.append((0, _wave(rng, rate_hz) * log_between(rng, (0.3, 3.0))))
    return _placed(rng, overlaid(parts), rate_hz)


def _banded_blast(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return noise in two to four adjoining bands, the lower the longer it lasts, perhaps over a low boom."""
    edges_hz = np.exp(np.linspace(math.log(log_between(rng, (30.0, 80.0))), math.log(between(rng, (7e3, 2e4))), 5))
    edges_hz[1:-1] *= np.exp(rng.uniform(-0.5, 0.5, 3))
    cuts = [0, *sorted(rng.choice([1, 2, 3], int(rng.integers(1, 4)), replace=False).tolist()), 4]
    longest_s, shorter = log_between(rng, (0.03, 0.3)), log_between(rng, (1.0, 4.0))
    attack_ms, tilt_db = log_between(rng, (0.02, 1.5)), between(rng, (-6.0, 6.0))
    parts = []
    for number, (low, high) in enumerate(itertools.pairwise(cuts)):
        band = band_burst(
            fork(rng),
            rate_hz,
            band_hz=(float(edges_hz[low]), float(edges_hz[high])),
            attack_ms=attack_ms,
            decay_ms=1e3 * longest_s / shorter**number,
        )
        parts.append((0, band * gain_from_db(tilt_db * number + between(rng, (-4.0, 4.0)))))
    if chance(rng, 0.4):
        parts.append((0, _boom(rng, rate_hz) * log_between(rng, (0.3, 3.0))))
    return _placed(rng, overlaid(parts), rate_hz)


def _placed(rng: np.random.Generator, sound: Samples, rate_hz: int) -> Samples:
    """Return a sound as it is, in a room, or with a few echoes."""
    kind = rng.random()
    if kind < 0.3:
        return _in_a_room(rng, sound, rate_hz)
    return overlaid([(0, sound), *_echoes(rng, sound, int(rng.integers(1, 5)), rate_hz)]) if kind < 0.5 else sound


def _finished(rng: np.random.Generator, sound: Samples, rate_hz: int) -> Samples:
    """Return the sound with a peak of 1, at times without its lowest notes, without its highest, or overdriven."""
    if chance(rng, 0.3):
        sound = highpass(sound, log_between(rng, (20.0, 200.0)), rate_hz=rate_hz)
    if chance(rng, 0.3):
        sound = lowpass(sound, log_between(rng, (1_500.0, 20_000.0)), rate_hz=rate_hz, order=pick(rng, (1, 2)))
    sound = normalised(sound)
    return saturate(sound, between(rng, (0.0, 20.0))) if chance(rng, 0.2) else sound


def _wave(rng: np.random.Generator, rate_hz: int) -> Samples:
    rise_ms = pick(rng, (0.0, 0.0, 0.05, 0.2, 0.5))
    return friedlander(rate_hz, positive_ms=log_between(rng, (0.3, 5.0)), rise_ms=rise_ms, decay=between(rng, (0.7, 2)))


def _echoes(rng: np.random.Generator, wave: Samples, count: int, rate_hz: int) -> list[tuple[int, Samples]]:
    """Return echoes with their delays, every second duller than the wave."""
    echoes = []
    for _ in range(count):
        echo = wave * between(rng, (0.05, 0.6))
        if chance(rng, 0.5):
            echo = lowpass(echo, log_between(rng, (1_000.0, 12_000.0)), rate_hz=rate_hz)
        echoes.append((round(log_between(rng, (0.012, 0.4)) * rate_hz), echo))
    return echoes


def _decaying_noise(rng: np.random.Generator, decay_s: float, rate_hz: int) -> Samples:
    """Return noise, white to pink, that falls by e every `decay_s`, or at first faster, with a peak of about 1."""
    frames = round(min(_LONGEST_S, 7.0 * decay_s) * rate_hz)
    noise = fork(rng).standard_normal(frames)
    if chance(rng, 0.3):
        noise = normalised(sloped_noise(fork(rng), frames, between(rng, (-1.2, 0.0)))) * 3.0
    bend = pick(rng, (1.0, 1.0, between(rng, (0.5, 1.0))))
    return np.asarray(noise / 3.0 * np.exp(-((np.arange(frames) / (decay_s * rate_hz)) ** bend)), np.float64)


def _boom(rng: np.random.Generator, rate_hz: int) -> Samples:
    low_hz = log_between(rng, (35.0, 120.0))
    return boom(
        rate_hz,
        start_hz=low_hz * pick(rng, (1.0, between(rng, (1.0, 3.0)))),
        stop_hz=low_hz,
        attack_ms=log_between(rng, (0.02, 5.0)),
        decay_ms=log_between(rng, (30.0, 300.0)),
    )


def _in_a_room(rng: np.random.Generator, sound: Samples, rate_hz: int) -> Samples:
    """Return a sound in a room of noise: an impulse response that decays by 60 dB in 0.2 to 2 s."""
    from scipy.signal import fftconvolve

    response = _decaying_noise(rng, log_between(rng, (0.2, 2.0)) / math.log(1e3), rate_hz)
    response *= log_between(rng, (0.03, 0.3))
    response[: round(log_between(rng, (0.001, 0.02)) * rate_hz)] = 0.0
    response[0] = 1.0
    return np.asarray(fftconvolve(sound, response)[: round(_LONGEST_S * rate_hz)], np.float64)

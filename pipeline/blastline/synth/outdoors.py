"""Guns recorded outdoors, some metres away: a blast, what is struck near by, next to silence, then what comes back.

    pressure = blast + gas jet + arrivals within 20 ms      off the ground, the shooter, the weapon, a bench
             + bolt and case                                tens of milliseconds later and far softer
             + backscatter                                  trees, berms and hills, from 30-200 ms on
    heard    = pressure through the recording chain

A microphone d metres from the muzzle hears the direct sound fall with 1/d, but what returns from afar hardly changes:
near the gun 20 to 60 dB lie between them, and between 20 and 100 ms there is nearly nothing. `shots` draws places as
a film's mix has them, where most is louder than that.
"""

from dataclasses import dataclass

import numpy as np

from ..units import gain_from_db
from .chance import between, chance, fork, log_between, pick
from .colour import draw_colour, record
from .echoes import overlaid
from .tone import Samples, highpass, lowpass, saturate, tilt, trimmed
from .waves import NoiseBurst, friedlander, n_wave, normalised

_ROUNDS_PER_MINUTE = (420.0, 1_300.0)


@dataclass(frozen=True)
class _Arrival:
    """The blast again, so many samples later, by another way."""

    after: int
    gain: float
    corner_hz: float


@dataclass(frozen=True, eq=False)
class _Gun:
    """What the rounds of one gun at one place share."""

    blast: Samples
    arrivals: tuple[_Arrival, ...]
    jet: NoiseBurst
    clicks: tuple[NoiseBurst, ...]
    returns: tuple[NoiseBurst, ...]


def outdoor_shot(rng: np.random.Generator, rate_hz: int) -> tuple[Samples, tuple[int, ...], tuple[int, ...]]:
    """Return one shot or a burst of up to 20 rounds, with a peak of 1, and where the rounds' blasts begin.

    The last is where the first bullet's shock begins, which may be taken for its shot: one place, or none.
    """
    gun = _gun(fork(rng), rate_hz)
    rounds = 1 if chance(rng, 0.55) else int(rng.integers(2, 21))
    gap = 60.0 / log_between(rng, _ROUNDS_PER_MINUTE) * rate_hz
    gaps = gap * (1.0 + pick(rng, (0.003, 0.01, 0.04)) * rng.standard_normal(rounds - 1))
    places = np.round(np.concatenate([[0.0], np.cumsum(gaps)])).astype(int).tolist()
    spread_db = pick(rng, (0.3, 1.0, 2.0))
    parts = [
        (at, _fired(fork(rng), rate_hz, gun) * gain_from_db(spread_db * float(rng.standard_normal()))) for at in places
    ]
    before = _crack(rng, rate_hz) if chance(rng, 0.1) else np.zeros(0)
    whole = overlaid([(len(before) + at, part) for at, part in parts] + [(0, before)])
    return _recorded(rng, whole, rate_hz), tuple(len(before) + at for at in places), (0,) if len(before) else ()


def _gun(rng: np.random.Generator, rate_hz: int) -> _Gun:
    rise_ms = pick(rng, (0.0, log_between(rng, (0.02, 0.5))))
    blast = friedlander(
        rate_hz, positive_ms=log_between(rng, (0.2, 4.0)), rise_ms=rise_ms, decay=log_between(rng, (0.6, 2.5))
    )
    arrivals = tuple(
        _Arrival(
            round(log_between(rng, (0.25, 22.0)) * 1e-3 * rate_hz),
            between(rng, (-0.7, 0.9)),
            log_between(rng, (2e3, 2e4)),
        )
        for _ in range(int(rng.integers(0, 7)))
    )
    jet = NoiseBurst(
        after=0,
        gain=gain_from_db(between(rng, (-24.0, 8.0))),
        attack_ms=log_between(rng, (0.05, 6.0)),
        decay_ms=log_between(rng, (0.6, 9.0)),
        band_hz=(log_between(rng, (60.0, 1_200.0)), log_between(rng, (2_000.0, 18_000.0))),
    )
    clicks = tuple(_click(rng, rate_hz) for _ in range(int(rng.integers(0, 5))))
    return _Gun(blast, arrivals, jet, clicks, _returns(rng, rate_hz))


def _click(rng: np.random.Generator, rate_hz: int) -> NoiseBurst:
    after, level_db = round(between(rng, (0.006, 0.075)) * rate_hz), between(rng, (-60.0, -22.0))
    centre_hz, decay_ms = log_between(rng, (800.0, 9_000.0)), log_between(rng, (0.5, 12.0))
    return NoiseBurst(after, gain_from_db(level_db), 0.1, decay_ms, (0.6 * centre_hz, 1.6 * centre_hz))


def _returns(rng: np.random.Generator, rate_hz: int) -> tuple[NoiseBurst, ...]:
    """Return what comes back.

    Grass, people and a bench scatter at once and for tens of milliseconds, what is far up to six times later.
    """

    def one(after_s: float, level_db: float, attack_ms: float, decay_ms: float) -> NoiseBurst:
        low_hz = log_between(rng, (60.0, 700.0))
        band_hz = low_hz, low_hz * log_between(rng, (2.5, 30.0))
        return NoiseBurst(round(after_s * rate_hz), gain_from_db(level_db), attack_ms, decay_ms, band_hz)

    found = []
    if chance(rng, 0.7):
        near = between(rng, (0.001, 0.02)), between(rng, (-38.0, -8.0))
        found.append(one(*near, log_between(rng, (1.0, 15.0)), log_between(rng, (6.0, 45.0))))
    loudest_db, first_s = between(rng, (-52.0, -10.0)), log_between(rng, (0.03, 0.2))
    for number in range(0 if chance(rng, 0.08) else int(rng.integers(1, 6))):
        far = first_s + number * between(rng, (0.0, 0.15)), loudest_db - between(rng, (0.0, 6.0)) * number
        found.append(one(*far, log_between(rng, (2.0, 90.0)), log_between(rng, (15.0, 350.0))))
    return tuple(found)


def _fired(rng: np.random.Generator, rate_hz: int, gun: _Gun) -> Samples:
    """Return a round: the gas and what scatters it are never the same twice, the geometry is."""
    jet = gun.jet.made(rng, rate_hz) * gain_from_db(between(rng, (-2.0, 2.0)))
    direct = normalised(overlaid([(0, gun.blast), (0, jet)]))
    parts = [(0, direct)]
    parts += [(way.after, lowpass(direct, way.corner_hz, rate_hz=rate_hz) * way.gain) for way in gun.arrivals]
    for click in gun.clicks:
        sound = click.made(rng, rate_hz)
        parts.append((click.after + int(0.003 * rate_hz * rng.random()), sound))
    parts += [(each.after, each.made(rng, rate_hz)) for each in gun.returns]
    return overlaid(parts)


def _crack(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return the bullet's shock and the time until the blast: a microphone down the range hears it first."""
    wave = n_wave(rate_hz, length_ms=between(rng, (0.15, 0.5)), rise_ms=log_between(rng, (0.005, 0.1)))
    lead = np.zeros(round(log_between(rng, (0.008, 0.25)) * rate_hz))
    return overlaid([(0, wave * gain_from_db(between(rng, (-20.0, 3.0)))), (0, lead)])


def _recorded(rng: np.random.Generator, sound: Samples, rate_hz: int) -> Samples:
    """Return the sound as a field recorder kept it: overloaded in one of three, its bass cut or not, then edited."""
    sound = normalised(sound)
    if chance(rng, 0.35):
        sound = saturate(sound, between(rng, (3.0, 24.0)))
    if chance(rng, 0.5):
        corner_hz = log_between(rng, (4.0, 500.0))
        sound = highpass(sound, corner_hz, rate_hz=rate_hz, order=pick(rng, (1, 1, 2)))
    if chance(rng, 0.5):
        sound = tilt(sound, between(rng, (-12.0, 12.0)), pivot_hz=log_between(rng, (300.0, 5_000.0)), rate_hz=rate_hz)
    if chance(rng, 0.3):
        sound = lowpass(sound, log_between(rng, (2_500.0, 16_000.0)), rate_hz=rate_hz, order=pick(rng, (1, 2)))
    if chance(rng, 0.25):
        sound = record(sound, draw_colour(rng), rate_hz=rate_hz)
    sound = trimmed(sound, floor=1e-4)
    return normalised(sound)

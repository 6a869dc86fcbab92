"""Guns whose jet of gas is louder than their blast wave, fired once, twice, in bursts, and again after a rest.

    round  = wave (half of the silenced guns have none) + thump (of every other gun) + jet + action + tail
    firing = single | two, 60-450 ms apart | burst | two to five of these, up to 2 s apart
    heard  = firing in a place, through a recording chain

A jet takes up to some milliseconds to reach its peak. It is noise, as are action and tail, and never the same twice, so
that the rounds are less alike than those whose wave is louder. Other families have a gun fire once or in one burst; a
scene has it fire again, so that its rounds come for seconds, as a machine's blows do.
"""

from dataclasses import dataclass

import numpy as np

from ..units import gain_from_db
from .chance import between, chance, fork, log_between, pick
from .colour import draw_colour, record
from .echoes import overlaid, with_acoustics
from .rooms import ENVIRONMENTS, draw_acoustics
from .tone import Samples, highpass, lowpass, saturate
from .waves import NoiseBurst, boom, friedlander, normalised

_LONGEST_S = 6.0
_ROUNDS_PER_MINUTE = (420.0, 1_250.0)


@dataclass(frozen=True, eq=False)
class _Gun:
    """What all rounds of a gun share."""

    fixed: Samples
    noises: tuple[NoiseBurst, ...]


def jet_shot(rng: np.random.Generator, rate_hz: int) -> tuple[Samples, tuple[int, ...]]:
    """Return a gun that is fired once or more, for up to six seconds, with a peak of 1, and where its rounds begin."""
    silenced = chance(rng, 0.35)
    gun = _silenced_gun(fork(rng), rate_hz) if silenced else _open_gun(fork(rng), rate_hz)
    places = [round(second * rate_hz) for second in _firing_s(rng)]
    spread_db = pick(rng, (0.3, 1.0, 2.0))
    rounds = [
        (at, _round(fork(rng), rate_hz, gun) * gain_from_db(spread_db * float(rng.standard_normal()))) for at in places
    ]
    return _heard(rng, overlaid(rounds), rate_hz), tuple(places)


def _firing_s(rng: np.random.Generator) -> list[float]:
    """Return the seconds at which the rounds of a single shot, a pair, a burst or several of them begin."""
    groups = pick(rng, (1, 1, 1, int(rng.integers(2, 6))))
    gap_s, begun_s, places = 60.0 / log_between(rng, _ROUNDS_PER_MINUTE), 0.0, [0.0]
    for number in range(groups):
        kind = rng.random()
        if number:
            begun_s = places[-1] + log_between(rng, (0.25, 2.0))
            places.append(begun_s)
        if kind < 0.35:
            places.append(begun_s + log_between(rng, (0.06, 0.45)))
        elif kind < 0.65:
            rounds = int(rng.integers(2, 13))
            gaps_s = gap_s * (1.0 + pick(rng, (0.003, 0.01, 0.04)) * rng.standard_normal(rounds - 1))
            places += (begun_s + np.cumsum(gaps_s)).tolist()
    return [place for place in places if place < _LONGEST_S - 1.0]


def _open_gun(rng: np.random.Generator, rate_hz: int) -> _Gun:
    wave = friedlander(
        rate_hz, positive_ms=log_between(rng, (0.2, 3.0)), rise_ms=pick(rng, (0.0, 0.1)), decay=between(rng, (0.7, 2.0))
    )
    jet = NoiseBurst(
        after=round(pick(rng, (0.0, between(rng, (0.0, 1.0)))) * 1e-3 * rate_hz),
        gain=log_between(rng, (0.3, 5.0)),
        attack_ms=log_between(rng, (0.1, 5.0)),
        decay_ms=log_between(rng, (1.5, 25.0)),
        band_hz=(log_between(rng, (50.0, 900.0)), log_between(rng, (2_500.0, 18_000.0))),
    )
    return _Gun(_with_thump(rng, wave, rate_hz), (jet, *_action(rng, rate_hz, (-45.0, -12.0)), _tail(rng, rate_hz)))


def _silenced_gun(rng: np.random.Generator, rate_hz: int) -> _Gun:
    """Return a gun with a silencer: mostly noise, often without lows, and its action is heard beside it."""
    wave = np.zeros(1)
    if chance(rng, 0.5):
        wave = friedlander(rate_hz, positive_ms=log_between(rng, (0.3, 3.0)), rise_ms=log_between(rng, (0.1, 1.5)))
        wave = lowpass(wave, log_between(rng, (500.0, 6_000.0)), rate_hz=rate_hz) * log_between(rng, (0.1, 1.0))
    low_hz = log_between(rng, (80.0, 1_600.0))
    jet = NoiseBurst(
        after=0,
        gain=1.0,
        attack_ms=log_between(rng, (0.05, 3.0)),
        decay_ms=log_between(rng, (3.0, 45.0)),
        band_hz=(low_hz, min(16_000.0, low_hz * log_between(rng, (4.0, 60.0)))),
    )
    return _Gun(_with_thump(rng, wave, rate_hz), (jet, *_action(rng, rate_hz, (-30.0, -2.0)), _tail(rng, rate_hz)))


def _with_thump(rng: np.random.Generator, wave: Samples, rate_hz: int) -> Samples:
    """Return the wave, half of the time over the low thump of a room, a chest or a bench."""
    if chance(rng, 0.5):
        return wave
    thump = boom(
        rate_hz,
        start_hz=log_between(rng, (80.0, 400.0)),
        stop_hz=log_between(rng, (45.0, 160.0)),
        attack_ms=log_between(rng, (0.2, 4.0)),
        decay_ms=log_between(rng, (12.0, 90.0)),
    )
    return overlaid([(0, wave), (0, thump * log_between(rng, (0.1, 1.5)))])


def _action(rng: np.random.Generator, rate_hz: int, level_db: tuple[float, float]) -> list[NoiseBurst]:
    """Return the slide or the bolt, going back and home: up to three clacks within 90 ms."""
    clacks = []
    for _ in range(int(rng.integers(0, 4))):
        centre_hz = log_between(rng, (700.0, 8_000.0))
        after, gain = round(between(rng, (0.008, 0.09)) * rate_hz), gain_from_db(between(rng, level_db))
        clacks.append(NoiseBurst(after, gain, 0.1, log_between(rng, (0.7, 12.0)), (0.6 * centre_hz, 1.6 * centre_hz)))
    return clacks


def _tail(rng: np.random.Generator, rate_hz: int) -> NoiseBurst:
    low_hz = log_between(rng, (50.0, 500.0))
    after, gain = round(between(rng, (0.0, 0.05)) * rate_hz), gain_from_db(between(rng, (-45.0, -8.0)))
    attack_ms, decay_ms = log_between(rng, (0.5, 40.0)), log_between(rng, (25.0, 350.0))
    return NoiseBurst(after, gain, attack_ms, decay_ms, (low_hz, low_hz * log_between(rng, (3.0, 40.0))))


def _round(rng: np.random.Generator, rate_hz: int, gun: _Gun) -> Samples:
    """Return a round: its noise is never the same twice."""
    return overlaid([(0, gun.fixed), *((each.after, each.made(rng, rate_hz)) for each in gun.noises)])


def _heard(rng: np.random.Generator, sound: Samples, rate_hz: int) -> Samples:
    """Return the sound in a place or without one, overdriven, filtered or recorded, as a film may have it."""
    sound = normalised(sound)
    if chance(rng, 0.2):
        sound = saturate(sound, between(rng, (0.0, 15.0)))
    if chance(rng, 0.4):
        sound, _ = with_acoustics(rng, sound, draw_acoustics(rng, pick(rng, ENVIRONMENTS)), rate_hz=rate_hz)
        if chance(rng, 0.3):
            sound = saturate(normalised(sound), between(rng, (6.0, 24.0)))
    if chance(rng, 0.3):
        sound = lowpass(sound, log_between(rng, (1_500.0, 16_000.0)), rate_hz=rate_hz, order=pick(rng, (1, 2)))
    if chance(rng, 0.3):
        sound = highpass(sound, log_between(rng, (20.0, 300.0)), rate_hz=rate_hz)
    if chance(rng, 0.3):
        sound = record(sound, draw_colour(rng), rate_hz=rate_hz)
    return normalised(sound[: round(_LONGEST_S * rate_hz)])

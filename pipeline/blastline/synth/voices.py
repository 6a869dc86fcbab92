"""What the shots of one burst share: the weapon, the place and the recording chain, drawn from the widest family."""

import math
from dataclasses import dataclass, replace

import numpy as np

from ..units import SILENCE_DB
from .chance import between, chance, log_between
from .colour import CLEAN, Colour, draw_colour
from .images import SPEED_OF_SOUND_M_S
from .rooms import Acoustics, Environment, draw_acoustics
from .weapons import WEAPONS, WeaponName

MECHANICS_WITHIN_M = 25.0
"""Beyond this distance nobody hears a bolt."""

SHOCK_BEYOND_M = 15.0


@dataclass(frozen=True)
class Shock:
    """The ballistic N-wave: how much earlier than the blast it passes, and its shape."""

    lead_s: float
    level_db: float
    length_ms: float
    rise_ms: float


@dataclass(frozen=True)
class Mechanism:
    """A noise of bolt, hammer or magazine: when it comes after the onset (negative: before), how loud, how bright."""

    at_s: float
    level_db: float
    centre_hz: float
    decay_ms: float


@dataclass(frozen=True)
class Roar:
    """What swells behind the blast in most recordings: turbulent gas, scatter from everything near, added layers."""

    level_db: float
    attack_ms: float
    decay_ms: float
    band_hz: tuple[float, float]


@dataclass(frozen=True)
class Boom:
    """The low tone that a sound designer lays under the shot."""

    level_db: float
    start_hz: float
    stop_hz: float
    attack_ms: float
    decay_ms: float


@dataclass(frozen=True)
class Voice:
    """One weapon fired at one place and recorded in one way; levels in dB are against the peak of the blast."""

    weapon: WeaponName
    environment: Environment
    acoustics: Acoustics
    colour: Colour
    positive_ms: float
    rise_ms: float
    decay: float
    jet_db: float
    jet_decay_ms: float
    jet_band_hz: tuple[float, float]
    muffle: float
    second_pulse: tuple[float, float] | None = None
    mechanisms: tuple[Mechanism, ...] = ()
    shock: Shock | None = None
    boom: Boom | None = None
    roars: tuple[Roar, ...] = ()


def draw_voice(
    rng: np.random.Generator,
    weapon: WeaponName,
    *,
    environment: Environment,
    distance_m: float | None = None,
    clean: bool = False,
) -> Voice:
    """Return a random weapon of its kind at a random place of its kind.

    `clean` records with a measuring microphone in plain air: no sound design, no dynamics, no muffling.
    """
    kind = WEAPONS[weapon]
    acoustics = draw_acoustics(rng, environment, distance_m=distance_m)
    far_m = max(acoustics.distance_m, 1.0)
    shocked = chance(rng, kind.supersonic) and far_m > SHOCK_BEYOND_M
    voice = Voice(
        weapon=weapon,
        environment=environment,
        acoustics=acoustics,
        colour=draw_colour(rng),
        # a blast wave grows longer and its front thicker as it travels
        positive_ms=log_between(rng, kind.positive_ms) * (1.0 + 0.12 * math.log(far_m)),
        rise_ms=min(2.0, log_between(rng, kind.rise_ms) + 0.0012 * far_m * rng.random()),
        decay=log_between(rng, (0.6, 2.5)),
        jet_db=between(rng, kind.jet_db) if chance(rng, 0.85) else SILENCE_DB,
        jet_decay_ms=log_between(rng, kind.jet_decay_ms),
        jet_band_hz=(log_between(rng, (100.0, 1_500.0)), log_between(rng, (2_500.0, 16_000.0))),
        muffle=1.0 if chance(rng, 0.6) else between(rng, kind.muffle),
        second_pulse=(log_between(rng, (0.3, 25.0)), between(rng, (-18.0, 3.0))) if chance(rng, 0.35) else None,
        mechanisms=_draw_mechanisms(rng, kind.mechanics_db) if far_m < MECHANICS_WITHIN_M else (),
        shock=_draw_shock(rng, far_m) if shocked else None,
        boom=_draw_boom(rng) if chance(rng, 0.35) else None,
        roars=_draw_roars(rng),
    )
    if not clean:
        return voice
    return replace(voice, colour=CLEAN, muffle=1.0, mechanisms=(), shock=None, boom=None, roars=())


def varied(rng: np.random.Generator, voice: Voice) -> Voice:
    """Return the voice as it sounds this time: charge, angle and gas flow differ from shot to shot."""
    return replace(
        voice,
        positive_ms=voice.positive_ms * between(rng, (0.92, 1.08)),
        rise_ms=voice.rise_ms * between(rng, (0.9, 1.1)),
        jet_db=voice.jet_db + between(rng, (-2.0, 2.0)),
        jet_decay_ms=voice.jet_decay_ms * between(rng, (0.8, 1.25)),
    )


def _draw_shock(rng: np.random.Generator, far_m: float) -> Shock:
    """Return the N-wave of a bullet that passes near by: it outruns the blast over most of the way.

    At Mach M the lead is up to (d / c)(1 - 1/M); a bullet that passes at a distance leads by less.
    """
    mach = between(rng, (1.15, 2.6))
    return Shock(
        lead_s=min(0.9, far_m / SPEED_OF_SOUND_M_S * (1.0 - 1.0 / mach) * between(rng, (0.3, 1.0))),
        level_db=between(rng, (-16.0, 8.0)),
        length_ms=between(rng, (0.2, 0.5)),
        rise_ms=log_between(rng, (0.005, 0.1)),
    )


def _draw_mechanisms(rng: np.random.Generator, level_db: tuple[float, float]) -> tuple[Mechanism, ...]:
    def one(at_s: float) -> Mechanism:
        return Mechanism(
            at_s, between(rng, level_db), log_between(rng, (900.0, 9_000.0)), log_between(rng, (0.5, 12.0))
        )

    after = [one(between(rng, (0.010, 0.090))) for _ in range(rng.integers(0, 4))]
    before = [one(-between(rng, (0.008, 0.030)))] if chance(rng, 0.15) else []
    return tuple(sorted(before + after, key=lambda mechanism: mechanism.at_s))


def _draw_roars(rng: np.random.Generator) -> tuple[Roar, ...]:
    """Return up to two; real recordings reach their peak 2-20 ms after the onset more often than at it."""

    def one() -> Roar:
        low_hz = log_between(rng, (25.0, 1_500.0))
        return Roar(
            level_db=between(rng, (-10.0, 12.0)),
            attack_ms=log_between(rng, (0.4, 40.0)),
            decay_ms=log_between(rng, (4.0, 110.0)),
            band_hz=(low_hz, min(16_000.0, low_hz * log_between(rng, (3.0, 100.0)))),
        )

    return tuple(one() for _ in range(int(rng.choice(3, p=(0.2, 0.45, 0.35)))))


def _draw_boom(rng: np.random.Generator) -> Boom:
    stop_hz = between(rng, (32.0, 85.0))
    return Boom(
        level_db=between(rng, (-26.0, 0.0)),
        start_hz=stop_hz * between(rng, (1.0, 2.5)),
        stop_hz=stop_hz,
        attack_ms=log_between(rng, (1.0, 25.0)),
        decay_ms=log_between(rng, (25.0, 400.0)),
    )

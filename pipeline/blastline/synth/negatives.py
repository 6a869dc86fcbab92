"""Hard negatives: short, loud and sudden sounds that are no shots, put into places and recorded as shots are."""

from collections.abc import Callable
from functools import partial
from typing import Literal, get_args

import numpy as np

from .bangs import crash, explosion, firework, punch, spark, splash, thunder, whip, whoosh
from .chance import chance, fork, log_between, pick
from .colour import CLEAN, air, draw_colour, record
from .cries import bark, clipped_speech, cough, shout
from .drums import applause, clap, cymbal, kick, roll, snare, tom
from .echoes import with_acoustics
from .impacts import MATERIALS, draw_body, struck
from .knocks import door, drop, glass, hammer, hammering, knock, metal, snap, weapon_handling
from .machines import jackhammer, machine, mill, motor, nail_gun, ratchet, rotor, typewriter
from .music import bell, stinger
from .rooms import ENVIRONMENTS, draw_acoustics
from .steps import footsteps, hooves
from .tone import Samples, peak, trimmed
from .waves import noise_burst

NegativeKind = Literal[
    "applause", "bark", "bell", "clap", "click", "clipped-speech", "cough", "crash", "cymbal", "door", "drop",
    "drum-roll", "explosion", "firework", "footsteps", "glass", "hammer", "hammering", "handling", "hooves", "impact",
    "jackhammer", "kick", "knock", "machine", "metal", "mill", "motor", "nail-gun", "punch", "ratchet", "rotor",
    "shout", "snap", "snare", "spark", "splash", "stinger", "thunder-far", "thunder-near",
    "tom", "typewriter", "whip", "whoosh",
]  # fmt: skip

AMBIGUOUS: tuple[NegativeKind, ...] = ("explosion",)
"""What a 4D designer may well want to move: labelled, but scored neither as a shot nor as a false alarm."""

NEGATIVE_KINDS: tuple[NegativeKind, ...] = tuple(kind for kind in get_args(NegativeKind) if kind not in AMBIGUOUS)


def click(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a click of a machine: one to a few samples, a step that leaks away, or a tick of noise below 2 ms."""
    if chance(rng, 0.3):
        return np.asarray(np.exp(-np.arange(rate_hz // 20) / (0.005 * rate_hz * rng.random() + 1.0)), dtype=np.float64)
    if chance(rng, 0.5):
        return noise_burst(fork(rng), rate_hz, attack_ms=0.01, decay_ms=log_between(rng, (0.04, 0.7)))
    return np.asarray(rng.choice([-1.0, 1.0], int(rng.integers(1, 9))), dtype=np.float64)


def impact(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return one blow on anything."""
    return struck(fork(rng), rate_hz, draw_body(rng, pick(rng, MATERIALS)))


_MAKERS: dict[NegativeKind, Callable[[np.random.Generator, int], Samples]] = {
    "applause": applause,
    "bark": bark,
    "bell": bell,
    "clap": clap,
    "click": click,
    "clipped-speech": clipped_speech,
    "cough": cough,
    "crash": crash,
    "cymbal": cymbal,
    "door": door,
    "drop": drop,
    "drum-roll": roll,
    "explosion": explosion,
    "firework": firework,
    "footsteps": footsteps,
    "glass": glass,
    "hammer": hammer,
    "hammering": hammering,
    "handling": weapon_handling,
    "hooves": hooves,
    "impact": impact,
    "jackhammer": jackhammer,
    "kick": kick,
    "knock": knock,
    "machine": machine,
    "metal": metal,
    "mill": mill,
    "motor": motor,
    "nail-gun": nail_gun,
    "punch": punch,
    "ratchet": ratchet,
    "rotor": rotor,
    "shout": shout,
    "snap": snap,
    "snare": snare,
    "spark": spark,
    "splash": splash,
    "stinger": stinger,
    "thunder-far": partial(thunder, near=False),
    "thunder-near": partial(thunder, near=True),
    "tom": tom,
    "typewriter": typewriter,
    "whip": whip,
    "whoosh": whoosh,
}

_BY_ITSELF: tuple[NegativeKind, ...] = ("click", "thunder-far", "thunder-near")
"""Clicks arise in the machine, and thunder brings its own distance."""


def random_negative(rng: np.random.Generator, rate_hz: int, kind: NegativeKind | None = None) -> tuple[Samples, int]:
    """Return a negative of the given kind, or of any but the ambiguous, with a peak of 1, and where it starts."""
    chosen: NegativeKind = pick(rng, NEGATIVE_KINDS) if kind is None else kind
    sound = _MAKERS[chosen](fork(rng), rate_hz)
    # a phrase may begin with the silence before a plosive
    sound = sound[int(np.argmax(sound != 0.0)) :]
    if chosen not in _BY_ITSELF and chance(rng, 0.75):
        environment = pick(rng, ENVIRONMENTS[:-1] if chance(rng, 0.9) else ENVIRONMENTS)
        acoustics = draw_acoustics(rng, environment)
        sound, _ = with_acoustics(
            fork(rng), air(sound, acoustics.distance_m, rate_hz=rate_hz), acoustics, rate_hz=rate_hz
        )
    sound = record(sound, CLEAN if chosen == "click" and chance(rng, 0.5) else draw_colour(rng), rate_hz=rate_hz)
    sound = trimmed(sound)
    return sound / peak(sound), 0

"""Automatic fire that stays automatic fire: every shot stands out of what the ones before it still sound.

In recordings of bursts a shot's first 5 ms peak 8 dB (one in twenty) to 40 dB over the 25 ms before it, half of them
over 25 dB; drawn at random, long tails and slow roars would melt a burst into one noise that nobody calls a burst.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..units import db_from_gain, samples_from_ms, samples_from_s
from .chance import fork
from .shots import fire
from .tone import peak
from .voices import Voice

MARGIN_DB = (8.0, 26.0)
"""Between these a burst's least margin is drawn."""

ATTACK_MS, BEFORE_MS, GUARD_MS = 5.0, 25.0, 1.0
_TRIAL_RATE_HZ = 24_000  # always the same, so that a scene keeps its sounds at every rate
_TRIAL_SHOTS = 6
_MOST_STEPS = 12


def stands_out_db(samples: NDArray[np.floating], at: int, *, rate_hz: int) -> float:
    """Return how far the 5 ms from a place on peak over the 25 ms before it, in dB.

    In the waveform or its first difference, whichever shows it more.
    """
    first = max(0, at - samples_from_ms(BEFORE_MS, rate_hz))
    heard = samples[first : at + samples_from_ms(ATTACK_MS, rate_hz)]
    lead = max(0, at - first - samples_from_ms(GUARD_MS, rate_hz))
    waves = (heard, np.diff(heard, prepend=heard[:1]))
    return max(db_from_gain(peak(wave[at - first :])) - db_from_gain(peak(wave[:lead])) for wave in waves)


def told_apart(rng: np.random.Generator, voice: Voice, *, spacing_s: float, margin_db: float) -> Voice:
    """Return the voice damped, where it must be, until its shots stand out of each other by the margin.

    What leads a blast, a bullet's shock or a bolt, is no part of the trial: it announces the shot and hides nothing.
    """
    spacing = samples_from_s(spacing_s, _TRIAL_RATE_HZ)
    for _ in range(_MOST_STEPS):
        behind = tuple(part for part in voice.mechanisms if part.at_s >= 0.0)
        sound, _ = fire(fork(rng), _TRIAL_RATE_HZ, replace(voice, shock=None, mechanisms=behind))
        burst = np.zeros(_TRIAL_SHOTS * spacing)
        for number in range(_TRIAL_SHOTS):
            part = sound[: len(burst) - number * spacing]
            burst[number * spacing :][: len(part)] += part
        if stands_out_db(burst, (_TRIAL_SHOTS - 1) * spacing, rate_hz=_TRIAL_RATE_HZ) >= margin_db:
            break
        voice = _damped(voice)
    return voice


def _damped(voice: Voice) -> Voice:
    """Return the voice in a drier place, nearer the microphone, under thinner layers."""
    acoustics = voice.acoustics
    tail = acoustics.tail
    if tail is not None:
        tail = replace(tail, level_db=tail.level_db - 4.0, low_s=0.85 * tail.low_s, high_s=0.85 * tail.high_s)
    echoes = tuple(replace(echo, gain=0.7 * echo.gain) for echo in acoustics.echoes)
    roars = tuple(
        replace(roar, level_db=roar.level_db - 3.0, attack_ms=0.8 * roar.attack_ms, decay_ms=0.75 * roar.decay_ms)
        for roar in voice.roars
    )
    boom = voice.boom
    if boom is not None:
        boom = replace(boom, level_db=boom.level_db - 3.0, decay_ms=0.75 * boom.decay_ms)
    mechanisms = tuple(replace(part, level_db=part.level_db - 2.0) for part in voice.mechanisms)
    acoustics = replace(acoustics, echoes=echoes, tail=tail)
    return replace(voice, acoustics=acoustics, roars=roars, boom=boom, mechanisms=mechanisms)

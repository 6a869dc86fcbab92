"""One recording made into many: at other speeds, repeated, in other places, by other microphones and recorders.

There are a hundred recordings of guns to learn from, and thousands of films to be right on. What changes here is what
differs from film to film, and it changes alike for guns and for everything else.
"""

from dataclasses import replace
from fractions import Fraction

import numpy as np

from ..synth import ENVIRONMENTS, draw_acoustics, draw_colour, record, with_acoustics
from .mixes import Samples, Sound

SPEEDS = (0.8, 1.25)
ROUNDS_PER_MINUTE = (350.0, 1_300.0)
BLOWS_PER_MINUTE = (80.0, 1_300.0)
ROUND_S = 0.7
LEAD_S = 0.02
"""What is kept before the first round: nothing of it may be cut."""


def varied(sound: Sound, rng: np.random.Generator, rate_hz: int) -> Sound:
    """Return a variant of a recorded sound, its onsets where they come to lie; silence stays as it is."""
    if not sound.samples.any():
        return sound
    if rng.random() < 0.6:
        sound = at_speed(sound, rng.uniform(*SPEEDS))
    if rng.random() < 0.2:
        sound = repeated(sound, rng, rate_hz)
    samples = sound.samples
    if rng.random() < 0.3:
        acoustics = draw_acoustics(rng, ENVIRONMENTS[int(rng.integers(len(ENVIRONMENTS)))])
        samples, _ = with_acoustics(rng, samples, acoustics, rate_hz=rate_hz)
    if rng.random() < 0.6:
        samples = record(samples, draw_colour(rng), rate_hz=rate_hz)
    return replace(sound, samples=samples)


def at_speed(sound: Sound, speed: float) -> Sound:
    """Return the sound played faster, and so higher, or slower; the speed is rounded to a ratio of small numbers."""
    from scipy.signal import resample_poly

    ratio = Fraction(speed).limit_denominator(20)
    samples = resample_poly(sound.samples, ratio.denominator, ratio.numerator)
    onsets, unsure = (tuple(round(at / ratio) for at in places) for places in (sound.onsets, sound.unsure))
    return Sound(np.asarray(samples, np.float64), onsets, unsure)


def repeated(sound: Sound, rng: np.random.Generator, rate_hz: int) -> Sound:
    """Return the first round of a sound again and again, as loops of automatic fire, of steps and of blows are made.

    A round that is still sounding when the next one comes goes on beneath it.
    """
    first = sound.onsets[0] if sound.onsets else int(np.argmax(np.abs(sound.samples)))
    start = max(0, first - round(LEAD_S * rate_hz))
    stop = min([first + round(ROUND_S * rate_hz), sound.samples.shape[0], *sound.onsets[1:2]])
    one = sound.samples[start:stop] * np.linspace(1.0, 0.0, stop - start) ** rng.uniform(0.3, 2.0)
    low, high = ROUNDS_PER_MINUTE if sound.onsets else BLOWS_PER_MINUTE
    apart = 60.0 / (low * (high / low) ** rng.random()) * rate_hz
    gaps = apart * (1.0 + 0.02 * rng.standard_normal(int(rng.integers(1, 20))))
    places = np.round(np.concatenate([[0.0], np.cumsum(gaps)])).astype(np.intp)
    row: Samples = np.zeros(int(places[-1]) + one.shape[0])
    for place, level_db in zip(places.tolist(), 1.5 * rng.standard_normal(places.size), strict=True):
        row[place : place + one.shape[0]] += one * 10.0 ** (level_db / 20.0)
    return Sound(row, tuple(first - start + place for place in places.tolist()) if sound.onsets else ())

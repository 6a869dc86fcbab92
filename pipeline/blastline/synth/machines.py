"""Machines that beat time: drills, presses, rotors, motors, ratchets and mills. Like automatic fire they keep a pace.

parts of one turn, each with its own blow --> again and again, a little uneven --> swelling as it comes and goes
"""

import numpy as np

from ..units import gains_from_db
from .chance import between, chance, fork, log_between, pick
from .echoes import overlaid
from .impacts import MATERIALS, draw_body, series, struck
from .knocks import paced
from .noises import coloured, levelled, slow
from .tone import Samples, lowpass, resonance, saturate
from .waves import band_burst, boom, n_wave, normalised


def jackhammer(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a pneumatic drill: 8-30 blows a second with exhaust noise, for 0.5-6 seconds; some are one blow copied."""
    body = draw_body(rng, pick(rng, ("stone", "metal", "sheet", "earth")))
    exhaust = (log_between(rng, (60.0, 500.0)), log_between(rng, (1_000.0, 8_000.0)))
    attack_ms, decay_ms = log_between(rng, (0.3, 5.0)), log_between(rng, (5.0, 40.0))
    share = log_between(rng, (0.1, 2.0))
    blows = []
    for _ in range(pick(rng, (1, 6))):
        puff = band_burst(fork(rng), rate_hz, band_hz=exhaust, attack_ms=attack_ms, decay_ms=decay_ms)
        blow = struck(fork(rng), rate_hz, body)[: round(0.3 * rate_hz)]
        blows.append(normalised(overlaid([(0, blow), (0, puff * share)])))
    pace_hz = between(rng, (8.0, 30.0))
    return _going(rng, blows, pace_hz=pace_hz, seconds=log_between(rng, (0.5, 6.0)), jitter=0.02, rate_hz=rate_hz)


def machine(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a press, a loom or a train on its joints: two alternating blows at an even beat, for 2-7 seconds."""
    first, second = (draw_body(rng, pick(rng, ("metal", "sheet", "wood", "plastic"))) for _ in range(2))
    blows = [struck(fork(rng), rate_hz, body) for body in (first, second, first, second)]
    beat = log_between(rng, (0.06, 0.8))
    uneven = between(rng, (0.3, 0.5))
    count = max(3, round(between(rng, (2.0, 7.0)) / beat))
    gaps = np.where(np.arange(count) % 2 == 0, 2.0 * uneven, 2.0 - 2.0 * uneven) * beat
    return series(rng, blows, gaps_s=gaps, levels_db=0.8, rate_hz=rate_hz)


def rotor(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a helicopter or a propeller: each blade slaps the air, 8-28 times a second, over rush and whine.

    A slap is the wave of a vortex that the next blade cuts (an N-wave of some milliseconds) and a puff of noise.
    Blades differ a little, so the pattern comes again with each turn.
    """
    low_hz = log_between(rng, (30.0, 300.0))
    band_hz = (low_hz, low_hz * log_between(rng, (4.0, 40.0)))
    attack_ms, decay_ms = log_between(rng, (0.3, 12.0)), log_between(rng, (6.0, 40.0))
    length_ms, rise_ms = log_between(rng, (2.0, 14.0)), log_between(rng, (0.1, 3.0))
    slap, drive_db = between(rng, (0.0, 1.0)), pick(rng, (0.0, between(rng, (0.0, 25.0))))
    blades = []
    for _ in range(int(rng.integers(2, 7))):
        puff = band_burst(fork(rng), rate_hz, band_hz=band_hz, attack_ms=attack_ms, decay_ms=decay_ms)
        wave = n_wave(rate_hz, length_ms=length_ms * between(rng, (0.9, 1.1)), rise_ms=rise_ms)
        blades.append(
            normalised(overlaid([(0, puff * (1.0 - slap)), (round(0.5e-3 * attack_ms * rate_hz), wave * slap)]))
        )
    sound = _going(
        rng,
        blades,
        pace_hz=between(rng, (8.0, 28.0)),
        seconds=log_between(rng, (0.8, 7.0)),
        jitter=0.004,
        rate_hz=rate_hz,
    )
    rush = coloured(fork(rng), len(sound), slope=between(rng, (0.5, 2.0)), rate_hz=rate_hz)
    whine = resonance(
        fork(rng).standard_normal(len(sound)), log_between(rng, (300.0, 5_000.0)), bandwidth_hz=8.0, rate_hz=rate_hz
    )
    beneath = levelled(rush) + between(rng, (0.0, 1.0)) * levelled(whine)
    return normalised(saturate(normalised(sound + log_between(rng, (0.003, 0.15)) * beneath), drive_db))


def motor(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return an idling diesel, a motorcycle or a pump: cylinders of a few kinds that fire 6-30 times a second.

    Each is a thump through the exhaust's resonances and the knock of the valves.
    """
    pipes_hz = [log_between(rng, (50.0, 900.0)) for _ in range(3)]
    valves = draw_body(rng, pick(rng, ("metal", "sheet")))
    knocking = log_between(rng, (0.02, 1.0))
    strokes = []
    for _ in range(pick(rng, (1, 2, 3, 4, 6))):
        thump = boom(
            rate_hz,
            start_hz=pipes_hz[0],
            stop_hz=0.6 * pipes_hz[0],
            attack_ms=log_between(rng, (0.5, 6.0)),
            decay_ms=log_between(rng, (8.0, 40.0)),
        )
        noise = band_burst(
            fork(rng), rate_hz, band_hz=(40.0, log_between(rng, (800.0, 6_000.0))), attack_ms=1.0, decay_ms=10.0
        )
        puff = sum((resonance(noise, hz, bandwidth_hz=0.3 * hz, rate_hz=rate_hz) for hz in pipes_hz), noise * 0.2)
        knock = struck(fork(rng), rate_hz, valves)[: round(0.08 * rate_hz)]
        strokes.append(normalised(overlaid([(0, thump), (0, normalised(puff)), (0, knock * knocking)])))
    jitter = log_between(rng, (0.005, 0.08))
    sound = _going(
        rng,
        strokes,
        pace_hz=log_between(rng, (6.0, 30.0)),
        seconds=log_between(rng, (0.6, 6.0)),
        jitter=jitter,
        rate_hz=rate_hz,
    )
    return normalised(lowpass(sound, log_between(rng, (700.0, 12_000.0)), rate_hz=rate_hz))


def ratchet(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a lift, a chain, a winch or a toothed wheel: clacks of a thing that is struck 3-18 times a second."""
    body = draw_body(rng, pick(rng, MATERIALS))
    hardness = log_between(rng, (0.5, 3.0))
    length = round(log_between(rng, (0.03, 0.4)) * rate_hz)
    clacks = [struck(fork(rng), rate_hz, body, hardness=hardness)[:length] for _ in range(pick(rng, (1, 1, 3, 8)))]
    jitter = pick(rng, (0.0, 0.005, 0.03))
    pace_hz, seconds = log_between(rng, (3.0, 18.0)), log_between(rng, (0.4, 4.0))
    return _going(rng, clacks, pace_hz=pace_hz, seconds=seconds, jitter=jitter, rate_hz=rate_hz)


def mill(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return a windmill, a water wheel or a gate: heavy wood that thuds 1-4 times a second and groans between.

    The groan is stick and slip: a row of small slips, whose pace wanders, rings in the beams.
    """
    beams = draw_body(rng, pick(rng, ("wood", "wood", "sheet", "earth")))
    thuds = [struck(fork(rng), rate_hz, beams, hardness=between(rng, (0.5, 2.0))) for _ in range(pick(rng, (1, 2, 4)))]
    seconds = log_between(rng, (1.0, 6.0))
    sound = _going(rng, thuds, pace_hz=log_between(rng, (1.0, 4.0)), seconds=seconds, jitter=0.03, rate_hz=rate_hz)
    pitch_hz = log_between(rng, (12.0, 160.0)) * slow(fork(rng), len(sound), step_s=0.4, depth_db=2.0, rate_hz=rate_hz)
    phase = np.cumsum(pitch_hz) / rate_hz
    slips = np.diff(np.floor(phase), prepend=0.0) * fork(rng).uniform(0.3, 1.0, len(sound))
    centre_hz = log_between(rng, (200.0, 1_800.0))
    groan = resonance(slips, centre_hz, bandwidth_hz=0.3 * centre_hz, rate_hz=rate_hz)
    groan = normalised(groan * slow(fork(rng), len(sound), step_s=0.3, depth_db=10.0, rate_hz=rate_hz))
    return normalised(sound + log_between(rng, (0.02, 0.8)) * groan)


def nail_gun(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return 1-4 shots of a pneumatic nailer: the piston's blow on wood, then air that hisses out for 50-200 ms."""
    work = draw_body(rng, "wood")
    blows = []
    for _ in range(3):
        air = band_burst(
            fork(rng),
            rate_hz,
            band_hz=(log_between(rng, (600.0, 2_000.0)), 10_000.0),
            attack_ms=between(rng, (5.0, 25.0)),
            decay_ms=between(rng, (20.0, 80.0)),
        )
        hit = struck(fork(rng), rate_hz, work, hardness=2.0)
        blows.append(
            overlaid([(0, hit), (round(between(rng, (0.004, 0.03)) * rate_hz), air * between(rng, (0.15, 0.6)))])
        )
    return series(rng, blows, gaps_s=paced(rng, (0, 3), (0.3, 1.2), 0.2), levels_db=1.0, rate_hz=rate_hz)


def typewriter(rng: np.random.Generator, rate_hz: int) -> Samples:
    """Return 3-25 keystrokes: a key, a type bar on paper and platen."""
    body = draw_body(rng, pick(rng, ("plastic", "metal")))
    blows = [struck(fork(rng), rate_hz, body, hardness=2.0)[: round(0.15 * rate_hz)] for _ in range(5)]
    return series(rng, blows, gaps_s=paced(rng, (2, 24), (0.07, 0.3), 0.4), levels_db=3.0, rate_hz=rate_hz)


def _going(
    rng: np.random.Generator, blows: list[Samples], *, pace_hz: float, seconds: float, jitter: float, rate_hz: int
) -> Samples:
    """Return blows in turn at a pace for so many seconds, in half the cases coming nearer or going away."""
    count = max(2, round(seconds * pace_hz))
    gaps = np.abs(1.0 + jitter * rng.standard_normal(count)) / pace_hz
    sound = series(rng, blows, gaps_s=gaps, levels_db=between(rng, (0.0, 2.0)), rate_hz=rate_hz)
    if chance(rng, 0.5):
        swell_db = between(rng, (3.0, 30.0)) * np.abs(np.linspace(-1.0, 1.0, len(sound)) - between(rng, (-1.0, 1.0)))
        sound = normalised(sound * gains_from_db(-swell_db))
    return sound

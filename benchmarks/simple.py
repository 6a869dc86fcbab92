"""Shots that a few lines of code make, and decoys: `python benchmarks/simple.py`, how many are believed.

Films of a minute with some 16 single sounds each, over four beds and at two levels. None of these sounds is of the
families that the verifier has learnt from (`blastline.synth`): they are made here, in other ways, for nothing but to
see whether what was learnt goes beyond them.
"""

from argparse import ArgumentParser
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, firwin, lfilter, oaconvolve, sosfilt

from blastline.detect import Verifier, find_shots, load_verifier
from blastline.model import Clip, Quality
from blastline.ruleset import QualityRules, load_rules, rules_path

Samples = NDArray[np.float64]
Maker = Callable[[np.random.Generator], Samples]

RATE_HZ = 44_100
FILM_S, WITHIN_MS = 60.0, 10.0
LEVELS_DB = (18.0, 32.0)  # peak over the bed's rms


@dataclass(frozen=True)
class Count:
    """Of the sounds of one kind: how many there were, how many were taken for shots, and how late in ms."""

    sounds: int
    believed: int
    late_ms: tuple[float, ...]


def envelope(seconds: float, *, attack_ms: float, decay_ms: float, power: float = 1.0) -> Samples:
    """Return a straight rise and an exponential fall, stretched by a power."""
    ms = np.arange(round(seconds * RATE_HZ)) * 1e3 / RATE_HZ
    fall = np.exp(-((np.maximum(ms - attack_ms, 0.0) / decay_ms) ** power))
    return np.asarray(np.minimum(ms / attack_ms, 1.0) * fall, np.float64)


def burst(
    rng: np.random.Generator,
    *,
    decay_ms: float,
    attack_ms: float = 0.2,
    band_hz: tuple[float, float] | None = None,
    power: float = 1.0,
) -> Samples:
    """Return white noise, or a band of it, under an envelope."""
    shape = envelope(0.01 * decay_ms + 0.1, attack_ms=attack_ms, decay_ms=decay_ms, power=power)
    noise = rng.standard_normal(len(shape) + 254)
    if band_hz is None:
        return np.asarray(noise[254:] * shape, np.float64)
    taps = firwin(255, band_hz, pass_zero=False, fs=RATE_HZ)
    return np.asarray(np.convolve(noise, taps, "valid") * shape, np.float64)


def tone(from_hz: float, to_hz: float, *, decay_ms: float) -> Samples:
    """Return a decaying sine that falls from one frequency to another within some 20 ms."""
    seconds = np.arange(round(0.006 * decay_ms * RATE_HZ)) / RATE_HZ
    hz = to_hz + (from_hz - to_hz) * np.exp(-seconds / 0.02)
    return np.asarray(np.sin(2.0 * np.pi * np.cumsum(hz) / RATE_HZ) * np.exp(-seconds * 1e3 / decay_ms), np.float64)


def wave(positive_ms: float) -> Samples:
    """Return a blast wave (Friedlander 1946)."""
    phase = np.arange(round(0.012 * positive_ms * RATE_HZ)) * 1e3 / RATE_HZ / positive_ms
    return np.asarray((1.0 - phase) * np.exp(-phase), np.float64)


def together(*parts: tuple[float, Samples]) -> Samples:
    """Return sounds that begin after so many milliseconds each, as one."""
    starts = [round(late_ms * RATE_HZ / 1e3) for late_ms, _ in parts]
    total = np.zeros(max(start + len(part) for start, (_, part) in zip(starts, parts, strict=True)))
    for start, (_, part) in zip(starts, parts, strict=True):
        total[start : start + len(part)] += part
    return total


def echoed(rng: np.random.Generator, sound: Samples) -> Samples:
    """Return a sound with three echoes, each weaker than the one before."""
    late_ms = np.array([45.0, 110.0, 190.0]) * rng.uniform(0.8, 1.2, 3)
    gains = (0.4, 0.25, 0.15)
    return together((0.0, sound), *((late, gain * sound) for late, gain in zip(late_ms, gains, strict=True)))


def in_a_hall(rng: np.random.Generator, sound: Samples) -> Samples:
    """Return a sound in a hall of decaying noise."""
    response = 0.02 * burst(rng, decay_ms=rng.uniform(100.0, 350.0), attack_ms=0.01)
    response[0] = 1.0
    return np.asarray(oaconvolve(sound, response), np.float64)


SHOTS: dict[str, Maker] = {
    "blast wave": lambda rng: wave(rng.uniform(0.8, 4.0)),
    "blast wave, echoes": lambda rng: echoed(rng, wave(rng.uniform(0.8, 4.0))),
    "blast wave in a hall": lambda rng: in_a_hall(rng, wave(rng.uniform(0.8, 3.0))),
    "blast wave, noise": lambda rng: together((0, wave(2.0)), (0, 0.1 * burst(rng, decay_ms=rng.uniform(20, 200)))),
    "white noise": lambda rng: burst(rng, decay_ms=rng.uniform(15.0, 100.0)),
    "noise that lingers": lambda rng: burst(rng, decay_ms=rng.uniform(10.0, 50.0), power=0.6),
    "noise, slow attack": lambda rng: burst(rng, decay_ms=rng.uniform(20.0, 80.0), attack_ms=3.0),
    "dull noise": lambda rng: lowpassed(burst(rng, decay_ms=rng.uniform(30.0, 150.0)), rng.uniform(900.0, 3000.0)),
    "noise in a hall": lambda rng: in_a_hall(rng, burst(rng, decay_ms=rng.uniform(10.0, 40.0))),
    "noise and boom": lambda rng: together(
        (0, burst(rng, decay_ms=rng.uniform(10.0, 60.0))), (0, 2.0 * tone(60.0, 60.0, decay_ms=120.0))
    ),
    "snap and falling boom": lambda rng: together(
        (0, burst(rng, decay_ms=15.0)), (0, 1.2 * tone(150.0, 45.0, decay_ms=120.0))
    ),
    "three bands": lambda rng: together(
        (0, 4.0 * burst(rng, decay_ms=120.0, band_hz=(40.0, 250.0))),
        (0, 1.5 * burst(rng, decay_ms=50.0, band_hz=(250.0, 2500.0))),
        (0, burst(rng, decay_ms=12.0, band_hz=(2500.0, 15000.0))),
    ),
}

DECOYS: dict[str, Maker] = {
    "clap": lambda rng: together(
        *((late, burst(rng, decay_ms=8.0, band_hz=(900.0, 3000.0))) for late in (0.0, 9.0, 20.0))
    ),
    "kick": lambda rng: tone(rng.uniform(120.0, 250.0), 50.0, decay_ms=100.0),
    "snare": lambda rng: together(
        (0, 0.5 * tone(220.0, 190.0, decay_ms=60.0)), (0, burst(rng, decay_ms=70.0, band_hz=(1500.0, 12000.0)))
    ),
    "hi-hat": lambda rng: burst(rng, decay_ms=rng.uniform(15.0, 60.0), band_hz=(6000.0, 16000.0)),
    "door": lambda rng: together(
        (0, lowpassed(burst(rng, decay_ms=50.0, attack_ms=4.0), 350.0)), (0, 0.3 * tone(90.0, 80.0, decay_ms=80.0))
    ),
    "knock": lambda rng: together((0, tone(400.0, 380.0, decay_ms=20.0)), (0, 0.4 * tone(950.0, 900.0, decay_ms=12.0))),
    "click": lambda rng: np.ones(int(rng.integers(1, 6))),
    "bell": lambda rng: together(*((0.0, tone(hz, hz, decay_ms=400.0)) for hz in (700.0, 1130.0, 1720.0, 2400.0))),
    "swell": lambda rng: burst(rng, decay_ms=200.0, attack_ms=150.0),
    "plosive": lambda rng: lowpassed(burst(rng, decay_ms=30.0, attack_ms=12.0), 700.0),
    "pluck": lambda rng: together(*((0.0, tone(196.0 * n, 196.0 * n, decay_ms=400.0 / n) / n) for n in range(1, 8))),
    "step": lambda rng: step(rng, rng.uniform(300.0, 1500.0), sole=0.0),
    "step of a shoe": lambda rng: step(rng, rng.uniform(300.0, 1500.0), sole=0.3),
    "heel and toe": lambda rng: together(
        (0, step(rng, rng.uniform(300.0, 1000.0), sole=0.3)),
        (rng.uniform(30.0, 120.0), 0.5 * step(rng, rng.uniform(800.0, 1500.0), sole=0.2)),
    ),
    "stomp": lambda rng: together(
        (0, step(rng, rng.uniform(200.0, 800.0), sole=0.2, decay_ms=45.0)), (0, 0.5 * tone(90.0, 60.0, decay_ms=60.0))
    ),
}


def step(rng: np.random.Generator, corner_hz: float, *, sole: float, decay_ms: float = 20.0) -> Samples:
    """Return a dull thud that rises within some milliseconds, and by how much of it a sole slaps."""
    rise_ms = rng.uniform(2.0, 10.0)
    frames = round(0.01 * decay_ms * RATE_HZ)
    ms = np.arange(frames) * 1e3 / RATE_HZ
    soft = (1.0 - np.exp(-ms / rise_ms)) * np.exp(-ms / decay_ms)
    thud = soft * lowpassed(rng.standard_normal(frames), corner_hz)
    slap = burst(rng, decay_ms=10.0, band_hz=(500.0, 4000.0))
    return together((0, thud / np.abs(thud).max()), (0, sole * slap / np.abs(slap).max()))


def lowpassed(sound: Samples, corner_hz: float) -> Samples:
    """Return a sound without its highs."""
    return np.asarray(sosfilt(butter(2, corner_hz, fs=RATE_HZ, output="sos"), sound), np.float64)


def hum(rng: np.random.Generator, frames: int) -> Samples:
    """Return noise that loses 6 dB an octave."""
    return np.asarray(lfilter([0.02], [1.0, -0.98], rng.standard_normal(frames)), np.float64)


def chords(rng: np.random.Generator, frames: int) -> Samples:
    """Return six tones that swell and fade."""
    seconds = np.arange(frames) / RATE_HZ
    total = 0.02 * rng.standard_normal(frames)
    for hz in rng.choice([110.0, 146.8, 196.0, 246.9, 329.6, 440.0, 587.0, 880.0], 6, replace=False):
        swelling = 0.6 + 0.4 * np.sin(2.0 * np.pi * rng.uniform(0.2, 2.0) * seconds)
        total += swelling * np.sin(2.0 * np.pi * hz * seconds)
    return total


def babble(rng: np.random.Generator, frames: int) -> Samples:
    """Return noise of a voice's band that comes in syllables."""
    seconds = np.arange(frames) / RATE_HZ
    voice = np.convolve(hum(rng, frames), firwin(255, (150.0, 4000.0), pass_zero=False, fs=RATE_HZ), "same")
    return np.asarray(voice * (np.sin(2.0 * np.pi * 2.2 * seconds + np.sin(seconds)) ** 2 + 0.05), np.float64)


BEDS: dict[str, Callable[[np.random.Generator, int], Samples]] = {
    "noise": lambda rng, frames: rng.standard_normal(frames),
    "hum": hum,
    "chords": chords,
    "babble": babble,
}


def film_of(make: Maker, bed: Samples, level_db: float, rng: np.random.Generator) -> tuple[Samples, list[int]]:
    """Return a bed with sounds some 3 to 4.5 s apart, at most 6 dB below the level over the bed, and their places."""
    film = bed * 0.6 * 10.0 ** (-level_db / 20.0) / np.sqrt(np.mean(bed**2))
    places_s = np.arange(2.0, FILM_S - 2.0, rng.uniform(3.0, 4.5))
    places = np.round((places_s + rng.uniform(-0.7, 0.7, len(places_s))) * RATE_HZ).astype(int).tolist()
    for at in places:
        sound = make(rng)[: len(film) - at]
        gain = 0.6 * 10.0 ** (rng.uniform(-6.0, 0.0) / 20.0) / np.abs(sound).max()
        film[at : at + len(sound)] += sound * gain
    return film, places


def count(kind: str, make: Maker, tier: QualityRules, verifier: Verifier) -> Count:
    """Return how many sounds of a kind are taken for shots, over every bed and at every level."""
    frames, sounds, late_ms = round(FILM_S * RATE_HZ), 0, []
    for name, make_bed in BEDS.items():
        for level_db in LEVELS_DB:
            rng = np.random.default_rng([*f"{kind} {name}".encode(), round(level_db)])
            film, places = film_of(make, make_bed(rng, frames), level_db, rng)
            clip = Clip(film[:, None].astype(np.float32), RATE_HZ)
            found = [shot.onset for shot in find_shots([clip], rate_hz=RATE_HZ, tier=tier, verifier=verifier).shots]
            offsets_ms = [min((abs(at - each) for each in found), default=frames) * 1e3 / RATE_HZ for at in places]
            sounds += len(places)
            late_ms += [each for each in offsets_ms if each < WITHIN_MS]
    return Count(sounds, len(late_ms), tuple(late_ms))


def main() -> None:
    """Write the tables."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--quality", choices=get_args(Quality), default="standard")
    parser.add_argument("--verifier", type=Path, default=rules_path("verifier/shots.json"), metavar="FILE")
    options = parser.parse_args()
    tier = load_rules(options.quality).tier
    verifier = load_verifier(options.verifier, networks=tier.verify.networks)
    for name, makers in (("shots", SHOTS), ("decoys", DECOYS)):
        total, believed = 0, 0
        print(f"{name:<24}{'sounds':>8}{'believed':>10}{'share':>8}{'off by, median':>17}")
        for kind, make in makers.items():
            each = count(kind, make, tier, verifier)
            off = f"{np.median(each.late_ms):14.2f} ms" if each.late_ms else f"{'-':>17}"
            print(f"{kind:<24}{each.sounds:8}{each.believed:10}{each.believed / each.sounds:8.2f}{off}")
            total, believed = total + each.sounds, believed + each.believed
        print(f"{'all':<24}{total:8}{believed:10}{believed / total:8.2f}\n")


if __name__ == "__main__":
    main()

"""Simple sounds in a row: `python benchmarks/bursts.py`, how many rounds and second shots, and blasts after cracks.

The shots of `simple.py` as automatic fire of 450 to 1200 rounds a minute: the rounds of a burst are one sound, each
with noise of its own, up to 1.5 dB louder or softer and up to 2 % of the gap early or late. Double shots are made in
the same way. Then blasts that come some milliseconds after the crack of their bullet, an N-wave: found is what begins
with either.
"""

from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from typing import get_args

import numpy as np
from simple import BEDS, RATE_HZ, SHOTS, WITHIN_MS, Maker, Samples, together

from blastline.detect import Verifier, find_shots, verifier_of
from blastline.model import Clip, Quality
from blastline.ruleset import QualityRules, load_rules

RPM = (450, 600, 750, 900, 1050, 1200)
ROUNDS, LONG = (3, 5, 8, 12, 20), (30, 40, 60, 100)
GUNS = ("white noise", "noise that lingers", "noise in a hall", "noise and boom", "dull noise", "blast wave in a hall")
PAIR_GAPS_MS, PAIRS = (40, 50, 60, 80, 100, 150), 6
CRACK_EARLY_MS = (3, 5, 7, 8, 9, 10, 11, 12, 13, 16, 25)
REST_S, LEVEL_DB, PEAK = 3.2, 24.0, 0.4


def burst_of(rng: np.random.Generator, gun: Samples, rounds: int, gap_s: float) -> list[tuple[float, Samples]]:
    """Return the rounds of a burst, each after so many seconds."""
    fired = []
    for number in range(rounds):
        own = gun + 0.5 * np.abs(gun) * rng.standard_normal(gun.size)
        at_s = max(0.0, number * gap_s + rng.uniform(-0.02, 0.02) * gap_s)
        fired.append((at_s, own / np.abs(own).max() * 10.0 ** (rng.uniform(-1.5, 1.5) / 20.0)))
    return fired


def film_of(
    rng: np.random.Generator, bed: str, scenes: Sequence[Sequence[tuple[float, Samples]]]
) -> tuple[Samples, list[list[int]]]:
    """Return scenes of sounds one after the other over a bed, and the places of the sounds of each."""
    lasting_s = [max(at_s for at_s, _ in scene) + REST_S for scene in scenes]
    frames = round((sum(lasting_s) + 4.0) * RATE_HZ)
    film = BEDS[bed](rng, frames)
    film *= PEAK * 10.0 ** (-LEVEL_DB / 20.0) / np.sqrt(np.mean(film**2))
    places: list[list[int]] = []
    begin_s = 2.0
    for scene, length_s in zip(scenes, lasting_s, strict=True):
        places.append([round((begin_s + at_s) * RATE_HZ) for at_s, _ in scene])
        for at, (_, sound) in zip(places[-1], scene, strict=True):
            film[at : at + sound.size] += PEAK * sound[: frames - at]
        begin_s += length_s
    return film / max(1.0, float(np.abs(film).max())), places


def found_in(film: Samples, tier: QualityRules, verifier: Verifier) -> list[int]:
    """Return where a film's shots begin."""
    clip = Clip(film[:, None].astype(np.float32), RATE_HZ)
    return [shot.onset for shot in find_shots([clip], rate_hz=RATE_HZ, tier=tier, verifier=verifier).shots]


def near(at: int, places: Sequence[int]) -> bool:
    """Return whether one of the places is near enough."""
    return any(abs(at - each) * 1e3 / RATE_HZ < WITHIN_MS for each in places)


def bursts(lengths: Sequence[int], tier: QualityRules, verifier: Verifier) -> Iterator[str]:
    """Yield the rows of the table of bursts of so many rounds."""
    told = f"{lengths[0]} to {lengths[-1]} rounds, a minute"
    yield f"{told:<24}{'rounds':>8}{'found':>8}{'share':>8}{'exact bursts':>14}{'others':>8}"
    for rpm in RPM:
        rounds = found = exact = counted = others = 0
        for kind in GUNS:
            for bed in BEDS:
                rng = np.random.default_rng([*f"{kind} {bed}".encode(), rpm])
                guns = [SHOTS[kind](rng) for _ in lengths]
                scenes = [
                    burst_of(rng, gun / np.abs(gun).max(), number, 60.0 / rpm)
                    for gun, number in zip(guns, lengths, strict=True)
                ]
                film, places = film_of(rng, bed, scenes)
                heard = found_in(film, tier, verifier)
                for burst in places:
                    own = [each for each in heard if burst[0] - RATE_HZ // 50 <= each <= burst[-1] + RATE_HZ // 20]
                    rounds, counted = rounds + len(burst), counted + 1
                    found += sum(near(at, own) for at in burst)
                    exact += len(own) == len(burst)
                every = [at for burst in places for at in burst]
                others += sum(not near(each, every) for each in heard)
        yield f"{rpm:<24}{rounds:8}{found:8}{found / rounds:8.2f}{exact / counted:14.2f}{others:8}"


def pairs(tier: QualityRules, verifier: Verifier) -> Iterator[str]:
    """Yield the rows of the table of double shots."""
    yield f"{'second shot after, ms':<24}{'pairs':>8}{'first':>8}{'second':>8}{'others':>8}"
    for gap_ms in PAIR_GAPS_MS:
        fired, first, second, others = 0, 0, 0, 0
        for kind in GUNS:
            for bed in BEDS:
                rng = np.random.default_rng([*f"{kind} {bed}".encode(), gap_ms])
                guns = [SHOTS[kind](rng) for _ in range(PAIRS)]
                film, places = film_of(
                    rng, bed, [burst_of(rng, gun / np.abs(gun).max(), 2, 1e-3 * gap_ms) for gun in guns]
                )
                heard = found_in(film, tier, verifier)
                fired += len(places)
                first += sum(near(pair[0], heard) for pair in places)
                second += sum(near(pair[1], heard) for pair in places)
                others += sum(not near(each, [at for pair in places for at in pair]) for each in heard)
        yield f"{gap_ms:<24}{fired:8}{first:8}{second:8}{others:8}"


def cracks(tier: QualityRules, verifier: Verifier) -> Iterator[str]:
    """Yield the rows of the table of cracks."""
    yield f"{'crack before, ms':<24}{'shots':>8}{'found':>8}{'share':>8}"
    makers: tuple[Maker, ...] = (SHOTS["blast wave, noise"], SHOTS["blast wave in a hall"], SHOTS["noise in a hall"])
    for early_ms in CRACK_EARLY_MS:
        shots = found = 0
        for bed in BEDS:
            rng = np.random.default_rng([*bed.encode(), early_ms])
            scenes = []
            for make in makers * 3:
                blast = make(rng)
                crack = 1.4 * np.linspace(1.0, -1.0, round(rng.uniform(0.0002, 0.0004) * RATE_HZ))
                scenes.append([(0.0, together((0.0, crack), (early_ms, blast / np.abs(blast).max())))])
            film, places = film_of(rng, bed, scenes)
            heard = found_in(film, tier, verifier)
            shots += len(places)
            late = round(early_ms * RATE_HZ / 1e3)
            found += sum(any(near(at, heard) for at in (begin, begin + late)) for (begin,) in places)
        yield f"{early_ms:<24}{shots:8}{found:8}{found / shots:8.2f}"


def main() -> None:
    """Write the tables."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--quality", choices=get_args(Quality), default="standard")
    options = parser.parse_args()
    tier = load_rules(options.quality).tier
    verifier = verifier_of(tier)
    tables = bursts(ROUNDS, tier, verifier), bursts(LONG, tier, verifier), pairs(tier, verifier), cracks(tier, verifier)
    for table in tables:
        for row in table:
            print(row, flush=True)
        print()


if __name__ == "__main__":
    main()

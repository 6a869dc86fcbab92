"""Hard cuts from scene to scene that are taken for shots: `python benchmarks/cuts.py [--quality TIER] [--films 60]`.

Films of fifteen scenes of four seconds without a gun, each of one bed at a level of its own, with nothing between one
and the next. The second figure is what would be taken for a shot if nothing were refused for going on
(`least_fall_db` 0).
"""

from argparse import ArgumentParser
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import pairwise
from typing import get_args

import msgspec
import numpy as np
from numpy.typing import NDArray

from blastline.detect import find_shots, verifier_of
from blastline.model import Clip, Quality
from blastline.ruleset import load_rules
from blastline.synth import BED_KINDS, random_bed

Samples = NDArray[np.float64]

RATE_HZ = 48_000
SCENES, SCENE_S, WITHIN_MS = 15, 4.0, 10.0
LEVELS_DBFS = (-50.0, -14.0)
NOISES = ("white noise", "pink noise")


def scene(rng: np.random.Generator, kind: str) -> Samples:
    """Return a scene of one sound, at an rms of 1."""
    frames = round(SCENE_S * RATE_HZ)
    if kind in NOISES:
        spectrum = np.fft.rfft(rng.standard_normal(frames))
        slope = np.sqrt(np.maximum(np.arange(len(spectrum)), 20.0)) if kind == "pink noise" else 1.0
        sound = np.fft.irfft(spectrum / slope, frames)
    else:
        sound = random_bed(rng, RATE_HZ, SCENE_S, next(each for each in BED_KINDS if each == kind))[:frames]
    return np.asarray(sound / np.sqrt(np.mean(sound**2)), np.float64)


def film(seed: int) -> tuple[Samples, list[tuple[str, bool]]]:
    """Return a film, and of each cut what comes, and whether that is louder."""
    rng = np.random.default_rng(seed)
    kinds = [str(kind) for kind in rng.choice([*BED_KINDS, *NOISES], SCENES)]
    levels_dbfs = rng.uniform(*LEVELS_DBFS, SCENES)
    scenes = [10.0 ** (level / 20.0) * scene(rng, kind) for kind, level in zip(kinds, levels_dbfs, strict=True)]
    louder = [bool(after > before) for before, after in pairwise(levels_dbfs)]
    return np.concatenate(scenes), list(zip(kinds[1:], louder, strict=True))


def believed(quality: Quality, seed: int) -> tuple[Counter[str], list[Counter[str]]]:
    """Return how many cuts to something louder there are of each kind, and how many are believed as is and without."""
    samples, cuts = film(seed)
    tier = load_rules(quality).tier
    verifier = verifier_of(tier)
    blocks = [Clip(np.clip(samples, -1.0, 1.0).astype(np.float32)[:, None], RATE_HZ, 0)]
    counts = []
    for least_fall_db in (tier.verify.least_fall_db, 0.0):
        verify = msgspec.structs.replace(tier.verify, least_fall_db=least_fall_db)
        asked = msgspec.structs.replace(tier, verify=verify)
        found = find_shots(blocks, rate_hz=RATE_HZ, tier=asked, verifier=verifier)
        onsets_ms = np.array([shot.onset for shot in found.shots]) * 1e3 / RATE_HZ
        at_cut = [bool((abs(onsets_ms - 1e3 * n * SCENE_S) <= WITHIN_MS).any()) for n in range(1, SCENES)]
        counts.append(Counter(kind for (kind, up), is_there in zip(cuts, at_cut, strict=True) if up and is_there))
    return Counter(kind for kind, up in cuts if up), counts


def main() -> None:
    """Run from the command line."""
    parser = ArgumentParser(description="Hard cuts that are taken for shots.")
    parser.add_argument("--quality", choices=get_args(Quality), default="standard")
    parser.add_argument("--films", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with ProcessPoolExecutor() as pool:
        seeds = range(1_000 * options.seed, 1_000 * options.seed + options.films)
        heard = list(pool.map(partial(believed, options.quality), seeds))
    cuts = sum((each for each, _ in heard), Counter())
    now, without = (sum((counts[place] for _, counts in heard), Counter()) for place in (0, 1))
    print(f"{options.quality}: cuts to louder sound, taken for a shot, and if nothing were refused for going on")
    for kind in sorted(cuts):
        print(f"{kind:14s} {cuts[kind]:5d} {now[kind]:5d} {without[kind]:5d}")
    print(f"{'all':14s} {cuts.total():5d} {now.total():5d} {without.total():5d}")


if __name__ == "__main__":
    main()

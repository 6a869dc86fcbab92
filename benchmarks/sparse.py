"""False alarms in sparse films without a gun: `python benchmarks/sparse.py [--quality TIER] [--seed N] [--films N]`.

Minutes with 3 to 17 other sounds each, as the lessons named sparse-gun-free are made, from seeds that no training comes
to. At an explosion what is found counts neither way.
"""

from argparse import ArgumentParser
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import get_args

import numpy as np

from blastline.detect import find_shots, verifier_of
from blastline.model import Clip, Quality
from blastline.ruleset import load_rules
from blastline.study.film_lessons import SPARSE, gun_free_film
from blastline.study.mixes import RATE_HZ

WITHIN_MS = 10.0


def believed(quality: Quality, seed: int, number: int) -> int:
    """Return how many sounds of a film are taken for shots."""
    tier = load_rules(quality).tier
    film = gun_free_film(seed, SPARSE)(number)
    shots = find_shots(
        [Clip(film.samples[:, None], RATE_HZ)], rate_hz=RATE_HZ, tier=tier, verifier=verifier_of(tier)
    ).shots
    onsets = np.array([shot.onset for shot in shots], np.intp)
    near = np.abs(onsets[:, None] - film.unsure[None, :]) * 1000.0 / RATE_HZ <= WITHIN_MS
    return int(onsets.size - near.any(axis=1).sum())


def main() -> None:
    """Write how many are believed, and in how many films."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quality", choices=get_args(Quality), default="standard")
    parser.add_argument("--seed", type=int, default=9600)
    parser.add_argument("--films", type=int, default=120)
    options = parser.parse_args()
    with ProcessPoolExecutor() as pool:
        false = list(pool.map(partial(believed, options.quality, options.seed), range(options.films)))
    wrong = sum(each > 0 for each in false)
    print(f"{options.quality}: {sum(false)} false alarms in {options.films} minutes, in {wrong} of the films")


if __name__ == "__main__":
    main()

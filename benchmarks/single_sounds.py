"""What is believed of a corpus's sounds one by one: `python benchmarks/single_sounds.py CORPUS [CORPUS ...]`.

Each corpus has `annotations.csv`, as `game_sounds.py` writes it. Every gun is heard at eight levels over four made
beds, every other sound once, 6 to 36 dB over one, twelve of them a minute and 4 s of each at most.
"""

import csv
import tempfile
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import get_args

import numpy as np
import soundfile
from numpy.typing import NDArray

from blastline.detect import verifier_of
from blastline.model import Quality
from blastline.ruleset import load_rules
from blastline.study.cost import listened
from blastline.synth import random_bed

Samples = NDArray[np.float64]

RATE_HZ, SECONDS = 48_000, 60.0
LEVELS_DB = (10, 14, 18, 22, 26, 30, 34, 38)
BEDS, BED_DBFS, OTHERS_A_FILM, LONGEST_S, WITHIN_MS = 4, -46.0, 12, 4.0, 10.0


@dataclass(frozen=True)
class Sound:
    """A sound, where it begins in the film, its level over the bed, and the true onsets of a gun within it."""

    path: Path
    at_s: float
    level_db: float
    onsets_s: tuple[float, ...] = ()


def films(corpus: Path) -> Iterator[tuple[int, tuple[Sound, ...]]]:
    """Yield the films of a corpus: the seed of the bed, and the sounds."""
    with (corpus / "annotations.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    for row in (row for row in rows if row["label"] == "gunshot"):
        onsets_s = tuple(float(onset) for onset in row["onsets_s"].split(";"))
        for bed in range(BEDS):
            path, apart_s = corpus / row["path"], SECONDS / len(LEVELS_DB)
            yield bed, tuple(Sound(path, 1.0 + apart_s * n, db, onsets_s) for n, db in enumerate(LEVELS_DB))
    others = [corpus / row["path"] for row in rows if row["label"] != "gunshot"]
    rng = np.random.default_rng(len(others))
    for first in range(0, len(others), OTHERS_A_FILM):
        some = others[first : first + OTHERS_A_FILM]
        apart_s = SECONDS / OTHERS_A_FILM
        yield first, tuple(Sound(path, 0.3 + apart_s * n, rng.uniform(6.0, 36.0)) for n, path in enumerate(some))


def made(seed: int, sounds: Sequence[Sound]) -> Samples:
    """Return the sound of a film."""
    film = np.asarray(random_bed(np.random.default_rng(seed), RATE_HZ, SECONDS)[: int(SECONDS * RATE_HZ)], np.float64)
    film *= 10.0 ** (BED_DBFS / 20.0) / np.sqrt(np.mean(film**2))
    for sound in sounds:
        samples, _ = soundfile.read(sound.path)
        samples = samples[: int(LONGEST_S * RATE_HZ)].copy()
        fade = min(len(samples), RATE_HZ // 10)
        samples[-fade:] *= np.linspace(1.0, 0.0, fade)
        at = round(sound.at_s * RATE_HZ)
        samples = samples[: len(film) - at]
        film[at : at + len(samples)] += samples / np.abs(samples).max() * 10.0 ** ((BED_DBFS + sound.level_db) / 20.0)
    return film / max(1.0, float(np.abs(film).max()))


def believed(quality: Quality, film: tuple[int, tuple[Sound, ...]]) -> list[tuple[Sound, int]]:
    """Return of each sound of a film how many of a gun's rounds are found, or how often another is taken for a gun."""
    tier = load_rules(quality).tier
    with tempfile.NamedTemporaryFile(suffix=".wav") as file:
        soundfile.write(file.name, made(*film), RATE_HZ, subtype="PCM_16")
        found = listened(Path(file.name), tier, verifier_of(tier)).detection.shots
    onsets_s = np.array([shot.onset / RATE_HZ for shot in found])
    counts = []
    for sound, after in zip(film[1], [*film[1][1:], None], strict=True):
        near = [np.abs(onsets_s - sound.at_s - onset).min(initial=1.0) <= WITHIN_MS / 1e3 for onset in sound.onsets_s]
        own = (onsets_s >= sound.at_s - WITHIN_MS / 1e3) & (onsets_s < (after.at_s if after else SECONDS))
        counts.append((sound, sum(near) if sound.onsets_s else int(own.sum())))
    return counts


def main() -> None:
    """Run from the command line."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("corpus", type=Path, nargs="+")
    parser.add_argument("--quality", choices=get_args(Quality), default="standard")
    options = parser.parse_args()
    for corpus in options.corpus:
        with ProcessPoolExecutor() as pool:
            counts = [each for film in pool.map(partial(believed, options.quality), films(corpus)) for each in film]
        for path in sorted({sound.path for sound, _ in counts if sound.onsets_s}):
            own = [(sound, count) for sound, count in counts if sound.path == path]
            shares = [
                sum(count for sound, count in own if sound.level_db == db) / BEDS / len(own[0][0].onsets_s)
                for db in LEVELS_DB
            ]
            told = " ".join(f"{db}: {share:.2f}" for db, share in zip(LEVELS_DB, shares, strict=True))
            print(f"{path.stem[-48:]:48s} found at dB over the bed {told}")
        others = [count for sound, count in counts if not sound.onsets_s]
        print(f"{corpus}: of {len(others)} other sounds {sum(map(bool, others))} believed, {sum(others)} times")


if __name__ == "__main__":
    main()

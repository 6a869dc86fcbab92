"""The models that `unseen.py` asks: `python benchmarks/unseen_models.py --corpus DIR -o DIR` (over an hour, 2 cores).

They learn from synthetic lessons and from recordings, of which each model leaves one group of sources out. Every
lesson is made and looked at once for all of them; gate and screen learn from the synthetic ones alone. The same command
goes on where it was interrupted.
"""

from argparse import ArgumentParser
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path

import msgspec
import numpy as np

from blastline.detect.network import NetworkFile
from blastline.detect.verify import SCHEMA, ModelFile, SieveFile
from blastline.ruleset import load_rules
from blastline.study.candidates import concatenated
from blastline.study.datasets import FOLDS, Dataset, datasets
from blastline.study.lesson_files import LessonFile, write_lessons
from blastline.study.sieves import fit_sieves, sieved
from blastline.study.training import Examples, fit_network
from blastline.study.verifier import listen, look, training_tier

LESSON_SEED = 510
TRAINING_SEEDS = (1, 2, 3)
RECORDED = "recorded-"


class Sieves(msgspec.Struct, frozen=True):
    """Gate and screen, which all models share."""

    gate: SieveFile
    screen: SieveFile


@dataclass(frozen=True)
class Training:
    """One network to be trained: its size and seed, and the group of sources that it does not hear."""

    work: Path
    size: str
    seed: int
    group: int

    @property
    def path(self) -> Path:
        """Return where the network is kept."""
        return self.work / f"{self.size}{self.seed}-without{self.group}.json"

    def read(self) -> NetworkFile:
        """Return the trained network."""
        return msgspec.json.decode(self.path.read_bytes(), type=NetworkFile)


def model_path(folder: Path, seed: int, group: int) -> Path:
    """Return where the model of a training seed is that has not heard a group of sources."""
    return folder / f"seed{seed}-without{group}.json"


def prepare(work: Path, lessons: Sequence[Dataset], jobs: int) -> None:
    """Write gate and screen, and the examples of each dataset that pass them."""
    with ProcessPoolExecutor(jobs) as pool:
        files = {each.name: write_lessons(work, each, LESSON_SEED, pool) for each in lessons}
        synthetic = [file for name, each in files.items() if not name.startswith(RECORDED) for file in each]
        sieves = _sieves(work, synthetic, pool)
        groups = {name: each for name, each in files.items() if name.startswith(RECORDED)}
        for name, each in {"synthetic": synthetic, **groups}.items():
            if not _examples_path(work, name).exists():
                _write_examples(work, name, each, sieves, pool)


def _examples_path(work: Path, name: str) -> Path:
    return work / f"examples-{name}.npz"


def _sieves(work: Path, synthetic: Sequence[LessonFile], pool: ProcessPoolExecutor) -> Sieves:
    path = work / "sieves.json"
    if not path.exists():
        hear = partial(listen, training_tier(load_rules("reference").tier))
        heard = concatenated(list(pool.map(hear, list(enumerate(synthetic)), chunksize=4)))
        path.write_bytes(msgspec.json.encode(Sieves(*fit_sieves(heard, LESSON_SEED))))
    return msgspec.json.decode(path.read_bytes(), type=Sieves)


def _write_examples(
    work: Path, name: str, lessons: Sequence[LessonFile], sieves: Sieves, pool: ProcessPoolExecutor
) -> None:
    hear = partial(listen, training_tier(load_rules("reference").tier))
    heard = concatenated(list(pool.map(hear, list(enumerate(lessons)), chunksize=4)))
    examples = look(sieved(heard, sieves.gate, sieves.screen), lessons, pool)
    unfinished = _examples_path(work, name).with_suffix(".part.npz")
    arrays = (examples.near, examples.wide, examples.rows, examples.shots)
    np.savez(unfinished, near=arrays[0], wide=arrays[1], rows=arrays[2], shots=arrays[3])
    unfinished.rename(_examples_path(work, name))
    print(f"{name}: {examples.shots.size} examples, {int(examples.shots.sum())} of them shots", flush=True)


def teach(training: Training) -> Path:
    """Train a network on the synthetic lessons and the groups that it hears; small ones annealed, large averaged."""
    import torch

    torch.set_num_threads(1)
    heard = ["synthetic", *(f"{RECORDED}{group}" for group in range(FOLDS) if group != training.group)]
    parts = []
    for name in heard:
        with np.load(_examples_path(training.work, name)) as arrays:
            parts.append([arrays[key] for key in ("near", "wide", "rows", "shots")])
    examples = Examples(*(np.concatenate(each) for each in zip(*parts, strict=True)))
    large = training.size == "large"
    network = fit_network(examples, training.seed, averaged=large, size=training.size)
    training.path.write_bytes(msgspec.json.encode(network))
    return training.path


def assemble(output: Path, work: Path, seed: int, group: int) -> None:
    """Write a model: its third network, of the reference tier alone, is the second one of the next seed."""
    following = TRAINING_SEEDS[(TRAINING_SEEDS.index(seed) + 1) % len(TRAINING_SEEDS)]
    asked = (("small", seed), ("large", seed), ("large", following))
    networks = [Training(work, size, of_seed, group).read() for size, of_seed in asked]
    sieves = msgspec.json.decode((work / "sieves.json").read_bytes(), type=Sieves)
    record = {"command": "python benchmarks/unseen_models.py", "seed": seed, "without": f"{RECORDED}{group}"}
    model_path(output, seed, group).write_bytes(
        msgspec.json.encode(ModelFile(SCHEMA, sieves.gate, sieves.screen, networks, record))
    )


def main() -> None:
    """Run from the command line."""
    parser = ArgumentParser(description="The models that unseen.py asks.")
    parser.add_argument("--corpus", type=Path, action="append", required=True, help="a folder with annotations.csv")
    parser.add_argument("--synthetic", type=int, default=96, help="synthetic films; other lessons in proportion")
    parser.add_argument("--recorded", type=int, default=160, help="mixes of recordings, a quarter of each group")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("-o", "--output", type=Path, required=True, help="the models; in its folder work all else")
    options = parser.parse_args()
    work = options.output / "work"
    work.mkdir(parents=True, exist_ok=True)
    lessons = datasets(
        options.corpus, synthetic=options.synthetic, recorded=options.recorded, seed=LESSON_SEED, hold_out=None
    )
    prepare(work, lessons, options.jobs)
    trainings = [Training(work, *each) for each in product(("small", "large"), TRAINING_SEEDS, range(FOLDS))]
    with ProcessPoolExecutor(options.jobs) as pool:
        for path in pool.map(teach, [each for each in trainings if not each.path.exists()]):
            print(path.name, flush=True)
    for seed, group in product(TRAINING_SEEDS, range(FOLDS)):
        assemble(options.output, work, seed, group)


if __name__ == "__main__":
    main()

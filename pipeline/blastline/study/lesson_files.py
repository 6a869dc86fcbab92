"""Lessons as files in a work folder, by seed: to make them takes longer than to learn from them.

So each may also be used again, augmented each time (`augment.py`).
"""

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from .augment import augmented
from .datasets import Dataset
from .mixes import LessonMaker, Mix

FILM_DATASET = "film"
"""The dataset whose lessons are not mixed beneath others: two crowded films at once are no film."""


@dataclass(frozen=True)
class SeededDatasets:
    """The datasets of one seed."""

    seed: int
    datasets: Sequence[Dataset]


@dataclass(frozen=True)
class Augmentation:
    """How a copy of a lesson is augmented: which one may lie beneath it, and the seed of all random draws."""

    other: Path
    seed: tuple[int, ...]


@dataclass(frozen=True)
class LessonFile:
    """A lesson in the work folder, to be used as it is or augmented; those held out are only scored on."""

    path: Path
    dataset: str
    held_out: bool
    seed: int
    augmentation: Augmentation | None = None


def write_lessons(work: Path, dataset: Dataset, seed: int, pool: ProcessPoolExecutor) -> list[LessonFile]:
    """Write the lessons of a seed's dataset to files, except those that the work folder has already."""
    folder = work / f"seed-{seed}"
    folder.mkdir(parents=True, exist_ok=True)
    write = partial(_write, folder, dataset.name, dataset.make_lesson)
    paths = list(pool.map(write, range(dataset.count), chunksize=2))
    return [LessonFile(path, dataset.name, dataset.is_held_out(number), seed) for number, path in enumerate(paths)]


def _write(work: Path, name: str, make_lesson: LessonMaker, number: int) -> Path:
    path = work / f"{name}-{number:05d}.npz"
    if not path.exists():
        film = make_lesson(number)
        samples = np.round(film.samples * 32768.0).astype(np.int16)
        unfinished = path.with_suffix(".part.npz")
        np.savez(unfinished, samples=samples, onsets=film.onsets, level_db=film.level_db, unsure=film.unsure)
        unfinished.rename(path)
    return path


def load_lesson(path: Path) -> Mix:
    """Return a lesson from its file."""
    with np.load(path) as arrays:
        samples = arrays["samples"].astype(np.float32) / np.float32(32768.0)
        return Mix(samples, arrays["onsets"], arrays["level_db"], arrays["unsure"])


def augmented_copies(lessons: Sequence[LessonFile], copies: int, seed: int) -> list[LessonFile]:
    """Return that many copies of each lesson that is not held out, each with an augmentation of its own."""
    training = [each for each in lessons if not each.held_out]
    others = [each.path for each in training if each.dataset != FILM_DATASET]
    if not others:
        return []
    rng = np.random.default_rng(seed)
    return [
        replace(each, augmentation=Augmentation(others[int(rng.integers(len(others)))], (seed, copy, number)))
        for copy in range(copies)
        for number, each in enumerate(training)
    ]


def load_augmented(lesson: LessonFile) -> Mix:
    """Return a lesson with its augmentation, if it has one; the same each time."""
    film = load_lesson(lesson.path)
    if lesson.augmentation is None:
        return film
    other, rng = load_lesson(lesson.augmentation.other), np.random.default_rng(lesson.augmentation.seed)
    return augmented(film, other, rng)

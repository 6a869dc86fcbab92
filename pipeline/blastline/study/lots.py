"""Lessons kept as files while a training goes on, lot by lot: to make them takes longer than to learn from them."""

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from .courses import Course
from .lessons import Lesson
from .mixes import Mix


@dataclass(frozen=True)
class Lot:
    """The lessons of one seed."""

    seed: int
    courses: Sequence[Course]


@dataclass(frozen=True)
class Kept:
    """A lesson in the work folder."""

    path: Path
    course: str
    tested: bool
    seed: int


def keep_lessons(work: Path, course: Course, seed: int, pool: ProcessPoolExecutor) -> list[Kept]:
    """Make the lessons of a seed's course as files, unless the work folder has them already."""
    folder = work / f"seed-{seed}"
    folder.mkdir(parents=True, exist_ok=True)
    paths = list(pool.map(partial(_keep, folder, course.name, course.lesson), range(course.count), chunksize=2))
    return [Kept(path, course.name, course.tested(number), seed) for number, path in enumerate(paths)]


def _keep(work: Path, name: str, lesson: Lesson, number: int) -> Path:
    path = work / f"{name}-{number:05d}.npz"
    if not path.exists():
        film = lesson(number)
        samples = np.round(film.samples * 32768.0).astype(np.int16)
        unfinished = path.with_suffix(".part.npz")
        np.savez(unfinished, samples=samples, onsets=film.onsets, level_db=film.level_db, unsure=film.unsure)
        unfinished.rename(path)
    return path


def load_lesson(path: Path) -> Mix:
    """Return a lesson from its file."""
    with np.load(path) as kept:
        samples = kept["samples"].astype(np.float32) / np.float32(32768.0)
        return Mix(samples, kept["onsets"], kept["level_db"], kept["unsure"])

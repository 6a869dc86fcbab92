"""Lessons kept as files while a training goes on, lot by lot: to make them takes longer than to learn from them.

So each may also be heard again, as another film each time (`again.py`).
"""

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from .again import heard_again
from .courses import Course
from .lessons import Lesson
from .mixes import Mix

CROWDED = "film"
"""The course whose lessons are not put beneath another one: two crowded films at once are no film."""


@dataclass(frozen=True)
class Lot:
    """The lessons of one seed."""

    seed: int
    courses: Sequence[Course]


@dataclass(frozen=True)
class Again:
    """How a lesson is heard once more: which one may lie beneath it, and the seed of all that changes."""

    other: Path
    seed: tuple[int, ...]


@dataclass(frozen=True)
class Kept:
    """A lesson in the work folder, as it is or to be heard again."""

    path: Path
    course: str
    tested: bool
    seed: int
    again: Again | None = None


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


def times_more(kept: Sequence[Kept], times: int, seed: int) -> list[Kept]:
    """Return what is learnt from of some lessons, to be heard so many times more, each time otherwise."""
    learnt = [each for each in kept if not each.tested]
    others = [each.path for each in learnt if each.course != CROWDED]
    if not others:
        return []
    rng = np.random.default_rng(seed)
    return [
        replace(each, again=Again(others[int(rng.integers(len(others)))], (seed, time, number)))
        for time in range(times)
        for number, each in enumerate(learnt)
    ]


def heard(kept: Kept) -> Mix:
    """Return a lesson as it is to be heard; the same one sounds the same each time."""
    film = load_lesson(kept.path)
    if kept.again is None:
        return film
    return heard_again(film, load_lesson(kept.again.other), np.random.default_rng(kept.again.seed))

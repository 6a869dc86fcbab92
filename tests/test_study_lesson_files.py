"""Lessons as files: what is read is what was made, once, and seeds do not get into each other's way."""

from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from blastline.study.datasets import Dataset
from blastline.study.lesson_files import FILM_DATASET, augmented_copies, load_augmented, load_lesson, write_lessons
from blastline.study.mixes import Mix


def lesson(seed: int, number: int) -> Mix:
    samples = np.random.default_rng([seed, number]).uniform(-0.5, 0.5, 4_800).astype(np.float32)
    return Mix(samples, np.array([100 * number, 4_000]), np.array([12.0, 3.0]), np.array([17]))


def of_seed(seed: int, name: str = "film") -> Dataset:
    return Dataset(name, partial(lesson, seed), 5, 2)


def test_lessons_are_read_as_they_were_made_and_those_of_two_seeds_lie_apart(tmp_path: Path) -> None:
    with ProcessPoolExecutor(2) as pool:
        by_seed = {seed: write_lessons(tmp_path, of_seed(seed), seed, pool) for seed in (3, 4)}
    assert len({file.path for files in by_seed.values() for file in files}) == 10
    for seed, files in by_seed.items():
        assert [file.held_out for file in files] == [True, False, True, False, True]
        for number, file in enumerate(files):
            made, read = lesson(seed, number), load_lesson(file.path)
            np.testing.assert_allclose(read.samples, made.samples, atol=2.0**-16)
            for one, two in ((read.onsets, made.onsets), (read.level_db, made.level_db), (read.unsure, made.unsure)):
                assert np.array_equal(one, two)
            assert (file.dataset, file.seed) == ("film", seed)


def test_a_lesson_that_is_there_is_not_made_again(tmp_path: Path) -> None:
    with ProcessPoolExecutor(1) as pool:
        first = write_lessons(tmp_path, of_seed(3), 3, pool)
        before = [file.path.stat().st_mtime_ns for file in first]
        first[2].path.unlink()
        again = write_lessons(tmp_path, of_seed(3), 3, pool)
    after = [file.path.stat().st_mtime_ns for file in again]
    assert [one == two for one, two in zip(before, after, strict=True)] == [True, True, False, True, True]
    assert load_lesson(again[2].path).onsets[0] == pytest.approx(200)


def test_each_training_lesson_is_augmented_otherwise_each_time_and_what_is_held_out_is_not(tmp_path: Path) -> None:
    with ProcessPoolExecutor(1) as pool:
        files = [
            each for name in (FILM_DATASET, "plain") for each in write_lessons(tmp_path, of_seed(3, name), 3, pool)
        ]
    more = augmented_copies(files, 3, seed=3)
    training = [each.path for each in files if not each.held_out]
    assert [each.path for each in more] == 3 * training
    beneath = {each.augmentation.other for each in more if each.augmentation}
    assert beneath <= {each.path for each in files if each.dataset != FILM_DATASET}
    films = [load_augmented(each) for each in more]
    for film, once_more in zip(films, map(load_augmented, more), strict=True):
        assert np.array_equal(film.samples, once_more.samples)
        assert np.array_equal(film.onsets, once_more.onsets)
    assert len({film.samples.tobytes() for film in films}) == len(films)
    assert augmented_copies([each for each in files if each.held_out], 3, seed=3) == []

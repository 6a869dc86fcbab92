"""Lessons as files: what is read is what was made, once, and seeds do not get into each other's way."""

from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from blastline.study.courses import Course
from blastline.study.lots import keep_lessons, load_lesson
from blastline.study.mixes import Mix


def lesson(seed: int, number: int) -> Mix:
    samples = np.random.default_rng([seed, number]).uniform(-0.5, 0.5, 4_800).astype(np.float32)
    return Mix(samples, np.array([100 * number, 4_000]), np.array([12.0, 3.0]), np.array([17]))


def of_seed(seed: int) -> Course:
    return Course("film", partial(lesson, seed), 5, 2)


def test_lessons_are_read_as_they_were_made_and_those_of_two_seeds_lie_apart(tmp_path: Path) -> None:
    with ProcessPoolExecutor(2) as pool:
        lots = {seed: keep_lessons(tmp_path, of_seed(seed), seed, pool) for seed in (3, 4)}
    assert len({kept.path for lot in lots.values() for kept in lot}) == 10
    for seed, lot in lots.items():
        assert [kept.tested for kept in lot] == [True, False, True, False, True]
        for number, kept in enumerate(lot):
            made, read = lesson(seed, number), load_lesson(kept.path)
            np.testing.assert_allclose(read.samples, made.samples, atol=2.0**-16)
            for one, two in ((read.onsets, made.onsets), (read.level_db, made.level_db), (read.unsure, made.unsure)):
                assert np.array_equal(one, two)
            assert (kept.course, kept.seed) == ("film", seed)


def test_a_lesson_that_is_there_is_not_made_again(tmp_path: Path) -> None:
    with ProcessPoolExecutor(1) as pool:
        first = keep_lessons(tmp_path, of_seed(3), 3, pool)
        before = [kept.path.stat().st_mtime_ns for kept in first]
        first[2].path.unlink()
        again = keep_lessons(tmp_path, of_seed(3), 3, pool)
    after = [kept.path.stat().st_mtime_ns for kept in again]
    assert [one == two for one, two in zip(before, after, strict=True)] == [True, True, False, True, True]
    assert load_lesson(again[2].path).onsets[0] == pytest.approx(200)

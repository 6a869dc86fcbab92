"""Lessons as files: what is read is what was made, once, and seeds do not get into each other's way."""

from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from blastline.study.courses import Course
from blastline.study.lots import CROWDED, heard, keep_lessons, load_lesson, times_more
from blastline.study.mixes import Mix


def lesson(seed: int, number: int) -> Mix:
    samples = np.random.default_rng([seed, number]).uniform(-0.5, 0.5, 4_800).astype(np.float32)
    return Mix(samples, np.array([100 * number, 4_000]), np.array([12.0, 3.0]), np.array([17]))


def of_seed(seed: int, name: str = "film") -> Course:
    return Course(name, partial(lesson, seed), 5, 2)


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


def test_what_is_learnt_from_is_heard_again_otherwise_each_time_and_what_is_tested_is_not(tmp_path: Path) -> None:
    with ProcessPoolExecutor(1) as pool:
        kept = [each for name in (CROWDED, "plain") for each in keep_lessons(tmp_path, of_seed(3, name), 3, pool)]
    more = times_more(kept, 3, seed=3)
    learnt = [each.path for each in kept if not each.tested]
    assert [each.path for each in more] == 3 * learnt
    assert {each.again.other for each in more if each.again} <= {each.path for each in kept if each.course != CROWDED}
    films = [heard(each) for each in more]
    for film, once_more in zip(films, map(heard, more), strict=True):
        assert np.array_equal(film.samples, once_more.samples)
        assert np.array_equal(film.onsets, once_more.onsets)
    assert len({film.samples.tobytes() for film in films}) == len(films)
    assert times_more([each for each in kept if each.tested], 3, seed=3) == []

"""Segments of the old film in the new one: where they are cut, what they look like at a speed, where they are found."""

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.conform.fingerprint import FRAME_HZ, Fingerprint
from blastline.conform.hits import (
    LINE_DRIFT,
    LINE_TOLERANCE_S,
    SEGMENTS_S,
    find_hits,
    follows,
    is_covered,
    is_lively,
    segment_centres,
)
from blastline.conform.search import Haystack, Hit

LENGTH_S = SEGMENTS_S[0][0]
HALF_FRAME_S = 0.5 / FRAME_HZ + 1e-9
"""So near a segment is found: its middle lies between two frames."""


def printed(frames: NDArray[np.float64]) -> Fingerprint:
    return Fingerprint(frames.astype(np.float32), (len(frames) - 1) / FRAME_HZ)


def lively(length_s: float, *, seed: int) -> NDArray[np.float64]:
    """Return frames that wander, as a film's do."""
    random = np.random.default_rng(seed).normal(size=(round(length_s * FRAME_HZ) + 1, 6))
    return np.apply_along_axis(lambda band: np.convolve(band, np.hanning(16), "same"), 0, random) / 2.5


def found(old: Fingerprint, new: Fingerprint, centres: list[float], speeds: tuple[float, ...] = (1.0,)) -> list[Hit]:
    return find_hits(old, new, Haystack(new, LENGTH_S * 1.1 + 0.1), centres, LENGTH_S, speeds)


@pytest.mark.parametrize("duration_s", [0.5, 7.99, 8.0, 8.01, 11.99, 12.0, 12.01, 16.0, 123.4, 7200.5])
@pytest.mark.parametrize(("length_s", "spacing_s"), SEGMENTS_S)
def test_segments_cover_a_film_from_its_first_moment_to_its_last(
    duration_s: float, length_s: float, spacing_s: float
) -> None:
    old = Fingerprint(np.zeros((1, 6), np.float32), duration_s)
    centres = np.array(segment_centres(old, length_s, spacing_s))
    if duration_s <= length_s:
        assert centres.tolist() == [duration_s / 2.0]
        return
    half_s = length_s / 2.0
    assert (centres[0], centres[-1]) == pytest.approx((half_s, duration_s - half_s), abs=1e-9)
    steps_s = np.diff(centres)
    assert np.all((steps_s > 0.0) & (steps_s <= spacing_s + 1e-9))
    assert len(centres) == 1 + np.ceil((duration_s - length_s) / spacing_s - 1e-9)


def test_what_changes_is_lively_and_silence_and_a_hum_are_not() -> None:
    sound = lively(20.0, seed=1)
    for factor, is_told in ((1.0, True), (0.0, False), (0.05, False)):
        assert is_lively(printed(factor * sound), 10.0, LENGTH_S) == is_told
    beside = sound.copy()
    beside[600:1401] = 0.0  # from 6 s to 14 s
    assert not is_lively(printed(beside), 10.0, LENGTH_S)
    assert is_lively(printed(beside), 4.0, LENGTH_S)


@pytest.mark.parametrize("late", [0, 1, 7, 250, -300])
def test_a_segment_is_found_where_it_is(late: int) -> None:
    """Each by itself, in the whole film, and one after the other, where the last one goes on."""
    sound = lively(40.0, seed=2)
    new = np.concatenate([lively(2.5, seed=3)[:late], sound]) if late > 0 else sound[-late:]
    centres = [8.0, 12.0, 16.0, 30.0]
    for centres_at_once in ([[at] for at in centres], [centres]):
        hits = [hit for some in centres_at_once for hit in found(printed(sound), printed(new), some)]
        assert [hit.old_s for hit in hits] == centres
        assert [hit.new_s for hit in hits] == pytest.approx([at + late / FRAME_HZ for at in centres], abs=HALF_FRAME_S)
        assert all(hit.score > 0.98 and hit.scale == 1.0 for hit in hits)


@pytest.mark.parametrize("speed", [25.0 / 24.0, 24.0 / 25.0])
def test_a_segment_of_a_faster_film_is_found_at_its_speed_and_place(speed: float) -> None:
    sound = lively(60.0, seed=4)
    old = printed(sound)
    new = printed(old.at(np.arange(0.0, 60.0 / speed, 1.0 / FRAME_HZ) * speed).astype(np.float64))
    hits = found(old, new, [12.0, 16.0, 47.0], (1.0, 25.0 / 24.0, 24.0 / 25.0))
    assert [hit.scale for hit in hits] == pytest.approx([1.0 / speed] * 3)
    assert [hit.new_s for hit in hits] == pytest.approx([at / speed for at in (12.0, 16.0, 47.0)], abs=0.01)


@pytest.mark.parametrize("moved", [-20, -8, 0, 8, 20])
def test_after_a_cut_a_segment_is_found_again_wherever_the_film_goes_on(moved: int) -> None:
    """A few frames aside where the last one leads, else in the whole film; also where that ends with the segment."""
    sound, insert = lively(32.0, seed=5), lively(1.0, seed=6)
    cut = 1600
    new = np.concatenate([sound[:cut], insert[: max(0, moved)], sound[cut + max(0, -moved) :]])
    hits = found(printed(sound), printed(new), [8.0, 24.0, 28.0])
    assert sorted({hit.old_s for hit in hits}) == [8.0, 24.0, 28.0]
    for hit in hits:  # the line before the cut and the one after it may both lead there
        late = 0 if hit.old_s < cut / FRAME_HZ else moved
        assert hit.new_s - hit.old_s == pytest.approx(late / FRAME_HZ, abs=HALF_FRAME_S)


class Counted(Haystack):
    """A film that counts how often all of it is searched."""

    searches = 0

    def best(self, pattern: NDArray[np.float32], count: int) -> Iterator[tuple[int, float]]:
        self.searches += 1
        return super().best(pattern, count)


def searches(old: Fingerprint, new: Fingerprint, centres: list[float], speed: float = 1.0) -> int:
    hay = Counted(new, LENGTH_S * 1.1 + 0.1)
    assert {hit.old_s for hit in find_hits(old, new, hay, centres, LENGTH_S, (speed,))} == set(centres)
    return hay.searches


@pytest.mark.parametrize("late", [-300, 0, 250])
def test_where_a_film_goes_on_all_of_it_is_searched_once(late: int) -> None:
    """To its very end, and across a gap."""
    sound = lively(160.0, seed=11)
    old, new = (
        printed(sound),
        printed(np.concatenate([lively(2.5, seed=3)[:late], sound]) if late > 0 else sound[-late:]),
    )
    assert searches(old, new, [8.0, 12.0, 30.0, 149.0, 156.0]) == 1
    assert searches(old, new, [8.0, 110.0]) == 1


def test_a_faster_film_goes_on_at_its_speed() -> None:
    speed = 25.0 / 24.0
    old = printed(lively(80.0, seed=12))
    new = printed(old.at(np.arange(0.0, 80.0 / speed, 1.0 / FRAME_HZ) * speed).astype(np.float64))
    assert searches(old, new, [8.0, 12.0, 40.0, 76.0], speed) == 1


@pytest.mark.parametrize(("moved", "times"), [(-40, 2), (-7, 1), (-3, 1), (5, 1), (7, 1), (40, 2)])
def test_eighty_milliseconds_aside_a_film_still_goes_on(moved: int, times: int) -> None:
    sound, insert = lively(32.0, seed=13), lively(1.0, seed=6)
    new = np.concatenate([sound[:1600], insert[: max(0, moved)], sound[1600 + max(0, -moved) :]])
    assert searches(printed(sound), printed(new), [8.0, 24.0]) == times


@pytest.mark.parametrize("length_s", [2.0, 5.0, 7.9])
def test_a_film_shorter_than_a_segment_is_one(length_s: float) -> None:
    sound = lively(length_s, seed=14)
    new = np.concatenate([lively(10.0, seed=15), sound, lively(6.0, seed=16)])
    [hit, *_] = found(printed(sound), printed(new), segment_centres(printed(sound), *SEGMENTS_S[0]))
    assert hit.new_s == pytest.approx(10.01 + length_s / 2.0, abs=HALF_FRAME_S)
    assert hit.score > 0.95


def test_a_scene_that_comes_twice_is_found_twice_and_silence_nowhere() -> None:
    scene = lively(10.0, seed=7)
    old = printed(np.concatenate([np.zeros((1200, 6)), scene]))
    new = printed(np.concatenate([scene, lively(5.0, seed=8), scene, np.zeros((900, 6))]))
    assert found(old, new, [6.0]) == []
    places = sorted(hit.new_s for hit in found(old, new, [17.0]))
    assert places == pytest.approx([5.0, 5.0 + (len(scene) + 501) / FRAME_HZ], abs=HALF_FRAME_S)
    assert found(old, printed(lively(30.0, seed=9)), [17.0]) == []


def test_the_progress_of_a_search_is_told_in_seconds() -> None:
    old = printed(lively(21.4, seed=10))
    told: list[tuple[int, int]] = []
    find_hits(
        old,
        old,
        Haystack(old, LENGTH_S * 1.1 + 0.1),
        [4.0, 8.3, 17.4],
        LENGTH_S,
        (1.0,),
        lambda at, of: told.append((at, of)),
    )
    assert told == [(4, 21), (8, 21), (17, 21)]


@pytest.mark.parametrize("gap_s", [-30.0, 0.0, 4.0, 60.0])
@pytest.mark.parametrize("scale", [0.96, 1.0])
def test_a_hit_is_on_a_line_to_a_tolerance_that_grows_with_distance(gap_s: float, scale: float) -> None:
    one = Hit(50.0, 20.0, scale, 0.9)
    room_s = LINE_TOLERANCE_S + LINE_DRIFT * abs(gap_s)
    for aside, is_on in ((-1.01, False), (-0.99, True), (0.0, True), (0.99, True), (1.01, False)):
        other = Hit(50.0 + gap_s, 20.0 + scale * gap_s + aside * room_s, scale, 0.9)
        assert follows(one, other) == is_on
    there = 20.0 + scale * gap_s
    for share, is_on in ((0.5, True), (2.0, False)):
        for way in (1.0, -1.0):
            other = Hit(50.0 + gap_s, there, scale * (1.0 + way * share * LINE_DRIFT), 0.9)
            assert follows(one, other) == is_on


def test_around_a_segment_that_was_found_as_a_whole_nothing_shorter_is_looked_for() -> None:
    sure, doubtful = Hit(50.0, 0.0, 1.0, 0.85), Hit(70.0, 0.0, 1.0, 0.75)
    covered = [is_covered(at, [sure, doubtful]) for at in (45.9, 46.0, 50.0, 54.0, 54.1, 70.0)]
    assert covered == [False, True, True, True, False, False]
    assert not is_covered(50.0, [])


@pytest.mark.parametrize("missing", range(0, 40, 3))
def test_a_film_that_ends_a_little_early_still_has_what_comes_before(missing: int) -> None:
    """Where its last segment leads is too near the end to hold all of it, by any number of frames."""
    sound = lively(24.0, seed=17)
    old = printed(sound)
    for ended in range(missing, missing + 3):
        hits = found(old, printed(sound[: len(sound) - ended]), [8.0, 20.0])
        assert hits[0].new_s == pytest.approx(8.0, abs=HALF_FRAME_S)


@pytest.mark.parametrize(("left", "is_found"), [(0.4, False), (0.5, True)])
def test_against_next_to_nothing_a_segment_is_not_believed(left: float, is_found: bool) -> None:
    """A fifth of its energy has to be there, both where it is followed and where it is searched for."""
    sound = lively(32.0, seed=18)
    fainter = sound.copy()
    fainter[1500:] *= left
    for centres in ([8.0, 24.0], [24.0]):
        hits = found(printed(sound), printed(fainter), centres)
        assert any(hit.old_s == 24.0 for hit in hits) == is_found

"""Films of which single frames are missing in many places, and films whose shots were moved one by one."""

import itertools

import numpy as np
import pytest

from blastline.conform import Placed, find_courses, place
from blastline.ruleset import load_conform
from conform_films import RATE_HZ, Samples, bang, film, heard, murmur, put, seconds, steady

FRAME_S = round(RATE_HZ / 24.0) / RATE_HZ


def conformed(old: Samples, new: Samples, onsets_s: list[float]) -> list[float | None]:
    """Return each onset's time in the new film, None where it was not placed."""
    one, other = heard(old), heard(new)
    found = place(onsets_s, find_courses(one, other), one, other, load_conform())
    return [each.new_s if isinstance(each, Placed) else None for each in found]


@pytest.mark.parametrize("every_s", [30.0, 40.0, 60.0])
def test_single_frames_that_were_taken_out_at_many_splices_cost_no_shot(every_s: float) -> None:
    """A worn print: no line has a quarter of the film, and a step of a frame is too little for a cut of the path."""
    onsets_s = np.arange(5.0, 240.0, 7.3).tolist()
    old = film(240.0, onsets_s, seed=41)
    splices_s = np.arange(every_s, 240.0, every_s).tolist()
    edges_s = [0.0, *splices_s, 240.0]
    new = np.concatenate(
        [seconds(old, start_s + (start_s > 0.0) * FRAME_S, stop_s) for start_s, stop_s in itertools.pairwise(edges_s)]
    )
    moved_s = [onset_s - sum(splice_s < onset_s for splice_s in splices_s) * FRAME_S for onset_s in onsets_s]
    assert conformed(old, new, onsets_s) == [pytest.approx(onset_s, abs=1e-4) for onset_s in moved_s]


@pytest.mark.parametrize("late_s", [0.0035, 0.006, 0.042])
def test_the_search_ends_where_shots_were_moved_by_themselves(late_s: float) -> None:
    """What agrees there is a sound here and there; the rest that it leaves has to be shorter than what it is of."""
    onsets_s = np.arange(3.0, 118.0, 0.7).tolist()
    late = [late_s if index % 3 == 0 else 0.0 for index in range(len(onsets_s))]
    moved_s = [onset_s + by_s for onset_s, by_s in zip(onsets_s, late, strict=True)]
    old, new = (0.02 * murmur(120.0, seed=42) for _ in range(2))
    for samples, times_s in ((old, onsets_s), (new, moved_s)):
        for index, time_s in enumerate(times_s):
            put(samples, bang(seed=index % 4), time_s)
    step_s = 1.0 / RATE_HZ
    for now_s, then_s in zip(conformed(old, new, onsets_s), moved_s, strict=True):
        assert now_s is None or now_s == pytest.approx(then_s, abs=step_s)


@pytest.mark.parametrize("pictures", [-2, -1, 1, 2, 5])
@pytest.mark.parametrize(("length_s", "cut_s"), [(24.0, 12.3), (60.0, 4.0), (60.0, 54.0)])
def test_pictures_taken_out_or_put_in_over_a_steady_bed_cost_no_shot(
    length_s: float, cut_s: float, pictures: int
) -> None:
    """The fingerprints of hiss forget each other within a picture: the line of the longer part fits no other."""
    onsets_s = [at_s for at_s in np.arange(1.3, length_s - 1.0, 1.7).tolist() if abs(at_s - cut_s) > 0.6]
    old = steady(length_s, onsets_s, seed=43)
    by_s = pictures * FRAME_S
    out_s = max(0.0, -by_s)
    put_in = steady(max(0.0, by_s), (), seed=44)
    new = np.concatenate([seconds(old, 0.0, cut_s), put_in, seconds(old, cut_s + out_s, length_s)])
    moved_s = [at_s if at_s < cut_s else at_s + by_s for at_s in onsets_s]
    assert conformed(old, new, onsets_s) == [pytest.approx(at_s, abs=1e-4) for at_s in moved_s]


@pytest.mark.parametrize("kept_s", [0.0, 1.0])
def test_beside_a_course_nothing_is_found_that_was_taken_out(kept_s: float) -> None:
    """Nor of what was replaced: `kept_s` of other hiss and shots are where the scene was."""
    onsets_s = np.arange(1.3, 59.0, 1.7).tolist()
    old = steady(60.0, onsets_s, seed=45)
    other = steady(15.0 * kept_s, np.arange(0.7, 14.0, 1.7).tolist() if kept_s else (), seed=46)
    new = np.concatenate([seconds(old, 0.0, 20.0), other, seconds(old, 35.0, 60.0)])
    for onset_s, now_s in zip(onsets_s, conformed(old, new, onsets_s), strict=True):
        if 20.0 < onset_s < 35.0:
            assert now_s is None
        elif abs(onset_s - 20.0) > 0.6:
            moved_s = onset_s if onset_s < 20.0 else onset_s - 15.0 * (1.0 - kept_s)
            assert now_s == pytest.approx(moved_s, abs=1e-4)

"""How the line of a scene is found: by segments long and short, and by anchors of which enough have to agree."""

import numpy as np
import pytest

from blastline.conform import Placed, find_courses, place
from blastline.conform.anchors import Anchors, _fitted, consensus
from blastline.conform.courses import Anchored, Course, joined, through_anchors
from blastline.conform.fingerprint import FRAME_HZ
from blastline.conform.lines import Line, find_lines
from blastline.conform.segments import MatchedSegment
from blastline.ruleset import load_conform
from blastline.study.recut import stretched
from conform_films import RATE_HZ, bang, film, heard, murmur, put, seconds

ANCHORS_S = [1.0 + 2.0 * n for n in range(20)]


def agreeing(count: int, *, scale: float, pitch_scale: float) -> Anchored | None:
    """Return the course through twenty anchors of which so many are in the new film, spread over all of it."""
    old, new = murmur(40.0, seed=91), murmur(40.0 * scale, seed=92)
    for time_s in ANCHORS_S[:: len(ANCHORS_S) // count][:count]:
        there = round((scale * time_s - 0.9) * RATE_HZ)
        new[there : there + round(1.8 * RATE_HZ)] = seconds(old, time_s - 0.9, time_s + 0.9)
    segment = MatchedSegment(Line(scale, 0.004, 0.0, 40.0), 0.0, 40.0, 0.6)
    return through_anchors(segment, ANCHORS_S, heard(old), heard(new), pitch_scale=pitch_scale)


@pytest.mark.parametrize("alike", [3, 7, 9])
def test_a_quarter_of_the_anchors_tells_where_a_scene_is_that_was_dubbed_anew_for_the_most_part(alike: int) -> None:
    """So many on one line to the sample are no chance."""
    found = agreeing(alike, scale=1.0, pitch_scale=1.0)
    assert (found is not None) == (alike >= 5)
    if found is not None:
        line = found.course.segment.line
        assert [line.at(time_s) for time_s in (0.0, 20.0, 40.0)] == pytest.approx([0.0, 20.0, 40.0], abs=1e-4)
        assert line.scale == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("alike", [7, 9, 20])
def test_with_kept_pitch_half_of_the_anchors_have_to_agree(alike: int) -> None:
    """A few are within 30 ms of any line by chance."""
    assert (agreeing(alike, scale=0.96, pitch_scale=1.0) is not None) == (alike >= 10)


@pytest.mark.parametrize("speed", [25.0 / 24.0, 24.0 / 25.0])
@pytest.mark.parametrize("seed", [97, 98])
def test_a_film_at_another_speed_with_its_pitch_kept_is_on_one_line_within_the_steps_of_the_tool(
    speed: float, seed: int
) -> None:
    onsets_s = tuple(3.0 + 5.0 * n for n in range(8))
    old = film(45.0, onsets_s, seed=seed)
    new = stretched(old.astype(np.float32), onsets_s, speed, RATE_HZ)
    new_samples = new.samples.astype(np.float64)
    one, other = heard(old), heard(new_samples)
    [course] = find_courses(one, other)
    assert course.keeps_pitch
    assert course.segment.line.scale == pytest.approx(1.0 / speed, rel=2e-3)
    off_ms = [
        1000.0 * abs(float(each.new_s) - (new.true_s(onset_s) or 0.0))
        for onset_s, each in zip(onsets_s, place(onsets_s, [course], one, other, load_conform()), strict=True)
        if isinstance(each, Placed)
    ]
    assert sum(ms < 1.0 for ms in off_ms) >= 6
    assert max(off_ms) < 30.0  # by so much such a tool moves what it parts


@pytest.mark.parametrize("length_s", [8.0, 11.0, 14.0])
def test_a_short_film_that_was_not_changed_is_on_one_line_at_its_own_speed(length_s: float) -> None:
    """It is much alike at the speeds next to that as well."""
    same = heard(film(length_s, (2.0, 5.0), seed=93)).fingerprint
    [line] = find_lines(same, same)
    assert line.scale == 1.0
    assert line.offset_s == pytest.approx(0.0, abs=1.0 / FRAME_HZ)


def test_shots_in_digital_silence_are_found_by_themselves() -> None:
    onsets_s = (4.0, 11.0, 19.0, 24.0, 33.0)
    old = np.zeros(40 * RATE_HZ)
    for number, onset_s in enumerate(onsets_s):
        put(old, bang(seed=980 + number), onset_s)
    one, other = heard(old), heard(np.concatenate([np.zeros(5 * RATE_HZ), old]))
    found = place(onsets_s, find_courses(one, other), one, other, load_conform())
    assert [each.new_s if isinstance(each, Placed) else None for each in found] == pytest.approx(
        [onset_s + 5.0 for onset_s in onsets_s], abs=1e-4
    )


@pytest.mark.parametrize("seed", [1, 3])
def test_short_pieces_are_looked_for_though_no_speed_finds_anything_longer(seed: int) -> None:
    """Of a film of which a trailer keeps a few moments, a long segment is found at none of the speeds."""
    places_s = ((20.0, 50.0), (60.0, 10.0))
    old, new = murmur(90.0, seed=seed), murmur(90.0, seed=seed + 50)
    for at_s, there_s in places_s:
        put(new, -seconds(new, there_s, there_s + 4.5), there_s)
        put(new, seconds(old, at_s, at_s + 4.5), there_s)
    lines = find_lines(heard(old).fingerprint, heard(new).fingerprint)
    for at_s, there_s in places_s:
        on_piece = [line for line in lines if at_s <= line.first_s and line.last_s <= at_s + 4.5]
        assert any(line.at(at_s) == pytest.approx(there_s, abs=0.05) for line in on_piece)


def test_short_scenes_in_another_order_keep_their_shots_beside_a_long_one_that_stayed() -> None:
    """Each is too short for a long segment, and the long ones that are found elsewhere say nothing of it."""
    onsets_s, order = (5.0, 15.0, 32.0, 38.0, 44.0, 50.0, 56.0), (3, 1, 4, 0, 2)
    old = film(60.0, onsets_s, seed=95)
    scenes = [seconds(old, onset_s - 1.8, onset_s + 1.8) for onset_s in onsets_s[2:]]
    new = np.concatenate([seconds(old, 0.0, 20.0), *(scenes[number] for number in order)])
    one, other = heard(old), heard(new)
    found = place(onsets_s, find_courses(one, other), one, other, load_conform())
    expected_s = [5.0, 15.0, *(20.0 + 3.6 * order.index(number) + 1.8 for number in range(5))]
    assert [each.new_s if isinstance(each, Placed) else None for each in found] == pytest.approx(expected_s, abs=1e-4)


@pytest.mark.parametrize("late_s", [0.0, 7.25])
def test_a_shot_far_from_all_that_was_found_is_looked_for_along_what_lies_before_and_after_it(late_s: float) -> None:
    """A scene that was dubbed anew is on no line, but the shot in it may still be there."""
    old = film(60.0, (30.0,), seed=96)
    one, other = heard(old), heard(np.concatenate([murmur(late_s, seed=97), old]) if late_s else old)
    ends_s = (0.0, 10.0), (50.0, 60.0)
    courses = [Course(MatchedSegment(Line(1.0, late_s, *span), *span, 0.6), 1.0, 0.0, 4) for span in ends_s]
    [found] = place([30.0], courses, one, other, load_conform())
    assert isinstance(found, Placed)
    assert found.new_s == pytest.approx(30.0 + late_s, abs=1e-4)


@pytest.mark.parametrize(
    ("over", "expected_s"), [((0.0, 0.0), 20.0), ((0.3, 0.0), 20.0), ((1.0, 0.0), 40.0), ((0.0, 1.0), 20.0)]
)
def test_between_two_scenes_a_shot_stays_with_the_nearer_one_unless_the_other_has_it_clearly_more_alike(
    over: tuple[float, float], expected_s: float
) -> None:
    """The new film has it after the one and before the other; another bang may lie over it, softly or as loud."""
    old, new = film(40.0, (20.0,), seed=96), murmur(60.0, seed=97)
    shot, other = seconds(old, 19.9, 21.0), bang(seed=98)
    for at_s, share in zip((20.0, 40.0), over, strict=True):
        put(new, shot - seconds(new, at_s - 0.1, at_s + 1.0), at_s - 0.1)
        put(new, share * other, at_s)
    ends_s = (0.0, 0.0, 19.7), (20.0, 20.5, 40.0)
    courses = [
        Course(MatchedSegment(Line(1.0, late_s, first_s, last_s), first_s, last_s, 0.6), 1.0, 0.0, 4)
        for late_s, first_s, last_s in ends_s
    ]
    [found] = place([20.0], courses, heard(old), heard(new), load_conform())
    assert isinstance(found, Placed)
    assert found.new_s == pytest.approx(expected_s, abs=1e-4)


@pytest.mark.parametrize("shift", [0.0, 3_600.0])
def test_a_line_through_anchors_on_a_line_is_that_line_wherever_in_the_film_they_are(shift: float) -> None:
    x = shift + np.array([0.0, 7.0, 11.0, 30.0])
    slope, level = _fitted(x, 2e-5 * x - 0.25, np.array([1.0, 0.5, 2.0, 1.0]))
    assert slope == pytest.approx(2e-5, abs=1e-12)
    assert level == pytest.approx(-0.25, abs=1e-8)


@pytest.mark.parametrize("steep", [0.02, 0.2])
def test_anchors_that_are_ever_less_late_are_believed_as_those_that_are_ever_later(steep: float) -> None:
    """So steep no course can be: what lies on one like that is chance, whichever way it leads."""
    old_s = np.arange(9.0)
    late_s = np.array([0.0, 0.0, 0.0, *(steep * old_s[3:])])
    later, sooner = (consensus(Anchors(old_s, side * late_s, np.ones(9)), 0.001) for side in (1.0, -1.0))
    assert (later.slope, later.level_s) == (0.0, 0.0)
    assert (sooner.slope, sooner.level_s) == (0.0, 0.0)
    assert later.near.tolist() == sooner.near.tolist() == [True] * 3 + [False] * 6


AT_S = np.array([0.51, 8.42, 14.90, 16.74, 24.07, 27.27, 36.45, 38.37])
SHARPLY_LATE_S = -3.4825e-3 + 1e-6 * np.array([-0.3, -0.1, -0.1, 0.2, 0.0, 0.2, 0.1, 0.3])


@pytest.mark.parametrize("hummed", [0, 6])
@pytest.mark.parametrize("slope", [0.0, -3.24e-5])
def test_an_anchor_that_a_hum_has_put_aside_bends_no_line_that_the_others_are_sharp_on(
    hummed: int, slope: float
) -> None:
    late_s = slope * AT_S + SHARPLY_LATE_S
    late_s[hummed] += 0.74e-3
    likeness = np.array([0.97, 0.98, 0.97, 0.99, 0.97, 0.98, 0.97, 0.96])
    found = consensus(Anchors(AT_S, late_s, likeness), 0.5e-3)
    assert found.near.tolist() == [index != hummed for index in range(8)]
    assert found.slope == pytest.approx(slope, abs=1e-7)


@pytest.mark.parametrize("count", [5, 9, 20])
@pytest.mark.parametrize("off_s", [2e-6, 10e-6])
def test_anchors_that_lie_together_by_chance_lead_away_from_no_others(count: int, off_s: float) -> None:
    """Of some that are a little off, more than half may be on a line that misses the rest by half a millisecond."""
    for seed in range(100):
        rng = np.random.default_rng(seed)
        old_s, late_s = np.sort(rng.uniform(0.0, 100.0, count)), off_s * rng.standard_normal(count)
        found = consensus(Anchors(old_s, late_s, np.ones(count)), 0.5e-3)
        assert abs(found.level_s) < 8.0 * off_s
        assert abs(found.level_s + 100.0 * found.slope) < 8.0 * off_s


def test_of_three_anchors_none_is_dropped_for_two_that_are_on_a_line() -> None:
    found = consensus(Anchors(np.array([0.0, 10.0, 20.0]), np.array([0.0, 1e-4, -1e-4]), np.ones(3)), 0.5e-3)
    assert found.near.all()


@pytest.mark.parametrize("anchors", [(30, 4), (4, 30)])
def test_of_two_stretches_on_one_line_the_one_that_more_anchors_tell_of_has_the_say(anchors: tuple[int, int]) -> None:
    one, other = (
        Course(
            MatchedSegment(Line(1.0, 2.0 + late_s, start_s, start_s + 50.0), start_s, start_s + 50.0, 0.5), 1.0, 0.0, n
        )
        for start_s, late_s, n in zip((0.0, 50.0), (0.0, 4e-4), anchors, strict=True)
    )
    [whole] = joined([one, other])
    assert whole.segment.line == max(one, other, key=lambda course: course.anchors).segment.line
    assert (whole.segment.start_s, whole.segment.stop_s, whole.anchors) == (0.0, 100.0, 34)

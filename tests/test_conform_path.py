"""What of the old film is where in the new one: laws of cutting."""

import numpy as np
import pytest

from blastline.conform import (
    Course,
    Film,
    Loss,
    Lost,
    Placed,
    find_courses,
    find_segments,
    measured,
    place,
    with_exact_ends,
)
from blastline.conform.lines import Line
from blastline.conform.overlaps import Yielded, yielded
from blastline.conform.segments import MatchedSegment
from blastline.conform.states import NO_LINE, best_states
from blastline.ruleset import load_conform
from conform_films import RATE_HZ, Samples, bang, film, heard, murmur, put, seconds

ONSETS_S = (3.0, 8.5, 14.0, 21.0, 29.0, 33.3, 41.0, 47.0, 52.0, 57.0)
OLD = film(60.0, ONSETS_S, seed=20)


def courses(old: Film, new: Film) -> list[Course]:
    return find_courses(old, new)


def conformed(old: Samples, new: Samples, onsets_s: tuple[float, ...] = ONSETS_S) -> list[float | None]:
    """Return each onset's time in the new film, None where it was not placed."""
    one, other = heard(old), heard(new)
    found = place(onsets_s, courses(one, other), one, other, load_conform())
    return [each.new_s if isinstance(each, Placed) else None for each in found]


def near(times: list[float | None]) -> object:
    return [None if time is None else pytest.approx(time, abs=1e-4) for time in times]


@pytest.mark.parametrize("length_s", [9.0151, 12.337, 30.0])
@pytest.mark.parametrize("late_s", [0.0, 2.2037])
def test_a_stretch_reaches_from_one_end_of_the_film_to_the_other(length_s: float, late_s: float) -> None:
    """Ends are looked for in blocks, and no film is whole blocks long."""
    old = film(length_s, (3.0, length_s - 0.02), seed=23)
    new = np.concatenate([murmur(late_s, seed=24), old])
    [course] = courses(heard(old), heard(new))
    assert (course.segment.start_s, course.segment.stop_s) == pytest.approx((0.0, len(old) / RATE_HZ), abs=1e-4)


@pytest.mark.parametrize("left_s", [0.005, 0.01, 0.015, 0.3])
def test_a_stretch_ends_where_the_last_moments_of_a_film_are_others(left_s: float) -> None:
    old = film(20.013, (3.0, 15.0), seed=25)
    new = old.copy()
    new[-round(left_s * RATE_HZ) :] = 0.3 * np.random.default_rng(26).normal(size=round(left_s * RATE_HZ))
    [course] = courses(heard(old), heard(new))
    assert course.segment.stop_s == pytest.approx(20.013 - left_s, abs=0.02)
    assert course.segment.stop_s < 20.013


@pytest.mark.parametrize("early_s", [2.0, 3.0137, 4.0251])
def test_a_stretch_begins_where_the_new_film_does(early_s: float) -> None:
    old = film(20.0, (6.0, 15.0), seed=27)
    [course] = courses(heard(old), heard(old[round(early_s * RATE_HZ) :]))
    assert course.segment.start_s == pytest.approx(early_s, abs=1e-4)


def test_the_same_film_is_one_segment() -> None:
    [course] = courses(heard(OLD), heard(OLD))
    assert course.segment.line.scale == pytest.approx(1.0, abs=1e-7)
    assert course.segment.line.offset_s == pytest.approx(0.0, abs=1e-6)
    assert (course.segment.start_s, course.segment.stop_s) == pytest.approx((0.0, 60.0), abs=0.05)
    assert conformed(OLD, OLD) == near(list(ONSETS_S))


@pytest.mark.parametrize("seed", range(4))
def test_a_shot_on_the_first_sample_is_placed_there(seed: int) -> None:
    onsets_s = (0.0, 3.0, 7.5)
    old = film(10.0, onsets_s, seed=seed)
    times = conformed(old, old, onsets_s)
    assert times == near(list(onsets_s))
    assert all(time is not None and time >= 0.0 for time in times)


@pytest.mark.parametrize("kept_s", [(0.0, 6.0), (31.0, 60.0)])
def test_what_is_lost_is_listed_within_the_new_film(kept_s: tuple[float, float]) -> None:
    one, other = heard(OLD), heard(seconds(OLD, *kept_s))
    lost = [each for each in place(ONSETS_S, courses(one, other), one, other, load_conform()) if isinstance(each, Lost)]
    assert lost
    assert all(0.0 <= each.near_s <= other.duration_s for each in lost)


@pytest.mark.parametrize("offset", [-70_001, 3, 123_457])
def test_a_reel_offset_moves_every_shot_by_itself(offset: int) -> None:
    new = np.concatenate([murmur(20.0, seed=21)[:offset], OLD]) if offset > 0 else OLD[-offset:]
    shifted = [onset_s + offset / RATE_HZ for onset_s in ONSETS_S]
    assert conformed(OLD, new) == near([time if time >= 0.0 else None for time in shifted])


def test_removed_and_inserted_scenes_and_what_becomes_of_their_shots() -> None:
    new = np.concatenate([seconds(OLD, 0, 12), murmur(9.0, seed=22), seconds(OLD, 12, 26), seconds(OLD, 40, 60)])
    expected = [o if o < 12 else o + 9 if o < 26 else None if o < 40 else o - 5 for o in ONSETS_S]
    assert conformed(OLD, new) == near(expected)


@pytest.mark.parametrize(
    ("at_s", "frames"),
    [((25.0,), (-1,)), ((45.0,), (1,)), ((25.0,), (-0.5,)), ((18.0, 38.0), (-1, 1)), ((18.0, 38.0), (1, 1))],
    ids=["taken out", "put in", "half", "taken out and put in", "twice"],
)
def test_a_frame_that_was_taken_out_or_put_in_costs_no_shot(at_s: tuple[float, ...], frames: tuple[float, ...]) -> None:
    """At 24 frames a second, in the middle of a scene that goes on."""
    parts: list[Samples] = []
    done_s = 0.0
    for cut_s, count in zip(at_s, frames, strict=True):
        parts += [seconds(OLD, done_s, cut_s), murmur(max(0.0, count) / 24.0, seed=31)]
        done_s = cut_s + max(0.0, -count) / 24.0
    new = np.concatenate([*parts, seconds(OLD, done_s, 60.0)])
    moved_s = [sum(n / 24.0 for cut_s, n in zip(at_s, frames, strict=True) if cut_s < onset) for onset in ONSETS_S]
    assert conformed(OLD, new) == near([onset + by_s for onset, by_s in zip(ONSETS_S, moved_s, strict=True)])


def test_scenes_in_another_order_are_followed() -> None:
    new = np.concatenate([seconds(OLD, 0, 18), seconds(OLD, 38, 60), seconds(OLD, 18, 38)])
    expected = [o if o < 18 else o + 22 if o < 38 else o - 20 for o in ONSETS_S]
    assert conformed(OLD, new) == near(list(expected))


@pytest.mark.parametrize("speed", [25 / 24, 24 / 25, 1.001, 25.025 / 24, 1.022, 1.07, 0.93, 1.01, 0.99, 0.95, 1.034])
def test_any_speed_is_found(speed: float) -> None:
    import soxr

    new = soxr.resample(OLD, RATE_HZ * speed, RATE_HZ)
    [course] = courses(heard(OLD), heard(new))
    assert 1.0 / course.segment.line.scale == pytest.approx(speed, abs=2e-6)
    assert not course.keeps_pitch
    assert conformed(OLD, new) == near([onset_s / speed for onset_s in ONSETS_S])


def test_an_end_is_where_the_waveforms_part() -> None:
    new = np.concatenate([seconds(OLD, 0, 20.13), seconds(OLD, 35.71, 60)])
    first, second = courses(heard(OLD), heard(new))
    assert first.segment.stop_s == pytest.approx(20.13, abs=0.03)
    assert second.segment.start_s == pytest.approx(35.71, abs=0.03)


def test_a_copy_that_is_upside_down_is_the_same_film() -> None:
    """Some mixes are: a loudspeaker's wires do not matter, nor do they to where scenes end and which shots survive."""
    new = np.concatenate([seconds(OLD, 0, 20.13), murmur(5.0, seed=28), seconds(OLD, 35.71, 57.15)])
    spans = [
        [(each.segment.start_s, each.segment.stop_s) for each in courses(heard(OLD), heard(copy))]
        for copy in (new, -new)
    ]
    assert len(spans[0]) == 2
    assert spans[1] == [pytest.approx(span, abs=1e-6) for span in spans[0]]
    expected = [o if o < 20.13 else None if o < 35.71 else o - 10.58 for o in ONSETS_S]
    assert conformed(OLD, -new) == near(expected)


def test_a_burst_in_a_copy_that_is_upside_down_loses_just_the_shots_that_were_cut() -> None:
    shot, onsets_s = bang(seed=24), tuple(20.0 + 0.1 * n for n in range(10))
    old = murmur(40.0, seed=25)
    for onset_s in onsets_s:
        put(old, shot, onset_s)
    new = -np.concatenate([seconds(old, 0, 20.35), seconds(old, 20.65, 40)])
    expected = [o if o < 20.35 else None if o < 20.65 else o - 0.3 for o in onsets_s]
    assert conformed(old, new, onsets_s) == near(expected)


@pytest.mark.parametrize(("from_s", "to_s"), [(0.0, 20.0), (38.0, 60.0), (12.0, 31.0)])
def test_a_reel_that_is_upside_down_by_itself_changes_neither_ends_nor_shots(from_s: float, to_s: float) -> None:
    copy = OLD.copy()
    copy[round(from_s * RATE_HZ) : round(to_s * RATE_HZ)] *= -1.0
    [course] = courses(heard(OLD), heard(copy))
    assert (course.segment.start_s, course.segment.stop_s) == pytest.approx((0.0, 60.0), abs=0.03)
    assert conformed(OLD, copy) == near(list(ONSETS_S))


@pytest.mark.parametrize("offset", [0.05, -0.3])
def test_an_offset_of_the_new_film_is_no_sound(offset: float) -> None:
    """Old converters have one: quieter scenes than it are there all the same."""
    new = 0.2 * np.concatenate([seconds(OLD, 0, 20.13), seconds(OLD, 35.71, 60)]) + offset
    first, second = courses(heard(OLD), heard(new))
    assert (first.segment.start_s, first.segment.stop_s) == pytest.approx((0.0, 20.13), abs=0.03)
    assert (second.segment.start_s, second.segment.stop_s) == pytest.approx((35.71, 60.0), abs=0.03)
    expected = [o if o < 20.13 else None if o < 35.71 else o - 15.58 for o in ONSETS_S]
    assert conformed(OLD, new) == near(expected)


def test_of_two_equal_scenes_the_one_in_order_stays() -> None:
    scene = film(10.0, (2.0, 6.0), seed=23)
    old = np.concatenate([seconds(OLD, 0, 20), scene, seconds(OLD, 20, 40), scene, seconds(OLD, 40, 60)])
    onsets_s = (22.0, 26.0, 52.0, 56.0)
    without_first = np.concatenate([seconds(OLD, 0, 40), scene, seconds(OLD, 40, 60)])
    without_second = np.concatenate([seconds(OLD, 0, 20), scene, seconds(OLD, 20, 60)])
    assert conformed(old, without_first, onsets_s) == near([None, None, 42.0, 46.0])
    assert conformed(old, without_second, onsets_s) == near([22.0, 26.0, None, None])


def test_a_burst_of_one_sample_loses_just_the_shots_that_were_cut() -> None:
    shot, onsets_s = bang(seed=24), tuple(20.0 + 0.1 * n for n in range(10))
    old = murmur(40.0, seed=25)
    for onset_s in onsets_s:
        put(old, shot, onset_s)
    # three periods are taken out: what follows the cut sounds as what was taken out did
    new = np.concatenate([seconds(old, 0, 20.35), seconds(old, 20.65, 40)])
    expected = [o if o < 20.35 else None if o < 20.65 else o - 0.3 for o in onsets_s]
    assert conformed(old, new, onsets_s) == near(expected)
    before, after = courses(heard(old), heard(new))
    assert (before.segment.stop_s, after.segment.start_s) == pytest.approx((20.35, 20.65), abs=0.05)


def test_a_shot_whose_sound_was_replaced_is_listed_with_the_place_where_it_would_be() -> None:
    new = OLD.copy()
    first = round(28.9 * RATE_HZ)
    new[first : first + RATE_HZ] = murmur(1.0, seed=26)
    old, other = heard(OLD), heard(new)
    lost = place(ONSETS_S, courses(old, other), old, other, load_conform())[4]
    assert isinstance(lost, Lost)
    assert lost.reason in (Loss.CHANGED, Loss.REMOVED)
    assert lost.near_s == pytest.approx(29.0, abs=1.2)
    assert lost.likeness < 0.3


@pytest.mark.parametrize(("black_s", "is_there"), [(0.1, False), (0.03, False), (0.01, True)])
@pytest.mark.parametrize("gain", [1.0, 1e-5])
def test_a_shot_whose_bang_is_black_is_gone_though_its_end_is_there(
    black_s: float, is_there: bool, gain: float
) -> None:
    """One that lost some milliseconds of its attack is there; a softer copy is black nowhere."""
    new = OLD.copy()
    new[round(28.6 * RATE_HZ) : round((29.0 + black_s) * RATE_HZ)] = 0.0
    found = conformed(OLD, gain * new)
    expected = [None if onset_s == 29.0 and not is_there else onset_s for onset_s in ONSETS_S]
    assert found == near(list(expected))


@pytest.mark.parametrize(("replaced_s", "is_there"), [(0.1, False), (0.06, False), (0.03, False), (0.005, True)])
@pytest.mark.parametrize("seed", [91, 92, 93])
def test_a_shot_whose_bang_is_another_sound_is_gone_though_its_decay_is_there(
    replaced_s: float, is_there: bool, seed: int
) -> None:
    """What is put over the bang, and is no louder, leaves the shot where it is."""
    rng = np.random.default_rng(seed)
    old = OLD.copy()
    put(old, 0.3 * np.exp(-np.arange(RATE_HZ) / (0.2 * RATE_HZ)) * rng.normal(size=RATE_HZ), 29.0)
    first, stop = round(28.998 * RATE_HZ), round((29.0 + replaced_s) * RATE_HZ)
    sound = rng.normal(size=stop - first) * np.sqrt(np.mean(old[first:stop] ** 2))
    new, covered = old.copy(), old.copy()
    new[first:stop], covered[first:stop] = sound, old[first:stop] + sound
    expected = [None if onset_s == 29.0 and not is_there else onset_s for onset_s in ONSETS_S]
    assert conformed(old, new) == near(list(expected))
    assert conformed(old, covered) == near(list(ONSETS_S))


@pytest.mark.parametrize("seed", [91, 92, 93])
def test_a_shot_that_swells_is_there_though_another_sound_covers_its_soft_beginning(seed: int) -> None:
    """What lies over the whole of it covers the beginning more, and is no reason to take it for another shot."""
    rng = np.random.default_rng(seed)
    old, boom = OLD.copy(), rng.normal(size=round(0.2 * RATE_HZ))
    boom *= np.where(np.arange(boom.size) < 0.03 * RATE_HZ, 0.05, 0.4)
    old[round(29.0 * RATE_HZ) : round(29.3 * RATE_HZ)] = 0.0
    put(old, boom, 29.0)
    new = old.copy()
    put(new, 0.2 * rng.normal(size=round(0.3 * RATE_HZ)), 28.95)
    assert conformed(old, new) == near(list(ONSETS_S))


@pytest.mark.parametrize("seed", [91, 92, 93])
def test_a_shot_is_held_to_its_own_sound_as_far_as_the_next_one(seed: int) -> None:
    """Another bang in place of the next shot, and far louder, says nothing of it."""
    onsets_s, rng = (10.0, 29.0, 29.08, 40.0), np.random.default_rng(seed)
    old = film(50.0, onsets_s, seed=seed)
    new = old.copy()
    there = slice(round(29.075 * RATE_HZ), round(29.4 * RATE_HZ))
    new[there] = rng.normal(size=there.stop - there.start)
    assert conformed(old, new, onsets_s) == near([10.0, 29.0, None, 40.0])


@pytest.mark.parametrize("attack", [0.25, 0.35, 0.6, 1.0])
@pytest.mark.parametrize("seed", [91, 92, 93])
def test_a_soft_bang_is_gone_where_another_sound_is_and_there_beneath_a_louder_one(attack: float, seed: int) -> None:
    """As that of a shot before loud reflections: what is put over it leaves all of it there."""
    rng, at_s = np.random.default_rng(seed), 25.0
    old, shot = OLD.copy(), 0.3 * np.exp(-np.arange(RATE_HZ) / (0.2 * RATE_HZ)) * rng.normal(size=RATE_HZ)
    shot[: round(0.02 * RATE_HZ)] *= attack
    put(old, shot, at_s)
    bang = slice(round((at_s - 0.002) * RATE_HZ), round((at_s + 0.02) * RATE_HZ))
    sound = rng.normal(size=bang.stop - bang.start) * np.sqrt(np.mean(old[bang] ** 2))
    replaced, covered = old.copy(), old.copy()
    replaced[bang] = sound
    covered[bang] += 4.0 * sound
    assert conformed(old, replaced, (*ONSETS_S, at_s)) == near([*ONSETS_S, None])
    assert conformed(old, covered, (*ONSETS_S, at_s)) == near([*ONSETS_S, at_s])


def test_an_onset_in_silence_before_its_bang_is_placed_by_the_bang() -> None:
    """Somebody may have put it there: nothing is due of its first 20 ms."""
    old, at_s = OLD.copy(), 25.0
    old[round((at_s - 0.2) * RATE_HZ) : round((at_s + 0.06) * RATE_HZ)] = 0.0
    put(old, 0.3 * np.random.default_rng(94).normal(size=RATE_HZ // 10), at_s + 0.06)
    assert conformed(old, old, (*ONSETS_S, at_s)) == near([*ONSETS_S, at_s])


def test_films_with_nothing_in_common_have_no_segment() -> None:
    assert courses(heard(OLD), heard(film(50.0, (10.0, 20.0), seed=27))) == []


def test_of_two_claims_to_one_place_the_shorter_and_the_one_out_of_order_give_way() -> None:
    first, last = Line(1.0, 0.0, 0.0, 20.0), Line(1.0, -10.0, 30.0, 60.0)
    ordered = [MatchedSegment(first, 0.0, 20.0, 0.9), MatchedSegment(last, 30.0, 60.0, 0.9)]
    assert yielded(ordered, ()) == []
    stray = MatchedSegment(Line(1.0, 15.0, 20.0, 30.0), 22.0, 29.0, 1.0)  # where the last one is from 47 to 54
    assert yielded([ordered[0], stray, ordered[1]], ()) == [Yielded(1, 22.0, 29.0)]


def moved(by_s: float, start_s: float, stop_s: float) -> Course:
    """Return a scene that comes so much later."""
    return Course(MatchedSegment(Line(1.0, by_s, start_s, stop_s), start_s, stop_s, 0.95), 1.0, 0.0, 9)


def test_a_removed_shot_does_not_take_the_like_sound_of_the_scene_that_follows_the_cut() -> None:
    """Nobody asks for that sound, and it is accounted for: it is of the scene that is there."""
    old = murmur(60.0, seed=81)
    old[20 * RATE_HZ : 30 * RATE_HZ] *= 0.02
    put(old, bang(seed=82), 20.2)
    old[30 * RATE_HZ : round(30.6 * RATE_HZ)] = seconds(old, 20.0, 20.6)
    new = np.concatenate([seconds(old, 0.0, 20.0), seconds(old, 30.0, 60.0)])
    scenes = [moved(0.0, 0.0, 20.0), moved(-10.0, 30.0, 60.0)]
    [lost] = place([20.2], scenes, heard(old), heard(new), load_conform())
    assert isinstance(lost, Lost)
    [found] = place([30.2], scenes, heard(old), heard(new), load_conform())
    assert isinstance(found, Placed)
    assert found.new_s == pytest.approx(20.2, abs=1e-4)


def test_what_two_segments_share_of_the_new_film_counts_once() -> None:
    early = MatchedSegment(Line(1.0, 10.0, 0.0, 20.0), 0.0, 20.0, 0.9)  # from 10 to 30
    long = MatchedSegment(Line(1.0, -12.5, 22.0, 47.0), 22.0, 47.5, 0.8)  # from 9.5 to 35
    last = MatchedSegment(Line(1.0, -20.0, 50.0, 80.0), 50.0, 80.0, 0.9)  # from 30 to 60
    assert {part.index for part in yielded([early, long, last], ())} == {1}, "5 s of the long one are the last one's"


def repeating(length_s: float, *, seed: int) -> Samples:
    """Return a film in which one passage comes again every 6.13 s, under sound of its own."""
    phrase = film(6.13, (1.0, 3.5), seed=seed)
    under = np.resize(phrase, round(length_s * RATE_HZ))
    return np.asarray(murmur(length_s, seed=seed + 1) + 0.5 * under)


@pytest.mark.parametrize("from_s", [14.3, 17.9, 21.2, 24.7, 28.6, 32.1])
@pytest.mark.parametrize("removed_s", [12.2, 18.45, 21.0])
def test_a_single_removal_leaves_both_sides_whole_where_a_passage_repeats(from_s: float, removed_s: float) -> None:
    old = repeating(75.0, seed=70)
    new = np.concatenate([seconds(old, 0.0, from_s), seconds(old, from_s + removed_s, 75.0)])
    one, other = heard(old), heard(new)
    first, second = find_segments(one.fingerprint, other.fingerprint)
    assert first.stop_s > from_s - 0.7
    assert second.start_s < from_s + removed_s + 0.7
    before, after = with_exact_ends(measured([first, second], one, other), one, other)
    assert (before.segment.start_s, before.segment.stop_s) == pytest.approx((0.0, from_s), abs=0.1)
    assert (after.segment.start_s, after.segment.stop_s) == pytest.approx((from_s + removed_s, 75.0), abs=0.1)
    assert before.segment.line.at(from_s / 2) == pytest.approx(from_s / 2, abs=1e-4)
    assert after.segment.line.at(70.0) == pytest.approx(70.0 - removed_s, abs=1e-4)


@pytest.mark.parametrize(("from_s", "length_s"), [(20.0, 11.0), (37.4, 4.0), (50.0, 3.0), (31.0, 20.0)])
@pytest.mark.parametrize("speed", [0.996, 1.004])
def test_a_line_that_was_found_a_step_beside_its_speed_comes_back_to_it(
    from_s: float, length_s: float, speed: float
) -> None:
    old = repeating(75.0, seed=74)
    new = seconds(old, from_s, from_s + length_s)
    middle_s, scale = from_s + length_s / 2, 1.0 / speed
    line = Line(scale, length_s / 2 - scale * middle_s, middle_s, middle_s)
    [course] = measured([MatchedSegment(line, from_s, from_s + length_s, 0.85)], heard(old), heard(new))
    assert course.segment.line.scale == pytest.approx(1.0, abs=1e-5)
    assert course.agree_s <= 1.0 / RATE_HZ
    assert not course.keeps_pitch
    assert course.segment.line.at(middle_s) == pytest.approx(length_s / 2, abs=1e-5)


@pytest.mark.parametrize("scenes_s", [(17.0, 26.5, 40.2, 44.5), (3.3, 15.0, 50.0, 58.1), (62.0, 66.4)])
def test_an_excerpt_is_at_its_own_speed_with_every_shot(scenes_s: tuple[float, ...]) -> None:
    old = repeating(75.0, seed=76)
    onsets_s = (4.0, 7.1, 18.2, 21.9, 42.0, 51.3, 55.5, 64.1)
    for number, onset_s in enumerate(onsets_s):
        put(old, bang(seed=900 + number), onset_s)
    scenes = list(zip(scenes_s[::2], scenes_s[1::2], strict=True))
    new = np.concatenate([seconds(old, *scene) for scene in scenes])
    at_s = np.cumsum([0.0, *(stop_s - start_s for start_s, stop_s in scenes)])
    expected = [
        next(
            (a + o - start_s for a, (start_s, stop_s) in zip(at_s, scenes, strict=False) if start_s < o < stop_s), None
        )
        for o in onsets_s
    ]
    assert conformed(old, new, onsets_s) == near(expected)
    for course in courses(heard(old), heard(new)):
        assert course.segment.line.scale == pytest.approx(1.0, abs=1e-5)
        assert course.agree_s <= 1.0 / RATE_HZ


def test_neighbours_that_linger_past_the_cut_between_them_lose_to_nothing_else() -> None:
    before = MatchedSegment(Line(1.0, 0.0, 0.0, 36.0), 0.0, 36.6, 0.99)
    after = MatchedSegment(Line(1.0, -36.7, 73.0, 180.0), 72.2, 180.0, 0.99)
    stray = MatchedSegment(Line(1.0, -26.0, 45.0, 60.0), 45.0, 60.0, 0.7)  # where the two meet
    lost = yielded([before, stray, after], ())
    assert any(part.index == 1 and part.stop_s - part.start_s > 14.0 for part in lost)
    assert all(part.index == 1 or part.stop_s - part.start_s < 1.2 for part in lost)


def kept_pitch(length_s: float) -> Course:
    """Return the course of a film that was made 4 % shorter with its pitch kept."""
    return Course(MatchedSegment(Line(0.96, 0.0, 0.0, length_s), 0.0, length_s, 0.9), 1.0, 0.01, 9)


def test_with_kept_pitch_an_attack_is_found_where_its_piece_was_moved_to() -> None:
    old, new = murmur(20.0, seed=60), murmur(19.2, seed=61)
    put(old, bang(seed=62), 10.0)
    put(new, bang(seed=62)[: RATE_HZ // 25], 9.612)
    put(new, bang(seed=62)[RATE_HZ // 25 :], 9.640)  # the rest of it was moved elsewhere
    [found] = place([10.0], [kept_pitch(20.0)], heard(old), heard(new), load_conform())
    assert isinstance(found, Placed)
    assert found.new_s == pytest.approx(9.612, abs=1e-4)


def test_with_kept_pitch_a_shot_in_a_hum_is_listed_for_it_may_be_anywhere() -> None:
    def hum(length_s: float) -> np.ndarray:
        return 0.3 * np.sin(2.0 * np.pi * 300.0 * np.arange(round(length_s * RATE_HZ)) / RATE_HZ)

    old, new = hum(20.0) + 0.01 * murmur(20.0, seed=63), hum(19.2) + 0.01 * murmur(19.2, seed=64)
    [lost] = place([10.0], [kept_pitch(20.0)], heard(old), heard(new), load_conform())
    assert isinstance(lost, Lost)
    assert lost.likeness > 0.9
    assert lost.reason is Loss.CHANGED


def test_the_path_is_the_best_of_all_paths() -> None:
    rng = np.random.default_rng(28)
    for _ in range(20):
        gain = rng.normal(0.0, 6.0, (6, 2)).astype(np.float32)
        first, last = sorted(rng.choice(7, 2, replace=False))  # the second lane is there for some steps only
        there = gain.copy()
        there[:first, 1] = there[last:, 1] = -100.0
        best = max(_worth(there, path) for path in np.ndindex(*[3] * 6))
        states = best_states([0, int(first)], [gain[:, 0], gain[first:last, 1]], 6, cost=8.0)
        path = tuple(2 if state == NO_LINE else int(state) for state in states)
        assert _worth(there, path) == pytest.approx(best, abs=1e-4)


def _worth(gain: np.ndarray, path: tuple[int, ...]) -> float:
    """Return what a path gains, less 8 for each line it changes to; state 2 is no line."""
    entered = [after for before, after in zip((2, *path), path, strict=False) if before != after and after != 2]
    return float(sum(gain[n, state] for n, state in enumerate(path) if state != 2) - 8.0 * len(entered))

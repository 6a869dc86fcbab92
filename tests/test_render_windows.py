"""Windows: from their fades in to their fades out, joined where they meet, and never into an onset."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from blastline.model import Shot, Span, Window
from blastline.render import plan_windows, window_between
from blastline.ruleset import WindowRules
from render_signals import WINDOWS, shot_at

RATE_HZ = 1000  # one sample is one millisecond
RULES = WindowRules("test", fade_in_ms=5.0, guard_ms=1.0, fade_out_ms=40.0)


def shots(*spans: tuple[int, int]) -> list[Shot]:
    return [
        msgspec.structs.replace(shot_at(start), blast=Span(start, start), span=Span(start, stop))
        for start, stop in spans
    ]


def windows(found: list[Shot], frames: int = 1000) -> list[Window]:
    return [planned.window for planned in plan_windows(found, frames=frames, rate_hz=RATE_HZ, rules=RULES)]


def test_window_reaches_from_its_fade_in_to_its_fade_out() -> None:
    assert windows(shots((100, 300))) == [Window(94, 340, 5, 40)]


def test_film_without_shots_has_no_window() -> None:
    assert plan_windows([], frames=1000, rate_hz=RATE_HZ, rules=RULES) == ()


@pytest.mark.parametrize(("onset", "fade_in"), [(0, 0), (1, 0), (2, 1), (5, 4), (6, 5), (7, 5)])
def test_fade_in_shrinks_to_the_room_before_the_onset(onset: int, fade_in: int) -> None:
    (window,) = windows(shots((onset, onset + 100)))
    assert (window.start, window.fade_in_samples) == (max(0, onset - 6), fade_in)


@pytest.mark.parametrize(("stop", "fade_out"), [(1000, 0), (1300, 0), (999, 1), (960, 40), (959, 40)])
def test_fade_out_shrinks_to_the_room_after_the_decay(stop: int, fade_out: int) -> None:
    (window,) = windows(shots((500, stop)))
    assert (window.stop, window.fade_out_samples) == (min(1000, stop + 40), fade_out)


def test_shot_on_the_last_frame_has_a_window() -> None:
    assert windows(shots((999, 999))) == [Window(993, 1000, 5, 0)]


def test_film_of_one_frame_has_a_window_of_one_frame() -> None:
    assert windows(shots((0, 400)), frames=1) == [Window(0, 1, 0, 0)]


@pytest.mark.parametrize(("second", "count"), [(345, 1), (346, 1), (347, 2)])
def test_windows_that_touch_or_overlap_are_one(second: int, count: int) -> None:
    found = plan_windows(shots((100, 300), (second, 500)), frames=1000, rate_hz=RATE_HZ, rules=RULES)
    assert len(found) == count
    assert [index for planned in found for index in planned.shots] == [0, 1]
    assert found[0].window.fade_in_samples == 5
    assert found[-1].window == Window(94 if count == 1 else second - 6, 540, 5, 40)


def test_shot_inside_another_does_not_shorten_the_window() -> None:
    assert windows(shots((100, 500), (200, 250))) == [Window(94, 540, 5, 40)]


def test_shots_are_named_by_their_place_in_the_list_not_in_time() -> None:
    found = plan_windows(shots((600, 700), (100, 200)), frames=1000, rate_hz=RATE_HZ, rules=RULES)
    assert [planned.shots for planned in found] == [(1,), (0,)]


def test_shot_outside_the_film_is_refused() -> None:
    with pytest.raises(ValueError, match="shot 0 begins at sample 1000, outside the film's 1000 frames"):
        windows(shots((1000, 1100)))


@given(
    st.lists(st.tuples(st.integers(0, 1999), st.integers(0, 400)), max_size=20),
    st.sampled_from([RULES, WINDOWS, WindowRules("test", fade_in_ms=0.0, guard_ms=0.0, fade_out_ms=0.0)]),
)
def test_windows_are_sorted_disjoint_inside_and_hold_every_shot(
    places: list[tuple[int, int]], rules: WindowRules
) -> None:
    found = shots(*((start, start + length) for start, length in places))
    planned = plan_windows(found, frames=2000, rate_hz=RATE_HZ, rules=rules)
    bounds = [edge for each in planned for edge in (each.window.start, each.window.stop)]
    assert bounds == sorted(set(bounds)), "sorted, and not even touching"
    assert all(0 <= bound <= 2000 for bound in bounds)
    assert sorted(index for each in planned for index in each.shots) == list(range(len(found)))
    for each in planned:
        for index in each.shots:
            shot = found[index]
            assert each.core.start <= shot.onset < each.core.stop
            assert min(shot.span.stop, 2000) <= each.core.stop
        onsets = [found[index].onset for index in each.shots]
        assert onsets == sorted(onsets)


@given(st.lists(st.tuples(st.integers(60, 160), st.integers(0, 60), st.integers(0, 60)), min_size=2, max_size=5))
def test_no_fade_reaches_into_an_onset_however_windows_join(drawn: list[tuple[int, int, int]]) -> None:
    """Of windows that somebody has set, one that begins later may be an earlier shot's."""
    found = shots(*((onset, onset + length) for onset, length, _ in drawn))
    own = {
        index: Window(onset - before, onset + length + 40, before, 0)
        for index, (onset, length, before) in enumerate(drawn)
    }
    for planned in plan_windows(found, frames=1000, rate_hz=RATE_HZ, rules=RULES, given=own):
        first = min(found[index].onset for index in planned.shots)
        assert planned.window.start + planned.window.fade_in_samples <= first


@pytest.mark.parametrize("before", [*range(10), 100, 3000])
def test_a_start_that_somebody_sets_long_before_the_onset_fades_in_no_slower(before: int) -> None:
    """What sounds before the onset is then wanted in full, but for the fade."""
    (shot,) = shots((3000, 3100))
    window = window_between(shot, start=3000 - before, stop=None, frames=5000, rate_hz=RATE_HZ, rules=RULES)
    assert window == Window(3000 - before, 3140, min(5, max(0, before - 1)), 40)


@pytest.mark.parametrize("sounding", [1, 20, 400])
@pytest.mark.parametrize("after", [1, 2, 3, 10, 39, 40, 41, 79, 80, 90])
def test_a_fade_out_that_somebody_has_set_takes_at_most_half_of_what_is_left_of_a_later_shot(
    sounding: int, after: int
) -> None:
    found = shots((100, 150), (300, 300 + sounding))
    own = {0: Window(94, 300 + after, 5, 40), 1: Window(294, 300 + max(1, after - 1), 5, 0)}
    (planned,) = plan_windows(found, frames=1000, rate_hz=RATE_HZ, rules=RULES, given=own)
    assert planned.window == Window(94, 300 + after, 5, min(40, max(after - sounding, after // 2)))


def test_no_fade_out_begins_on_an_onset_of_a_shot_without_length() -> None:
    given = {1: Window(332, 339, 5, 0)}
    found = plan_windows(shots((100, 300), (338, 338)), frames=1000, rate_hz=RATE_HZ, rules=RULES, given=given)
    assert [(each.window.stop, each.window.fade_out_samples) for each in found] == [(340, 1)]


@pytest.mark.parametrize("fades", [(10, 30), (30, 10)])
def test_of_two_windows_that_end_together_the_shorter_fade_holds(fades: tuple[int, int]) -> None:
    given = {index: Window(94 + 20 * index, 500, 5, fade) for index, fade in enumerate(fades)}
    (planned,) = plan_windows(shots((100, 200), (120, 220)), frames=1000, rate_hz=RATE_HZ, rules=RULES, given=given)
    assert planned.window == Window(94, 500, 5, 10)


def test_a_battle_without_a_pause_is_one_window() -> None:
    fire = shots(*((100 * number, 100 * number + 400) for number in range(8000)))
    (battle,) = plan_windows(fire, frames=801_000, rate_hz=RATE_HZ, rules=RULES)
    assert battle.shots == tuple(range(8000))
    assert battle.window == Window(0, 799_900 + 400 + 40, 0, 40)

"""Windows and levels that somebody has set by hand: they are what was asked for, and joining loses nothing of them."""

from dataclasses import replace
from itertools import pairwise

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from blastline.model import DriveModel, Shot, Span, Window
from blastline.render import hear_window, needed_audio, plan_windows, render_window, window_between, with_gains
from blastline.ruleset import WindowRules
from render_signals import CAUSAL, RATE_HZ, RENDER, WINDOWS, clip, film_with_shot, shot_at

RULES = WindowRules("test", fade_in_ms=5.0, guard_ms=1.0, fade_out_ms=40.0)
FRAMES = 2000


def shot(onset: int, stop: int) -> Shot:
    return msgspec.structs.replace(shot_at(onset), blast=Span(onset, onset), span=Span(onset, stop))


def between(start: int | None, stop: int | None) -> Window:
    """Return the window of a shot at 500 to 700 with these ends, at a sample for each millisecond."""
    return window_between(shot(500, 700), start=start, stop=stop, frames=FRAMES, rate_hz=1000, rules=RULES)


@pytest.mark.parametrize(
    ("start", "stop", "window"),
    [
        (None, None, Window(494, 740, 5, 40)),
        (None, 600, Window(494, 600, 5, 40)),
        (400, None, Window(400, 740, 5, 40)),
        (497, None, Window(497, 740, 2, 40)),
        (500, None, Window(500, 740, 0, 40)),
        (None, 521, Window(494, 521, 5, 10)),
        (None, 501, Window(494, 501, 5, 0)),
        (400, 2000, Window(400, 2000, 5, 40)),
    ],
)
def test_an_end_is_where_it_was_set_and_fades_shrink_to_the_room(
    start: int | None, stop: int | None, window: Window
) -> None:
    assert between(start, stop) == window


@pytest.mark.parametrize(("start", "stop"), [(501, None), (None, 500), (None, 2001)])
def test_an_end_beside_its_onset_or_film_is_refused(start: int | None, stop: int | None) -> None:
    with pytest.raises(ValueError, match="does not hold the onset at 500"):
        between(start, stop)


@given(st.data())
def test_any_given_windows_are_joined_without_losing_a_sample_or_an_attack(data: st.DataObject) -> None:
    onsets = data.draw(st.lists(st.integers(0, FRAMES - 1), min_size=1, max_size=6, unique=True))
    shots = [shot(onset, min(FRAMES, onset + data.draw(st.integers(1, 300)))) for onset in sorted(onsets)]
    given_windows = {}
    for index, each in enumerate(shots):
        if data.draw(st.booleans()):
            start = data.draw(st.none() | st.integers(max(0, each.onset - 200), each.onset))
            stop = data.draw(st.none() | st.integers(each.onset + 1, FRAMES))
            given_windows[index] = window_between(
                each, start=start, stop=stop, frames=FRAMES, rate_hz=1000, rules=RULES
            )
    planned = plan_windows(shots, frames=FRAMES, rate_hz=1000, rules=RULES, given=given_windows)
    alone = plan_windows(shots, frames=FRAMES, rate_hz=1000, rules=RULES)
    assert sorted(index for each in planned for index in each.shots) == list(range(len(shots)))
    for first, second in pairwise(planned):
        assert first.window.stop < second.window.start
    for joined in planned:
        own = [shots[index] for index in joined.shots]
        assert [one.onset for one in own] == sorted(one.onset for one in own)
        assert joined.core.start <= own[0].onset
        assert own[-1].onset < joined.core.stop <= joined.window.stop <= FRAMES
        for index in joined.shots:
            window = given_windows.get(index)
            assert window is None or window.span | joined.window.span == joined.window.span
    if not given_windows:
        assert planned == alone


@pytest.mark.parametrize("model", ["direct", "filter", "constrained"])
def test_a_gain_scales_what_its_shot_drives_and_nothing_before_it(model: DriveModel) -> None:
    film, first = film_with_shot(peak=0.02)
    film = np.concatenate([film, film])
    shots = [first, msgspec.structs.replace(first, onset=first.onset + len(film) // 2)]
    shots = [
        msgspec.structs.replace(shots[0], span=Span(first.onset, shots[1].onset)),
        msgspec.structs.replace(shots[1], span=Span(shots[1].onset, len(film))),
    ]
    [planned] = plan_windows(shots, frames=len(film), rate_hz=RATE_HZ, rules=WINDOWS)

    def drive(*gains_db: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        [asked] = with_gains([planned], shots, gains_db)
        audio = clip(film).slice(needed_audio(asked, frames=len(film), filters=CAUSAL, rules=RENDER))
        heard = hear_window(audio, asked, filters=CAUSAL, rules=RENDER)
        done = render_window(heard, shots, model=model, reason="", background="mute")
        return np.asarray(done.clip.samples[:, 0], np.float64)

    usual, louder = drive(0.0, 0.0), drive(0.0, 6.0)
    turn = shots[1].onset - planned.window.start
    lead = RATE_HZ // 1000
    np.testing.assert_array_equal(louder[: turn - 10 * lead], usual[: turn - 10 * lead])
    after = slice(turn, turn + RATE_HZ // 20)
    ratio = np.linalg.norm(louder[after]) / np.linalg.norm(usual[after])
    assert ratio == pytest.approx(10.0**0.3, rel=0.02)
    whole = np.linalg.norm(drive(-6.0, -6.0)) / np.linalg.norm(usual)
    assert whole == pytest.approx(10.0**-0.3, rel=0.02)


def test_a_shot_wanted_softer_is_softer_though_the_window_is_scaled_to_the_limit() -> None:
    """The compensator of this one needs five times the limit: its gain is not what brings it back to it."""
    film, only = film_with_shot(peak=0.9)
    [planned] = plan_windows([only], frames=len(film), rate_hz=RATE_HZ, rules=WINDOWS)

    def drive(gain_db: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        [asked] = with_gains([planned], [only], [gain_db])
        heard = hear_window(clip(film), asked, filters=CAUSAL, rules=RENDER)
        done = render_window(heard, [only], model="filter", reason="", background="mute")
        return np.asarray(done.clip.samples[:, 0], np.float64)

    usual = drive(0.0)
    assert np.max(np.abs(usual)) == 1.0
    for gain_db in (-1.0, -6.0, -20.0):
        np.testing.assert_allclose(drive(gain_db), 10.0 ** (gain_db / 20.0) * usual, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(drive(6.0), usual, rtol=1e-9, atol=1e-12, err_msg="louder than the limit it cannot be")


@pytest.mark.parametrize("gains_db", [(0.0, 6.0), (-12.0, 6.0), (12.0, -6.0)])
def test_a_gain_is_reached_over_the_lead_and_without_a_step(gains_db: tuple[float, float]) -> None:
    film, first = film_with_shot(peak=0.1)
    shots = [first, shot_at(first.onset + RATE_HZ // 10)]
    [planned] = with_gains(plan_windows(shots, frames=len(film), rate_hz=RATE_HZ, rules=WINDOWS), shots, gains_db)
    gains = hear_window(clip(film), planned, filters=CAUSAL, rules=RENDER).gains
    before, after = (10.0 ** (gain_db / 20.0) for gain_db in gains_db)
    onset, lead = shots[1].onset - planned.window.start, RATE_HZ // 1000
    np.testing.assert_allclose(gains[: onset - lead], before, rtol=1e-12)
    np.testing.assert_allclose(gains[onset:], after, rtol=1e-12)
    assert np.max(np.abs(np.diff(gains))) <= abs(after - before) / lead * (1.0 + 1e-9)


@pytest.mark.parametrize(
    ("later", "fade_out"),
    [
        (shot(980, 985), 15),  # it has died away before half of the room is over
        (shot(980, 1100), 10),
        (shot(959, 1100), 20),  # one sample before the fade-out would begin, which would leave it that sample
        (shot(940, 950), 40),
    ],
)
def test_a_fade_out_leaves_a_later_shot_its_sound_or_half_of_the_room(later: Shot, fade_out: int) -> None:
    """The window that was set for the first shot fades out from 960 to 1000; the later one's ends before it."""
    settled = {0: Window(494, 1000, 5, 40), 1: Window(934, 995, 5, 5)}
    [joined] = plan_windows([shot(500, 700), later], frames=FRAMES, rate_hz=1000, rules=RULES, given=settled)
    assert joined.window == Window(494, 1000, 5, fade_out)


def test_windows_without_a_gain_stay_as_they_are() -> None:
    shots = [shot(100, 300), shot(900, 1000)]
    planned = plan_windows(shots, frames=FRAMES, rate_hz=1000, rules=RULES)
    assert with_gains(planned, shots, [0.0, 0.0]) == planned
    assert with_gains(planned, shots, [0.0, 3.0]) == (planned[0], replace(planned[1], gains=((900, 3.0),)))

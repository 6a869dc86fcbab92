"""Windows of a film cut anew near its end, where a planned fade-out has less room than the rules give it."""

import msgspec
import pytest

from blastline.conform import Retimed
from blastline.model import Event, Shot, Source, Span
from blastline.render import plan_windows
from blastline.ruleset import load_rules
from blastline.run.conforming_events import moved_events
from render_signals import RATE_HZ, WINDOWS, shot_at
from timelines import SHOT

RULES = load_rules("standard")
FRAMES = 2 * RATE_HZ
FADE_OUT = round(WINDOWS.fade_out_ms * RATE_HZ / 1000.0)


def moved(shot: Shot, stop: int) -> Event:
    """Return a shot as an event of the new film, in which its old window ends at `stop`."""
    source = Source("new.wav", "cd" * 32, RATE_HZ, FRAMES, 1)
    [event] = moved_events([(SHOT, Retimed(shot, shot.onset - 288, stop))], set(), source, RULES)
    return event


@pytest.mark.parametrize("before_end", [0, 1, RATE_HZ // 1000, FADE_OUT // 2, FADE_OUT - 1, FADE_OUT, FADE_OUT + 1])
@pytest.mark.parametrize("length_ms", [10, 400])
def test_the_end_of_the_film_is_no_end_that_somebody_has_set(before_end: int, length_ms: int) -> None:
    sounding = FRAMES - before_end
    onset = sounding - length_ms * RATE_HZ // 1000
    shot = msgspec.structs.replace(shot_at(onset), span=Span(onset, sounding))
    [planned] = plan_windows([shot], frames=FRAMES, rate_hz=RATE_HZ, rules=WINDOWS)
    assert moved(shot, planned.window.stop).window == planned.window


@pytest.mark.parametrize("before_end", [0, 1, FADE_OUT // 2])
def test_an_end_that_somebody_has_set_just_before_that_of_the_film_is_kept(before_end: int) -> None:
    onset, sounding = FRAMES - RATE_HZ // 4, FRAMES - before_end
    shot = msgspec.structs.replace(shot_at(onset), span=Span(onset, sounding))
    for stop in (FRAMES - 1, FRAMES - 480, onset + 480):
        assert moved(shot, stop).window.stop == stop

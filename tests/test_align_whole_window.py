"""A drive is held to what is due from its window's first sample to its last: before the bang, and as it fades out."""

import msgspec
import numpy as np
import pytest

from align_films import RATE_HZ, Film, Samples, checks_of, failed, make_film, weights_of
from blastline import dsp
from blastline.align.hearing import _fallen, _risen
from blastline.model import Background, DriveModel, Event, Origin, Span, Window
from timelines import SHOT

EARLIER = round(0.3 * RATE_HZ)


def booming(model: DriveModel | None, background: Background) -> Film:
    """Return shots whose tail goes on into the fade-out: three with the compensator's drive, and one at the limit."""
    return make_film(model=model, background=background, tail=1.0, bed=1e-3)


def thump(length: int, peak: float) -> Samples:
    return np.asarray(peak * np.sin(2.0 * np.pi * 100.0 / RATE_HZ * np.arange(length)), np.float64)


@pytest.mark.parametrize("background", ["mute", "direct"])
@pytest.mark.parametrize("model", [None, "direct"])
@pytest.mark.parametrize("index", [1, 3])
def test_what_sounds_in_a_fade_out_has_to_be_due(index: int, model: DriveModel | None, background: Background) -> None:
    right = booming(model, background)
    assert failed(checks_of(right, background=background)) == set()
    window = right.timeline.events[index].window
    fade = slice(window.stop - window.fade_out_samples, window.stop)
    drive = right.drive.samples.copy()
    drive[fade] += weights_of(window)[-window.fade_out_samples :] * thump(window.fade_out_samples, 0.4)
    assert "drive_as_rendered" in failed(checks_of(right.with_drive(drive), background=background))


@pytest.mark.parametrize("model", [None, "direct"])
@pytest.mark.parametrize("index", [1, 3])
def test_silence_in_place_of_a_fade_out_fails(index: int, model: DriveModel | None) -> None:
    right = booming(model, "mute")
    window = right.timeline.events[index].window
    drive = right.drive.samples.copy()
    drive[window.stop - window.fade_out_samples : window.stop] = 0.0
    assert failed(checks_of(right.with_drive(drive))) == {"drive_as_rendered"}


def opened_early(right: Film, index: int, background: Background, *, earlier: int = EARLIER) -> tuple[Film, Event]:
    """Return the film with a window that opens 0.3 s earlier, and its event; a solved drive rests until its lead."""
    events = list(right.timeline.events)
    event = events[index]
    old = event.window
    window = Window(old.start - earlier, old.stop, old.fade_in_samples, old.fade_out_samples)
    events[index] = msgspec.structs.replace(event, window=window)
    inside, audio = slice(window.start, window.stop), right.audio.samples
    dry = audio[inside] if background == "direct" else np.zeros(len(window.span))
    wet = right.drive.samples[inside].copy()
    is_direct = event.drive is not None and event.drive.model == "direct"
    wet[: earlier + old.fade_in_samples] = audio[inside][: earlier + old.fade_in_samples] if is_direct else 0.0
    weights = weights_of(window)
    weights[-old.fade_out_samples :] = 1.0  # faded already
    drive = right.drive.samples.copy()
    drive[inside] = dsp.cross_fade(dry, wet, weights)
    return right.with_events(*events).with_drive(drive), events[index]


@pytest.mark.parametrize("background", ["mute", "direct"])
@pytest.mark.parametrize("model", [None, "direct"])
@pytest.mark.parametrize("before_ms", [290, 150, 40])
def test_nothing_but_what_is_due_moves_in_a_window_that_opens_early(
    before_ms: int, model: DriveModel | None, background: Background
) -> None:
    right, event = opened_early(make_film(model=model, background=background), 3, background)
    assert failed(checks_of(right, background=background)) == set()
    drive = right.drive.samples.copy()
    at = event.onset_sample - round(before_ms * RATE_HZ / 1000)
    drive[at : at + RATE_HZ // 100] += thump(RATE_HZ // 100, 0.3)
    assert "pre_echo" in failed(checks_of(right.with_drive(drive), background=background))


@pytest.mark.parametrize("background", ["mute", "direct"])
def test_a_window_may_open_long_before_its_shot(background: Background) -> None:
    """Ten seconds of it are looked at."""
    film = make_film(onsets_s=(12.9,), peaks=(0.5,), seconds=14.0, background=background, model="direct")
    right, _ = opened_early(film, 0, background, earlier=12 * RATE_HZ)
    assert failed(checks_of(right, background=background)) == set()


@pytest.mark.parametrize("raised_db", [1.0, 2.0])
def test_a_drive_that_was_raised_against_the_limit_fails(raised_db: float) -> None:
    """What is at the limit stays there, so the whole is hardly stronger: by 0.1 to 0.2 dB for each."""
    right = booming(None, "mute")
    drive = np.clip(right.drive.samples * 10.0 ** (raised_db / 20.0), -1.0, 1.0)
    broken = [check for check in checks_of(right.with_drive(drive)) if not check.passed]
    assert {check.event for check in broken if check.name == "level_as_rendered"} >= {"shot-0002", "shot-0004"}


@pytest.mark.parametrize("origin", ["added", "moved"])
def test_a_shot_that_was_set_by_hand_where_a_sound_begins_is_measured_as_one_that_was_found(origin: Origin) -> None:
    right = make_film()
    late = right.with_drive(np.roll(right.drive.samples, 480))
    by_hand = late.with_events(*(msgspec.structs.replace(event, origin=origin) for event in late.timeline.events))
    found, told = checks_of(late), checks_of(by_hand)
    assert "felt_lag" in failed(found)
    assert [check for check in told if check.name == "felt_lag"] == [
        check for check in found if check.name == "felt_lag"
    ]


@pytest.mark.parametrize(("fade_in", "fade_out"), [(0, 0), (240, 1_920), (1, 1)])
@pytest.mark.parametrize("beyond", [0, 1, 500])
def test_a_shot_is_weighed_as_its_window_weighs_it_and_not_beside_it(fade_in: int, fade_out: int, beyond: int) -> None:
    event = msgspec.structs.replace(SHOT, window=Window(10_000, 20_000, fade_in, fade_out))
    span = Span(10_000 - beyond, 20_000 + beyond)
    expected = np.pad(weights_of(event.window), beyond)
    assert _risen(event, span) * _fallen(event, span) == pytest.approx(expected, abs=1e-12)

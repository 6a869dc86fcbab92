"""What a user says about timecode: read, refused, and put on a film without moving an event."""

import re
from fractions import Fraction

import msgspec
import pytest

from blastline.errors import RuleError
from blastline.timebase import AS_FILMED, parse_timebase, retimed, with_timebase
from blastline.timecode import frame_scale, time_of_start, timecode_at
from timelines import timeline

FILM = timeline().source
SOUND = msgspec.structs.replace(FILM, name="mix.wav", start_timecode=None, frame_rate=None)
BROADCAST = msgspec.structs.replace(SOUND, start_timecode="10:00:00.010000")


@pytest.mark.parametrize(
    ("text", "rate", "drop_frame"),
    [
        ("23.976", "24000/1001", None),
        ("23.98", "24000/1001", None),
        ("24000/1001", "24000/1001", None),
        ("24", "24", None),
        ("25.000", "25", None),
        ("29.97", "30000/1001", None),
        ("29.97df", "30000/1001", True),
        ("29.97NDF", "30000/1001", False),
        ("48", "48", None),
        ("59.94DF", "60000/1001", True),
        ("60", "60", None),
        ("119.88df", "120000/1001", True),
    ],
)
def test_rates_are_read_as_people_write_them(text: str, rate: str, drop_frame: bool | None) -> None:
    read = parse_timebase(None, text)
    assert (read.frame_rate, read.drop_frame) == (Fraction(rate), drop_frame)


@pytest.mark.parametrize("text", ["", "fast", "0", "24/0", "-24", "26", "23.976fps", "1e3"])
def test_a_rate_that_timecode_does_not_have_is_refused(text: str) -> None:
    with pytest.raises(RuleError, match=re.escape(f"--frame-rate {text!r}: no rate of film timecode; expected 23.976")):
        parse_timebase(None, text)


def test_drop_frame_only_where_it_exists() -> None:
    with pytest.raises(RuleError, match=r"--frame-rate '25df': only 29\.97, 59\.94 and 119\.88 have drop-frame"):
        parse_timebase(None, "25df")
    with pytest.raises(RuleError, match="--start-timecode '01:00:00;00': 24 frames a second have no drop-frame"):
        with_timebase(FILM, parse_timebase("01:00:00;00", None))


@pytest.mark.parametrize(
    ("start", "rate", "complaint"),
    [
        ("1h", "24", "--start-timecode '1h': expected HH:MM:SS:FF"),
        ("01:00:00:24", "24", "timecode '01:00:00:24': expected hours up to 23 and frames up to 23"),
        ("00:01:00;00", "29.97", "timecode '00:01:00;00': drop-frame has no such number"),
        ("01:00:00:00", None, "--start-timecode '01:00:00:00': the film has no frame rate; give --frame-rate as well"),
    ],
)
def test_a_start_that_does_not_go_with_the_film_is_refused(start: str, rate: str | None, complaint: str) -> None:
    with pytest.raises(RuleError, match=re.escape(complaint)):
        with_timebase(SOUND, parse_timebase(start, rate))


def test_nothing_said_changes_nothing() -> None:
    assert parse_timebase(None, None) == AS_FILMED
    assert with_timebase(FILM, AS_FILMED) == FILM
    assert retimed(timeline(), AS_FILMED) == timeline()


def test_the_users_word_stands() -> None:
    said = with_timebase(SOUND, parse_timebase("00:59:59;28", "29.97df"))
    assert (said.start_timecode, said.frame_rate) == ("00:59:59;28", "30000/1001")
    assert timecode_at(said, 2 * 1602) == "01:00:00;00"
    said = with_timebase(FILM, parse_timebase("10:00:00:00", None))
    assert (said.start_timecode, said.frame_rate) == ("10:00:00:00", "24")


def test_the_way_of_counting_alone_can_be_said() -> None:
    film = msgspec.structs.replace(FILM, frame_rate="30000/1001")
    assert with_timebase(film, parse_timebase(None, "29.97df")).start_timecode == "01:00:00;00"
    assert with_timebase(SOUND, parse_timebase(None, "59.94df")).start_timecode == "00:00:00;00"


@pytest.mark.parametrize("rate", ["23.976", "24", "25", "29.97", "29.97df", "59.94df"])
def test_a_broadcast_waves_time_of_day_stays_the_same_moment(rate: str) -> None:
    said = with_timebase(BROADCAST, parse_timebase(None, rate))
    assert time_of_start(said) == time_of_start(BROADCAST) == 36_000 * 48_000 + 480
    scale = frame_scale(said)
    assert scale is not None
    assert scale.drop_frame == rate.endswith("df")


def test_a_timeline_is_renamed_and_not_moved() -> None:
    moved = retimed(timeline(), parse_timebase("10:00:00:00", "25"))
    assert [event.timecode for event in moved.events] == ["10:00:01:00", "10:00:02:00"]
    assert [event.onset_sample for event in moved.events] == [event.onset_sample for event in timeline().events]

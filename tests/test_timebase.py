"""What a user says about timecode: read, refused, and put on a film without moving an event."""

import re
from fractions import Fraction

import msgspec
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from blastline.errors import RuleError
from blastline.model import Source
from blastline.timebase import (
    AS_FILMED,
    Timebase,
    parse_timebase,
    rate_text,
    recalled,
    retimed,
    uncounted,
    with_timebase,
)
from blastline.timecode import STANDARD_RATES, clock, frame_scale, label, time_of_start, timecode_at
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


def test_a_refused_rate_is_told_every_rate_that_there_is() -> None:
    with pytest.raises(RuleError) as refused:
        parse_timebase(None, "26")
    for rate in STANDARD_RATES:
        assert re.search(rf"(?<![\d.]){re.escape(rate_text(rate))}(?![\d.])", str(refused.value))


@pytest.mark.parametrize("rate", STANDARD_RATES)
def test_a_rate_is_read_by_the_name_it_is_called(rate: Fraction) -> None:
    assert parse_timebase(None, rate_text(rate)).frame_rate == rate


def test_a_rate_is_called_what_the_option_offers() -> None:
    with pytest.raises(RuleError) as refusal:
        parse_timebase(None, "fast")
    offered = re.findall(r"[\d.]*\d", str(refusal.value))
    assert "59.94" in offered
    for name in offered:
        rate = parse_timebase(None, name).frame_rate
        assert rate is not None
        assert rate_text(rate) == name


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
        ("01:00:00:24", "24", "--start-timecode '01:00:00:24': expected hours up to 23 and frames up to 23"),
        ("00:01:00;00", "29.97", "--start-timecode '00:01:00;00': drop-frame has no such number"),
        ("01:00:00:00", None, "--start-timecode '01:00:00:00': the film has no frame rate; give --frame-rate as well"),
    ],
)
def test_a_start_that_does_not_go_with_the_film_is_refused(start: str, rate: str | None, complaint: str) -> None:
    with pytest.raises(RuleError, match=re.escape(complaint)):
        with_timebase(SOUND, parse_timebase(start, rate))


def test_a_rate_that_does_not_go_with_the_films_own_start_is_refused_by_its_option() -> None:
    film = msgspec.structs.replace(FILM, start_timecode="01:00:00:24", frame_rate="25")
    said = "--frame-rate: film.mov: its start timecode '01:00:00:24': expected hours up to 23 and frames up to 23"
    with pytest.raises(RuleError, match=re.escape(said)):
        with_timebase(msgspec.structs.replace(film, name="film.mov"), parse_timebase(None, "24"))


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


@pytest.mark.parametrize("clock", ["01:00:00.2", "01:00:00.20", "01:00:00.200", "01:00:00.2000"])
@pytest.mark.parametrize("rate", [None, "25", "29.97", "29.97df"])
def test_a_clock_is_the_same_moment_however_many_decimals_it_has(clock: str, rate: str | None) -> None:
    """With two or three of them it is no timecode of so many frames."""
    assert time_of_start(with_timebase(SOUND, parse_timebase(clock, rate))) == 3600 * 48_000 + 9600


@pytest.mark.parametrize(("start", "rate"), [("01:00:00:12", None), ("01:00:00;12", "15")])
def test_frames_that_nothing_counts_are_told_until_their_rate_is_said(start: str, rate: str | None) -> None:
    filmed = msgspec.structs.replace(FILM, start_timecode=start, frame_rate=rate)
    [warning] = uncounted(filmed)
    assert start in warning
    assert "--frame-rate" in warning
    whole = timeline()
    warned = msgspec.structs.replace(whole, source=msgspec.structs.replace(filmed, warnings=("damaged", warning)))
    assert retimed(warned, parse_timebase(None, "29.97")).source.warnings == ("damaged",)
    assert retimed(warned, AS_FILMED) == warned


@pytest.mark.parametrize("film", [FILM, SOUND, BROADCAST])
def test_a_timecode_that_is_counted_and_a_clock_are_not_told(film: Source) -> None:
    assert uncounted(film) == ()


def test_a_timeline_is_renamed_and_not_moved() -> None:
    moved = retimed(timeline(), parse_timebase("10:00:00:00", "25"))
    assert [event.timecode for event in moved.events] == ["10:00:01:00", "10:00:02:00"]
    assert [event.onset_sample for event in moved.events] == [event.onset_sample for event in timeline().events]


CLOCKS = st.builds(
    lambda hours, minutes, seconds, rest: f"{hours:02}:{minutes:02}:{seconds:02}{rest}",
    st.integers(0, 30),
    st.integers(0, 59),
    st.integers(0, 59),
    st.from_regex(r"(\.\d{1,9})?", fullmatch=True),
)
LABELS = st.from_regex(r"[01]\d:[0-5]\d:[0-5]\d[:;][01]\d", fullmatch=True)
STARTS = st.none() | CLOCKS | LABELS
OFFSETS = st.just(0.0) | st.builds(
    lambda steps, scale: steps / scale, st.integers(-90_000, 90_000), st.sampled_from([1000, 44_100, 48_000, 90_000])
)


@given(
    STARTS,
    st.sampled_from([None, "24", "25", "30000/1001", "60000/1001", "15"]),
    OFFSETS,
    STARTS,
    st.sampled_from([None, "23.976", "25", "29.97", "29.97df", "29.97ndf", "59.94df", "119.88df", "120"]),
    st.booleans(),
)
@settings(max_examples=200)
def test_what_was_said_of_a_film_is_known_from_the_timeline_made_of_it(
    own_start: str | None, own_rate: str | None, offset_s: float, start: str | None, rate: str | None, picture: bool
) -> None:
    """Whoever renders an edited timeline says nothing and gets the timecodes of the first time, to the last bit."""
    filmed = msgspec.structs.replace(
        FILM, start_timecode=own_start, frame_rate=own_rate, start_offset_s=offset_s, has_picture=picture
    )
    try:
        earlier = with_timebase(filmed, parse_timebase(start, rate))
    except RuleError:
        assume(False)
    unread = msgspec.structs.replace(filmed, sha256="", frames=0)
    assert with_timebase(filmed, recalled(AS_FILMED, earlier, unread)) == earlier


@pytest.mark.parametrize(
    ("clock", "numbered"),
    [("01:00:00.25", "01:00:00;08"), ("01:00:00.5", "01:00:00;15"), ("01:00:00.125", "01:00:00;04")],
)
def test_a_clock_that_was_made_a_drop_frame_timecode_is_said_again(clock: str, numbered: str) -> None:
    earlier = with_timebase(SOUND, parse_timebase(f"{clock}0", "29.97df"))
    assert (earlier.start_timecode, earlier.start_offset_s != 0.0) == (numbered, True)
    assert recalled(AS_FILMED, earlier, SOUND) == Timebase(clock, Fraction(30_000, 1001), drop_frame=True)
    # said anew at another rate, the clock still stands
    assert with_timebase(SOUND, recalled(parse_timebase(None, "25"), earlier, SOUND)).start_timecode == clock
    own = with_timebase(BROADCAST, parse_timebase(None, "29.97df"))
    assert recalled(AS_FILMED, own, BROADCAST).start_timecode is None


@pytest.mark.parametrize("offset_s", [0.0, 0.5])
@pytest.mark.parametrize("earlier", [SOUND, BROADCAST])
def test_a_film_that_has_got_a_timecode_since_keeps_it_where_nothing_was_said(earlier: Source, offset_s: float) -> None:
    filmed = msgspec.structs.replace(
        earlier, start_timecode="10:00:00:05", frame_rate="30000/1001", start_offset_s=offset_s
    )
    said = recalled(AS_FILMED, msgspec.structs.replace(earlier, start_timecode=None), filmed)
    assert with_timebase(filmed, said) == filmed


def test_a_clock_that_was_not_counted_drop_frame_stays_one_over_a_film_that_counts_so() -> None:
    filmed = with_timebase(SOUND, parse_timebase("01:00:00;10", "29.97df"))
    earlier = with_timebase(filmed, parse_timebase("10:00:00.5", "29.97ndf"))
    assert earlier.start_timecode == "10:00:00.5"
    assert with_timebase(filmed, recalled(AS_FILMED, earlier, filmed)) == earlier


def test_a_clock_alone_is_counted_as_the_film_or_the_timeline_was() -> None:
    """Drop-frame is how a film counts, and not a part of where it starts: without it an hour is 3.6 s off."""
    said = parse_timebase("01:00:00.250", None)
    spoken = parse_timebase("01:00:00.250", "29.97df")
    earlier = with_timebase(SOUND, parse_timebase("10:00:00;00", "29.97df"))
    assert with_timebase(SOUND, recalled(said, earlier, SOUND)) == with_timebase(SOUND, spoken)
    assert with_timebase(earlier, said) == with_timebase(earlier, spoken)
    even = with_timebase(SOUND, parse_timebase("10:00:00:00", "29.97"))
    for start in (said, parse_timebase("01:00:00:00", None)):
        assert recalled(start, even, SOUND).drop_frame is None
    assert recalled(parse_timebase("01:00:00:00", None), earlier, SOUND).drop_frame is None  # its colon says it


def test_a_rate_without_drop_frame_names_the_start_that_was_said_earlier() -> None:
    earlier = with_timebase(SOUND, parse_timebase("10:00:00;00", "29.97df"))
    with pytest.raises(RuleError, match=r"--frame-rate 25: .* the start '10:00:00;00' of the timeline that was edited"):
        recalled(parse_timebase(None, "25"), earlier, SOUND)
    assert recalled(parse_timebase("10:00:00:00", "25"), earlier, SOUND).start_timecode == "10:00:00:00"
    whole = with_timebase(SOUND, parse_timebase("10:00:00:00", "24"))
    again = with_timebase(SOUND, recalled(parse_timebase(None, "25"), whole, SOUND))
    assert (again.start_timecode, again.frame_rate) == ("10:00:00:00", "25")


@pytest.mark.parametrize(
    ("start", "rate", "anew", "told"),
    [
        ("01:00:00:29", "30", "25", "frames up to 24"),
        ("01:00:00:24", "25", "23.976", "frames up to 23"),
        ("01:01:00:00", "29.97", "29.97df", "drop-frame has no such number"),
    ],
)
def test_a_start_that_was_said_earlier_is_not_told_as_one_that_is_said_now(
    start: str, rate: str, anew: str, told: str
) -> None:
    earlier = with_timebase(SOUND, parse_timebase(start, rate))
    with pytest.raises(
        RuleError, match=f"--frame-rate {anew}: the start of the timeline.*{told}.*give --start-timecode"
    ):
        recalled(parse_timebase(None, anew), earlier, SOUND)


@pytest.mark.parametrize("text", ["01:00:00", "10:75:00.5", "1:99:99", "１０:00:00:00", "100:00:00.5", "01:00:00."])
def test_a_start_that_is_no_timecode_is_not_taken_for_a_clock(text: str) -> None:
    with pytest.raises(RuleError, match=r"expected HH:MM:SS:FF, .* or HH:MM:SS\.mmm of a clock"):
        parse_timebase(text, None)


@pytest.mark.parametrize("frame", [0, 2, 107_892, 107_893, 1_000_003, 2_589_407])
@pytest.mark.parametrize("late", [-1, 0, 1])
def test_a_clock_becomes_the_drop_frame_that_starts_nearest_to_it(frame: int, late: int) -> None:
    """A recorder's stamp is a whole sample near to its frame: a little early is not a frame early."""
    rate = Fraction(30_000, 1001)
    sample = max(0, round(Fraction(frame) / rate * 48_000) + late)
    started = msgspec.structs.replace(SOUND, start_timecode=clock(sample, 48_000, decimals=6))
    counted = with_timebase(started, parse_timebase(None, "29.97df"))
    assert counted.start_timecode == label(frame, 30, drop_frame=True)
    assert abs(counted.start_offset_s) <= 2.0 / 48_000

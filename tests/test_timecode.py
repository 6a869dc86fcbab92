"""Timecode against opentimelineio, the rule of drop-frame, and exact fractions."""

import random
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from opentimelineio import opentime

from blastline.errors import RuleError
from blastline.model import Source
from blastline.timecode import (
    STANDARD_RATES,
    clock,
    exact_offset,
    frame_of,
    frame_scale,
    frame_time,
    frames_per_day,
    label,
    late_stamp,
    standard_rate,
    time_of_start,
    timecode_at,
)

RATES = ["24000/1001", "24", "25", "30000/1001", "30", "48", "50", "60000/1001", "60"]


def source(frame_rate: str | None, start: str | None = None, *, rate_hz: int = 48_000, offset_s: float = 0.0) -> Source:
    return Source(
        name="film",
        sha256="",
        sample_rate_hz=rate_hz,
        frames=1,
        channels=1,
        start_timecode=start,
        frame_rate=frame_rate,
        start_offset_s=offset_s,
    )


def first_sample(frame: int, frame_rate: str, rate_hz: int = 48_000) -> int:
    """Return the first sample that is nearer to a frame's start than to the one before's."""
    return -(-(2 * frame - 1) * rate_hz // (2 * Fraction(frame_rate))) if frame else 0


def days_frames(nominal: int) -> list[int]:
    """Return frames of 24 hours: those around every minute of the day, and thousands of others."""
    whole = frames_per_day(nominal, drop_frame=True)
    edges = [frame_of(f"{m // 60:02}:{m % 60:02}:00;08", nominal, drop_frame=True) - 8 for m in range(1440)]
    around = {(edge + step) % whole for edge in edges for step in range(-9, 18)}
    return sorted(around | set(random.Random(nominal).sample(range(whole), 20_000)))


@pytest.mark.parametrize(("nominal", "rate"), [(30, 30_000 / 1001), (60, 60_000 / 1001)])
def test_drop_frame_is_that_of_opentimelineio_all_day(nominal: int, rate: float) -> None:
    for frame in days_frames(nominal):
        text = label(frame, nominal, drop_frame=True)
        assert text == opentime.RationalTime(frame, rate).to_timecode(rate, True)
        assert frame_of(text, nominal, drop_frame=True) == frame


@pytest.mark.parametrize("nominal", [24, 25, 30, 48, 50, 60, 100, 120])
def test_numbers_without_drop_frame_count_on(nominal: int) -> None:
    rng = random.Random(nominal)
    for frame in rng.sample(range(frames_per_day(nominal, drop_frame=False)), 2000):
        text = label(frame, nominal)
        assert frame_of(text, nominal) == frame
        assert label(frame + frames_per_day(nominal, drop_frame=False), nominal) == text
        if nominal <= 60:
            assert text == opentime.RationalTime(frame, nominal).to_timecode(nominal, False)


@pytest.mark.parametrize(
    ("text", "drop_frame", "complaint"),
    [
        ("1:00:00:00", False, "expected HH:MM:SS:FF"),
        ("01:00:60:00", False, "expected HH:MM:SS:FF"),
        ("24:00:00:00", False, "hours up to 23 and frames up to 29"),
        ("01:00:00:30", False, "hours up to 23 and frames up to 29"),
        ("00:01:00;01", True, "drop-frame has no such number; the minute starts with ;02"),
    ],
)
def test_what_is_no_timecode_is_refused(text: str, drop_frame: bool, complaint: str) -> None:
    with pytest.raises(RuleError, match=complaint):
        frame_of(text, 30, drop_frame=drop_frame)


@given(
    st.integers(-(10**6), 10**10),
    st.sampled_from(STANDARD_RATES),
    st.sampled_from([44_100, 48_000, 96_000]),
    st.floats(-1.0, 1.0),
)
def test_a_frame_is_at_most_half_a_frame_away_and_the_offset_says_how_far(
    sample: int, rate: Fraction, rate_hz: int, offset_s: float
) -> None:
    film = source(str(rate), "01:00:00:00", rate_hz=rate_hz, offset_s=offset_s)
    scale = frame_scale(film)
    assert scale is not None
    at = frame_time(film, sample, scale)
    assert -1 <= 2 * at.offset_s * rate < 1
    before = frame_time(film, 0, scale)
    elapsed = (at.frame / rate + at.offset_s) - (before.frame / rate + before.offset_s)
    assert elapsed == Fraction(sample, rate_hz)


def test_rates_that_are_measured_or_shortened_are_the_standard_ones() -> None:
    shortened = {"23.976": 24, "23.98": 24, "29.97": 30, "47.952": 48, "59.94": 60, "119.88": 120}
    for text, nominal in shortened.items():
        assert standard_rate(Fraction(text)) == Fraction(nominal * 1000, 1001)
    for rate in STANDARD_RATES:
        assert standard_rate(rate) == rate
    assert standard_rate(Fraction(27, 2)) is None
    for off in (Fraction(1, 2000), Fraction(-1, 2000)):  # halfway from 24 to 23.976 neither is meant
        assert standard_rate(24 * (1 + off)) is None


def test_a_start_that_its_rate_does_not_have_still_counts_on() -> None:
    assert timecode_at(source("24", "01:00:00:25"), 48_000) == "01:00:02:01"
    assert timecode_at(source("25", "01:00:00;05"), 48_000) == "01:00:01:05"


def test_a_time_of_day_becomes_timecode_with_a_frame_rate() -> None:
    assert timecode_at(source("25", "10:00:00.020000"), 0) == "10:00:00:01"
    assert timecode_at(source("25", "10:00:00.010000"), 0) == "10:00:00:00"
    assert timecode_at(source("24000/1001", "01:00:03.600000"), 0) == "01:00:00:00"
    assert timecode_at(source("25", "10:00:01"), 0) == "10:00:01:00"


@pytest.mark.parametrize(
    ("frame", "timecode"),
    [
        (0, "00:00:00;00"),
        (1799, "00:00:59;29"),
        (1800, "00:01:00;02"),
        (17_981, "00:09:59;29"),
        (17_982, "00:10:00;00"),
        (107_892, "01:00:00;00"),
        (24 * 107_892 - 1, "23:59:59;29"),
        (24 * 107_892, "00:00:00;00"),
    ],
)
def test_drop_frame_skips_two_numbers_a_minute_but_not_the_tenth(frame: int, timecode: str) -> None:
    film = source("30000/1001", "00:00:00;00")
    sample = first_sample(frame, "30000/1001")
    assert timecode_at(film, sample) == timecode
    assert frame == 0 or timecode_at(film, sample - 1) != timecode


@pytest.mark.parametrize("rate", ["30000/1001", "60000/1001", "120000/1001"])
@pytest.mark.parametrize("start", ["01:00:00;00", "00:09:59;29", "10:20:30;12"])
def test_drop_frame_is_told_by_a_comma_as_by_a_semicolon(rate: str, start: str) -> None:
    one, other = source(rate, start), source(rate, start.replace(";", ","))
    scale = frame_scale(other)
    assert scale == frame_scale(one)
    assert scale is not None
    assert scale.drop_frame
    for sample in (0, 48_000, 3600 * 48_000):
        assert timecode_at(other, sample) == timecode_at(one, sample)


@pytest.mark.parametrize("rate", ["30000/1001", "60000/1001"])
def test_drop_frame_by_the_rule_itself(rate: str) -> None:
    nominal = round(Fraction(rate))
    labels = [
        f"00:{minute:02}:{second:02};{frame:02}"
        for minute in range(21)
        for second in range(60)
        for frame in range(nominal)
        if not (second == 0 and minute % 10 and frame < nominal // 15)
    ]
    film = source(rate, "00:00:00;00")
    for frame in range(0, len(labels), 7):
        assert timecode_at(film, first_sample(frame, rate)) == labels[frame]


@given(st.integers(0, 10**9), st.sampled_from(RATES), st.sampled_from([44_100, 48_000, 96_000]))
def test_without_drop_frame_the_digits_count_the_nearest_frame(sample: int, rate: str, rate_hz: int) -> None:
    frame = (2 * sample * Fraction(rate) + rate_hz) // (2 * rate_hz)
    seconds, number = divmod(frame, round(Fraction(rate)))
    expected = f"{seconds // 3600 % 24:02}:{seconds // 60 % 60:02}:{seconds % 60:02}:{number:02}"
    assert timecode_at(source(rate, rate_hz=rate_hz), sample) == expected


def test_the_start_and_the_offset_are_added() -> None:
    assert timecode_at(source("24", "01:00:00:00"), 48_000) == "01:00:01:00"
    assert timecode_at(source("25", offset_s=0.04), 0) == "00:00:00:01"
    assert timecode_at(source("25", offset_s=0.04), 959) == "00:00:00:01"
    assert timecode_at(source("25", offset_s=0.04), 960) == "00:00:00:02"
    assert timecode_at(source("30000/1001", "00:59:59;29"), 1602) == "01:00:00;00"


@pytest.mark.parametrize("rate", [24, 25, 30])
def test_an_offset_of_whole_frames_is_whole_frames(rate: int) -> None:
    for frame in range(1, rate):
        assert timecode_at(source(str(rate), offset_s=frame / rate), 0) == f"00:00:00:{frame:02}"


def test_before_the_first_frame_it_is_the_day_before() -> None:
    assert timecode_at(source("24", offset_s=-0.03), 0) == "23:59:59:23"
    assert timecode_at(source("30000/1001", "00:00:00;00", offset_s=-0.03), 0) == "23:59:59;29"


def test_without_a_frame_rate_it_is_the_clock() -> None:
    assert timecode_at(source(None), 48_000 * 3661 + 24) == "01:01:01.001"
    assert timecode_at(source(None, "10:00:00.000021"), 47_999) == "10:00:01.000"
    assert timecode_at(source("27/2"), 48_000) == "00:00:01.000"


@pytest.mark.parametrize("frame_rate", [None, "15", "27/2"])
@pytest.mark.parametrize("start", ["10:00:05:00", "10:00:05:12", "10:00:05;23", "10:00:05:119"])
def test_a_timecode_whose_frames_nothing_counts_keeps_its_second(frame_rate: str | None, start: str) -> None:
    film = source(frame_rate, start, offset_s=0.25)
    assert timecode_at(film, 0) == "10:00:05.250"
    assert time_of_start(film) == 36_005 * 48_000 + 12_000


@pytest.mark.parametrize(
    ("start", "elapsed_ms", "timecode"),
    [
        ("23:59:59.500", 499, "23:59:59.999"),
        ("23:59:59.500", 500, "00:00:00.000"),
        ("23:59:59.9996", 0, "00:00:00.000"),
        ("22:00:00.0", 3 * 3_600_000, "01:00:00.000"),
        ("23:00:00:00", 3_600_000, "00:00:00.000"),
        (None, 25 * 3_600_000, "01:00:00.000"),
        (None, -1, "23:59:59.999"),
    ],
)
def test_a_clock_starts_again_at_midnight(start: str | None, elapsed_ms: int, timecode: str) -> None:
    assert timecode_at(source(None, start, offset_s=elapsed_ms / 1000), 0) == timecode


def test_the_clock_carries() -> None:
    assert clock(47_999_999, 48_000_000, decimals=3) == "00:00:01.000"
    assert clock(-48, 48_000, decimals=3) == "-00:00:00.001"


@pytest.mark.parametrize(
    ("frame_rate", "start", "offset_s", "samples"),
    [
        (None, None, 0.0, 0),
        (None, None, 0.5, 24_000),
        ("24", None, 0.5, 24_000),
        ("24", "01:00:00:00", 0.0, 172_800_000),
        ("24", "01:00:00:00", 0.5, 172_824_000),
        ("24000/1001", "01:00:00:00", 0.0, 172_972_800),
        ("30000/1001", "01:00:00;00", 0.0, 172_799_827),
        (None, "01:00:00.000000", 0.0, 172_800_000),
        ("24", "00:00:00:00", -0.5, 0),
    ],
)
def test_time_of_the_first_sample_since_midnight(
    frame_rate: str | None, start: str | None, offset_s: float, samples: int
) -> None:
    assert time_of_start(source(frame_rate, start, offset_s=offset_s)) == samples


@pytest.mark.parametrize(
    ("offset_s", "said"),
    [(-0.5, "0.500 s"), (-0.048, "0.048 s"), (-0.021, "0.021 s"), (-0.002, "0.002 s"), (-0.0005, None), (0.0, None)],
)
def test_sound_that_begins_before_midnight_is_told(offset_s: float, said: str | None) -> None:
    """Coded sound leads in by a block: 21 ms of AAC, 32 ms of AC-3."""
    told = late_stamp(source("24", "00:00:00:00", offset_s=offset_s))
    assert len(told) == (0 if said is None else 1)
    assert all(f"begins {said} before 00:00:00" in line for line in told)


@given(
    st.sampled_from([None, "24", "30000/1001"]),
    st.sampled_from([None, "00:00:00:00", "00:00:00;00", "00:00:00.000"]),
    st.integers(-100_000, 100_000),
    st.sampled_from([44_100, 48_000]),
)
def test_a_time_stamp_is_within_a_millisecond_of_the_sound_or_there_is_a_warning(
    frame_rate: str | None, start: str | None, offset_us: int, rate_hz: int
) -> None:
    film = source(frame_rate, start, rate_hz=rate_hz, offset_s=offset_us / 1e6)
    off_s = abs(Fraction(time_of_start(film), rate_hz) - Fraction(offset_us, 1_000_000))
    assert (off_s < Fraction(1, 1000)) == (not late_stamp(film))


@pytest.mark.parametrize(
    ("start", "frame"), [("00:75:00:00", 112_500), ("00:59:60:00", 90_000), ("01:00:00:30", 90_030)]
)
def test_a_number_that_no_clock_has_is_counted_on(start: str, frame: int) -> None:
    scale = frame_scale(source("25", start))
    assert scale is not None
    assert scale.first_frame == frame
    assert timecode_at(source("25", start), 0) == scale.label(frame)


@pytest.mark.parametrize("clock_hz", [1000, 48_000, 90_000, Fraction(30_000, 1001)])
def test_an_offset_is_what_a_containers_clock_said_before_it_became_a_float(clock_hz: int | Fraction) -> None:
    for ticks in (-1, 1, 7, 1001, 4099):
        exact_s = ticks / Fraction(clock_hz)
        assert exact_offset(source("25", offset_s=float(exact_s))) == exact_s


def test_a_start_that_drop_frame_leaves_out_is_believed_and_counted_on_from() -> None:
    left_out = source("30000/1001", "00:01:00;00")
    assert timecode_at(left_out, 0) == "00:01:00:00"
    assert timecode_at(left_out, first_sample(2, "30000/1001")) == "00:01:00:02"

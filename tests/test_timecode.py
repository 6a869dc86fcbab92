"""Timecode against the rule of drop-frame and exact fractions."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from blastline.model import Source
from blastline.timecode import timecode_at
from blastline.timecode import clock, time_of_start

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
    return -(-frame * rate_hz // Fraction(frame_rate))


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
def test_without_drop_frame_the_digits_count_the_exact_frame(sample: int, rate: str, rate_hz: int) -> None:
    frame = sample * Fraction(rate) // rate_hz
    seconds, number = divmod(frame, round(Fraction(rate)))
    expected = f"{seconds // 3600 % 24:02}:{seconds // 60 % 60:02}:{seconds % 60:02}:{number:02}"
    assert timecode_at(source(rate, rate_hz=rate_hz), sample) == expected


def test_the_start_and_the_offset_are_added() -> None:
    assert timecode_at(source("24", "01:00:00:00"), 48_000) == "01:00:01:00"
    assert timecode_at(source("25", offset_s=0.04), 0) == "00:00:00:01"
    assert timecode_at(source("25", offset_s=0.04), 1919) == "00:00:00:01"
    assert timecode_at(source("25", offset_s=0.04), 1920) == "00:00:00:02"
    assert timecode_at(source("30000/1001", "00:59:59;29"), 1602) == "01:00:00;00"


@pytest.mark.parametrize("rate", [24, 25, 30])
def test_an_offset_of_whole_frames_is_whole_frames(rate: int) -> None:
    for frame in range(1, rate):
        assert timecode_at(source(str(rate), offset_s=frame / rate), 0) == f"00:00:00:{frame:02}"


def test_before_the_first_frame_it_is_the_day_before() -> None:
    assert timecode_at(source("24", offset_s=-0.001), 0) == "23:59:59:23"
    assert timecode_at(source("30000/1001", "00:00:00;00", offset_s=-0.001), 0) == "23:59:59;29"


def test_without_a_frame_rate_it_is_the_clock() -> None:
    assert timecode_at(source(None), 48_000 * 3661 + 24) == "01:01:01.001"
    assert timecode_at(source(None, "10:00:00.000021"), 47_999) == "10:00:01.000"
    assert timecode_at(source("27/2"), 48_000) == "00:00:01.000"


def test_the_clock_carries() -> None:
    assert clock(47_999_999, 48_000_000, decimals=3) == "00:00:01.000"
    assert clock(-48, 48_000, decimals=3) == "-00:00:00.001"


@pytest.mark.parametrize(
    ("frame_rate", "start", "offset_s", "samples"),
    [
        (None, None, 0.0, 0),
        ("24", None, 0.5, 0),
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

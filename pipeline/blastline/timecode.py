"""Film timecode in exact fractions: which frame a sample belongs to, and how frames are numbered.

The picture's first frame is at the start timecode; the sound's first sample may play a little later or earlier. An
event belongs to the frame that starts nearest to it, so a marker on that frame is at most half a frame off; what
remains is its sub-frame offset. Floats are never asked.

    time      |....frame 41....|....frame 42....|....frame 43....|
    events         ^ 41, +         ^ 42, +   ^ 43, -

Drop-frame counts every frame but leaves out numbers: at 29.97 frames a second the first two of each minute, at 59.94
the first four, except in every tenth minute; so the numbers keep up with the clock (SMPTE ST 12-1).
"""

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from .errors import RuleError
from .model import Source
from .units import nearest

STANDARD_RATES = tuple(Fraction(n * 1000, 1001) for n in (24, 30, 48, 60, 120)) + tuple(
    Fraction(n) for n in (24, 25, 30, 48, 50, 60, 100, 120)
)
"""Frames a second that SMPTE timecode is used with."""

DROP_FRAME_RATES = frozenset(Fraction(n * 1000, 1001) for n in (30, 60, 120))

LABEL = re.compile(r"(\d\d):([0-5]\d):([0-5]\d)([:;,])(\d\d\d?)", re.ASCII)  # with a point it is a clock
CLOCK = re.compile(r"(\d+):(\d\d):(\d\d(?:\.\d+)?)", re.ASCII)
SHAPE = re.compile(r"(\d\d:\d\d:\d\d)([:;.,])(\d\d\d?)")
"""What looks like a label, even where no clock has such a number: a film may say 00:75:00:00, and is believed."""

_SAME_RATE = Fraction(1, 5000)  # 24 and 23.976 differ by 1 in 1001; 23.98 is 23.976 rounded, by 1 in 6000
_DAY_MS = 24 * 3600 * 1000
_MIN_EARLY_S = 0.001
_OFFSET_DENOMINATOR = 1_000_000  # finer than any container's clock, coarse enough to undo the float


@dataclass(frozen=True)
class FrameScale:
    """How a film counts its frames.

    `rate` is frames a second, `start` where the picture's first frame stands, counted in frames from 00:00:00:00: a
    whole number where the film has a timecode, a fraction where only its time of day is known.
    """

    rate: Fraction
    start: Fraction
    drop_frame: bool = False

    @property
    def nominal(self) -> int:
        """Return how many numbers a second of timecode has: 30 for 29.97."""
        return math.ceil(self.rate)

    @property
    def first_frame(self) -> int:
        """Return the number of the picture's first frame."""
        return nearest(self.start)

    def label(self, frame: int) -> str:
        """Return the timecode of a frame; see `label`."""
        return label(frame, self.nominal, drop_frame=self.drop_frame)


class FrameTime(NamedTuple):
    """A moment as the frame that starts nearest to it, and how many seconds later (or, below 0, earlier) it is."""

    frame: int
    offset_s: Fraction


def label(frame: int, nominal: int, *, drop_frame: bool = False) -> str:
    """Return the timecode of a frame counted from 00:00:00:00: HH:MM:SS:FF, or HH:MM:SS;FF in drop-frame.

    Hours start again after 24; a frame below 0 counts back from midnight.

    >>> label(1800, 30, drop_frame=True), label(-1, 24)
    ('00:01:00;02', '23:59:59:23')
    """
    frame %= frames_per_day(nominal, drop_frame=drop_frame)
    if drop_frame:
        dropped = nominal // 15
        tens, rest = divmod(frame, 600 * nominal - 9 * dropped)
        minutes = max(0, rest - dropped) // (60 * nominal - dropped)
        frame += dropped * (9 * tens + minutes)
    seconds, number = divmod(frame, nominal)
    mark = ";" if drop_frame else ":"
    return f"{seconds // 3600:02}:{seconds // 60 % 60:02}:{seconds % 60:02}{mark}{number:02}"


def is_label(text: str) -> bool:
    """Return whether a text counts frames, as HH:MM:SS:FF does; with a point it is a clock."""
    return SHAPE.fullmatch(text) is not None and "." not in text


def frame_of(text: str, nominal: int, *, drop_frame: bool = False) -> int:
    """Return which frame a timecode names, counted from 00:00:00:00.

    Raises RuleError where the text is no timecode, or one that this way of counting does not have.

    >>> frame_of("00:01:00;02", 30, drop_frame=True)
    1800
    """
    match = LABEL.fullmatch(text)
    if match is None:
        raise RuleError(f"timecode {text!r}: expected HH:MM:SS:FF, or HH:MM:SS;FF for drop-frame")
    hours, minutes, seconds, number = (int(match[group]) for group in (1, 2, 3, 5))
    if hours > 23 or number >= nominal:
        raise RuleError(f"timecode {text!r}: expected hours up to 23 and frames up to {nominal - 1}")
    minute = 60 * hours + minutes
    frame = (60 * minute + seconds) * nominal + number
    if not drop_frame:
        return frame
    dropped = nominal // 15
    if minute % 10 and seconds == 0 and number < dropped:
        raise RuleError(f"timecode {text!r}: drop-frame has no such number; the minute starts with ;{dropped:02}")
    return frame - dropped * (minute - minute // 10)


def frames_per_day(nominal: int, *, drop_frame: bool) -> int:
    """Return how many frames 24 hours of timecode have."""
    return 24 * (3600 * nominal - (54 * (nominal // 15) if drop_frame else 0))


def standard_rate(rate: Fraction) -> Fraction | None:
    """Return the rate of `STANDARD_RATES` that a measured or shortened one is meant to be, None where there is none.

    >>> str(standard_rate(Fraction("23.98")))
    '24000/1001'
    """
    return next((known for known in STANDARD_RATES if abs(rate / known - 1) < _SAME_RATE), None)


def frame_scale(source: Source) -> FrameScale | None:
    """Return how the film counts frames; None without a frame rate, or with one that timecode does not have."""
    return _scale(source.start_timecode, source.frame_rate)


def frame_time(source: Source, sample: int, scale: FrameScale) -> FrameTime:
    """Return the frame that starts nearest to when a sample plays, halves upwards, and what remains."""
    position = scale.start + picture_time(source, sample) * scale.rate
    frame = nearest(position)
    return FrameTime(frame, (position - frame) / scale.rate)


def picture_time(source: Source, sample: int) -> Fraction:
    """Return when a sample plays, in seconds from the picture's first frame."""
    return Fraction(sample, source.sample_rate_hz) + exact_offset(source)


def timecode_at(source: Source, sample: int) -> str:
    """Return the timecode of a sample: that of the frame which starts nearest to it.

    Without a frame rate, or with one that SMPTE does not know, it is the clock HH:MM:SS.mmm; a start that counts frames
    begins it at its whole second, since nothing says how long a frame lasts. Hours start again after 24; a sample
    before the first frame counts back from midnight.
    """
    scale = frame_scale(source)
    if scale is None:
        steps = nearest(1000 * (clock_seconds(source.start_timecode) + picture_time(source, sample)))
        return clock_text(Fraction(steps % _DAY_MS, 1000), 3)
    return scale.label(frame_time(source, sample, scale).frame)


def time_of_start(source: Source) -> int:
    """Return the samples between midnight and the first sample by the source's timecode; one without begins at 0.

    No time stamp is before midnight: sound that begins there has 0, `late_stamp` after it began.
    """
    return max(0, nearest(_start_s(source) * source.sample_rate_hz))


def late_stamp(source: Source) -> tuple[str, ...]:
    """Return a warning where the sound begins before midnight, and the time stamp of its drive is later than that."""
    early_s = float(-_start_s(source))
    if early_s < _MIN_EARLY_S:
        return ()
    return (
        f"the sound begins {early_s:.3f} s before 00:00:00, and no time stamp is that early: drive.wav says 00:00:00; "
        f"place it {early_s:.3f} s before that, with the film's sound, or give the film's --start-timecode",
    )


def _start_s(source: Source) -> Fraction:
    """Return when the first sample plays, in seconds after midnight."""
    scale = frame_scale(source)
    start = clock_seconds(source.start_timecode) if scale is None else scale.start / scale.rate
    return start + exact_offset(source)


def clock(samples: int, rate_hz: int, *, decimals: int) -> str:
    """Return a number of samples as HH:MM:SS and a fraction, to the nearest step.

    >>> clock(172_800_000, 48_000, decimals=3)
    '01:00:00.000'
    """
    return clock_text(Fraction(samples, rate_hz), decimals)


def clock_text(seconds: Fraction, decimals: int, *, hour_digits: int = 2) -> str:
    """Return a time as HH:MM:SS and a fraction, to the nearest step; hours have at least so many digits.

    >>> clock_text(Fraction(4500), 0, hour_digits=1)
    '1:15:00'
    """
    steps = nearest(seconds * 10**decimals)
    sign = "-" if steps < 0 else ""
    whole, fraction = divmod(abs(steps), 10**decimals)
    tail = f".{fraction:0{decimals}}" if decimals else ""
    return f"{sign}{whole // 3600:0{hour_digits}}:{whole // 60 % 60:02}:{whole % 60:02}{tail}"


@lru_cache(maxsize=64)
def _scale(start_timecode: str | None, frame_rate: str | None) -> FrameScale | None:
    rate = standard_rate(Fraction(frame_rate)) if frame_rate else None
    if rate is None:
        return None
    start = start_timecode or "00:00:00:00"
    if not is_label(start):
        return FrameScale(rate, clock_seconds(start) * rate)
    nominal = math.ceil(rate)
    drop_frame = start[8] != ":" and rate in DROP_FRAME_RATES
    try:
        first = frame_of(start, nominal, drop_frame=drop_frame)
    except RuleError:  # a number that is left out, or one of another rate: it is what the film says, so count on
        hours, minutes, seconds, number = (int(part) for part in re.split("[:;,]", start))
        first = ((60 * hours + minutes) * 60 + seconds) * nominal + number
        drop_frame = False
    return FrameScale(rate, Fraction(first), drop_frame)


def exact_offset(source: Source) -> Fraction:
    """Return `start_offset_s` as the fraction that it was before it became a float."""
    return Fraction(source.start_offset_s).limit_denominator(_OFFSET_DENOMINATOR)


def clock_seconds(text: str | None) -> Fraction:
    """Return the seconds of a time of day HH:MM:SS.mmm, and of a timecode those before its frames; 0 for other text."""
    said = text or ""
    match = CLOCK.fullmatch(said[: len("HH:MM:SS")] if is_label(said) else said)
    if match is None:
        return Fraction(0)
    hours, minutes, seconds = match.groups()
    return 3600 * int(hours) + 60 * int(minutes) + Fraction(seconds)

"""Times of day and SMPTE timecode of samples, in exact fractions.

The picture's first frame is at the start timecode; the sound's first sample may play a little later or earlier. The
frame that shows while a sample plays is the whole part of the exact product: floats are never asked.
"""

import math
import re
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from ..model import Source

_CLOCK = re.compile(r"(\d+):(\d\d):(\d\d(?:\.\d+)?)")
_OFFSET_DENOMINATOR = 1_000_000  # finer than any container's clock, coarse enough to undo the float


class _Scale(NamedTuple):
    """A picture's frames: how many play per second, how many a day has, and the first one's number."""

    rate: Fraction
    nominal: float
    frames_per_day: int
    first_frame: int
    drop_frame: bool


def timecode_at(source: Source, sample: int) -> str:
    """Return the timecode while `sample` plays: HH:MM:SS:FF, or HH:MM:SS;FF where the film counts drop-frame.

    Without a frame rate, or with one that SMPTE does not know, it is the clock HH:MM:SS.mmm. Hours of timecode start
    again after 24; a sample before the first frame counts back from midnight.
    """
    played = Fraction(sample, source.sample_rate_hz) + _offset(source.start_offset_s)
    scale = _scale(source.start_timecode, source.frame_rate)
    if scale is None:
        return _clock_text(_clock_seconds(source.start_timecode) + played, 3)
    from opentimelineio.opentime import RationalTime

    frame = (scale.first_frame + math.floor(played * scale.rate)) % scale.frames_per_day
    return str(RationalTime(frame, scale.nominal).to_timecode(scale.nominal, scale.drop_frame))


def time_of_start(source: Source) -> int:
    """Return the samples between midnight and the first sample by the source's timecode, 0 where it has none."""
    if source.start_timecode is None:
        return 0
    scale = _scale(source.start_timecode, source.frame_rate)
    start = _clock_seconds(source.start_timecode) if scale is None else scale.first_frame / scale.rate
    return max(0, math.floor((start + _offset(source.start_offset_s)) * source.sample_rate_hz + Fraction(1, 2)))


def clock(samples: int, rate_hz: int, *, decimals: int) -> str:
    """Return a number of samples as HH:MM:SS and a fraction, to the nearest step.

    >>> clock(172_800_000, 48_000, decimals=3)
    '01:00:00.000'
    """
    return _clock_text(Fraction(samples, rate_hz), decimals)


@lru_cache(maxsize=64)
def _scale(start_timecode: str | None, frame_rate: str | None) -> _Scale | None:
    """Return how the film counts frames; None where it does not, or at a rate that SMPTE timecode does not have."""
    if frame_rate is None or (start_timecode is not None and _CLOCK.fullmatch(start_timecode)):
        return None
    from opentimelineio.opentime import RationalTime, from_timecode

    rate = Fraction(frame_rate)
    nominal = RationalTime.nearest_smpte_timecode_rate(float(rate))
    if abs(nominal - float(rate)) > 1e-2:
        return None
    start = start_timecode or "00:00:00:00"
    drop_frame = ";" in start
    whole = math.ceil(nominal)
    per_hour = 3600 * whole - (54 * (whole // 15) if drop_frame else 0)
    first_frame = int(from_timecode(start, nominal).to_frames())
    return _Scale(rate, nominal, 24 * per_hour, first_frame, drop_frame)


def _offset(offset_s: float) -> Fraction:
    return Fraction(offset_s).limit_denominator(_OFFSET_DENOMINATOR)


def _clock_seconds(text: str | None) -> Fraction:
    match = _CLOCK.fullmatch(text or "")
    if match is None:
        return Fraction(0)
    hours, minutes, seconds = match.groups()
    return 3600 * int(hours) + 60 * int(minutes) + Fraction(seconds)


def _clock_text(seconds: Fraction, decimals: int) -> str:
    steps = math.floor(seconds * 10**decimals + Fraction(1, 2))
    sign = "-" if steps < 0 else ""
    whole, fraction = divmod(abs(steps), 10**decimals)
    return f"{sign}{whole // 3600:02}:{whole // 60 % 60:02}:{whole % 60:02}.{fraction:0{decimals}}"

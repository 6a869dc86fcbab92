"""What a user says about a film's timecode, and the source that results from it."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

import msgspec

from .errors import RuleError
from .model import Source, Timeline
from .timecode import (
    CLOCK,
    DROP_FRAME_RATES,
    LABEL,
    STANDARD_RATES,
    clock_seconds,
    clock_text,
    exact_offset,
    frame_of,
    frame_scale,
    is_label,
    label,
    standard_rate,
    timecode_at,
)
from .units import nearest

_RATE = re.compile(r"(\d{1,9}(?:\.\d{1,99})?|\d{1,18}/0*[1-9]\d{0,17})(df|ndf)?", re.IGNORECASE)

_MOST_DECIMALS = 24
"""With so many, a clock tells apart any two floats that are less than a frame, but for the very smallest."""


@dataclass(frozen=True)
class Timebase:
    """What the user says about a film's timecode; None where the film's own word stands."""

    start_timecode: str | None = None
    frame_rate: Fraction | None = None
    drop_frame: bool | None = None


_SPOKEN_CLOCK = re.compile(r"\d{1,2}:[0-5]\d:[0-5]\d\.\d+", re.ASCII)
"""A clock as a user says it: without a part of a second it would be a timecode whose frames were forgotten."""

AS_FILMED = Timebase()
"""The film's own timecode."""


def parse_timebase(start_timecode: str | None, frame_rate: str | None) -> Timebase:
    """Return what a user wrote: a start such as 01:00:00:00, a rate such as 23.976, 29.97df, 29.97ndf or 24000/1001.

    Raises RuleError for a rate that timecode does not have, and for drop-frame at one that has none.
    """
    if start_timecode is not None and not (LABEL.fullmatch(start_timecode) or _SPOKEN_CLOCK.fullmatch(start_timecode)):
        wanted = "HH:MM:SS:FF, HH:MM:SS;FF for drop-frame, or HH:MM:SS.mmm of a clock"
        raise RuleError(f"--start-timecode {start_timecode!r}: expected {wanted}")
    if frame_rate is None:
        return Timebase(start_timecode)
    match = _RATE.fullmatch(frame_rate)
    rate = standard_rate(Fraction(match[1])) if match else None
    if match is None or rate is None:
        expected = f"{rates_text()}, or 29.97df, 29.97ndf and the like"
        raise RuleError(f"--frame-rate {frame_rate!r}: no rate of film timecode; expected {expected}")
    drop_frame = None if match[2] is None else match[2].lower() == "df"
    if drop_frame and rate not in DROP_FRAME_RATES:
        raise RuleError(f"--frame-rate {frame_rate!r}: only 29.97, 59.94 and 119.88 have drop-frame")
    return Timebase(start_timecode, rate, drop_frame)


def rate_text(rate: Fraction) -> str:
    """Return frames a second as people call them, and as `parse_timebase` reads them.

    >>> rate_text(Fraction(60000, 1001)), rate_text(Fraction(100)), rate_text(Fraction(27, 2))
    ('59.94', '100', '13.5')
    """
    return f"{float(rate):.3f}".rstrip("0").rstrip(".")


def rates_text() -> str:
    """Return all rates of film timecode in words, as `23.976, 24 or 25`."""
    *most, last = (rate_text(rate) for rate in sorted(STANDARD_RATES))
    return f"{', '.join(most)} or {last}"


def with_timebase(source: Source, timebase: Timebase) -> Source:
    """Return the source with what the user says about its timecode.

    Raises RuleError where the start does not go with the frame rate.
    """
    if timebase == AS_FILMED:
        return source
    start = timebase.start_timecode or source.start_timecode
    rate = str(timebase.frame_rate) if timebase.frame_rate else source.frame_rate
    known = standard_rate(Fraction(rate)) if rate else None
    moved = msgspec.structs.replace(source, start_timecode=start, frame_rate=rate)
    if known is None:
        if start and LABEL.fullmatch(start):
            raise RuleError(f"--start-timecode {start!r}: the film has no frame rate; give --frame-rate as well")
        return moved
    return _counted(moved, known, replace(timebase, drop_frame=_drop_frame(timebase, source)))


def uncounted(source: Source) -> tuple[str, ...]:
    """Return a warning where the film's timecode has frames that nothing counts, for want of a frame rate."""
    start, rate = source.start_timecode, source.frame_rate
    if start is None or not is_label(start) or frame_scale(source) is not None:
        return ()
    found = f"{rate} frames a second, which no timecode counts" if rate else "no frame rate"
    return (
        f"the timecode {start} comes with {found}: times count from its whole second; "
        "--frame-rate says how many frames it counts a second",
    )


def recalled(said: Timebase, earlier: Source, filmed: Source) -> Timebase:
    """Return what the user says about a film, and where they say nothing what they said when `earlier` was made of it.

    `filmed` is the film's own word, from which `earlier` differs where a user said something. Raises RuleError for a
    rate that does not go with the start that was said earlier.
    """
    before = _said_before(earlier, filmed)
    if said.start_timecode is None and said.frame_rate is not None and before.start_timecode is not None:
        _require_countable(before.start_timecode, said.frame_rate, said.drop_frame)
    return Timebase(
        said.start_timecode or before.start_timecode,
        said.frame_rate or before.frame_rate,
        before.drop_frame if said == AS_FILMED else _drop_frame(said, earlier),
    )


def _require_countable(start: str, rate: Fraction, drop_frame: bool | None) -> None:
    """Raise RuleError for a start that was said earlier and that a rate which is said now does not count."""
    counts = LABEL.fullmatch(start)
    if counts is None:
        return
    mend = "give --start-timecode as well"
    drops = counts[4] != ":" if drop_frame is None else drop_frame
    if drops and rate not in DROP_FRAME_RATES:
        raise RuleError(
            f"--frame-rate {rate_text(rate)}: has no drop-frame, which the start {start!r} of the timeline that was "
            f"edited counts; {mend}"
        )
    try:
        frame_of(_marked(start, drops=drops), math.ceil(rate), drop_frame=drops)
    except RuleError as error:
        what = str(error).removeprefix("timecode ")
        asked = f"{rate_text(rate)}{'df' if drop_frame else ''}"
        raise RuleError(f"--frame-rate {asked}: the start of the timeline that was edited, {what}; {mend}") from error


def _marked(start: str, *, drops: bool) -> str:
    """Return a timecode as its mark before the frames says that it counts."""
    return f"{start[:8]}{';' if drops else ':'}{start[9:]}"


def _drop_frame(said: Timebase, source: Source) -> bool | None:
    """Return whether drop-frame is asked for: where somebody says a clock and no more, as it was counted before."""
    is_clock = said.start_timecode is not None and bool(CLOCK.fullmatch(said.start_timecode))
    if said.drop_frame is not None or said.frame_rate is not None or not is_clock:
        return said.drop_frame
    scale = frame_scale(source)
    return True if scale is not None and scale.drop_frame else None


def retimed(timeline: Timeline, timebase: Timebase) -> Timeline:
    """Return the timeline with what the user says about its timecode; no event moves against the sound.

    Raises RuleError where the start does not go with the frame rate.
    """
    source = with_timebase(timeline.source, timebase)
    if source == timeline.source:
        return timeline
    settled = set(uncounted(timeline.source)) - set(uncounted(source))
    warnings = tuple(warning for warning in source.warnings if warning not in settled)
    source = msgspec.structs.replace(source, warnings=warnings)
    events = tuple(
        msgspec.structs.replace(event, timecode=timecode_at(source, event.onset_sample)) for event in timeline.events
    )
    return msgspec.structs.replace(timeline, source=source, events=events)


def _said_before(earlier: Source, filmed: Source) -> Timebase:
    """Return what a user said who made `earlier` of a film; the film's own start is not said again."""
    rate = Fraction(earlier.frame_rate) if earlier.frame_rate and earlier.frame_rate != filmed.frame_rate else None
    start = earlier.start_timecode if earlier.start_timecode != filmed.start_timecode else None
    if earlier.start_offset_s == filmed.start_offset_s:
        # a clock that is one still was not counted drop-frame, whatever the film's own timecode does
        still_clock = start is not None and CLOCK.fullmatch(start) is not None
        return Timebase(start, rate, drop_frame=False if still_clock else None)
    for spoken in _clocks(earlier, filmed):
        said = Timebase(spoken, rate, drop_frame=True)
        if _told(with_timebase(filmed, said)) == _told(earlier):
            return said
    return Timebase(start, rate)


def _told(source: Source) -> tuple[str | None, str | None, float]:
    """Return what a source tells of its timecode; the rest of it is not known before its sound is read."""
    return source.start_timecode, source.frame_rate, source.start_offset_s


def _clocks(earlier: Source, filmed: Source) -> Iterator[str | None]:
    """Yield starts that drop-frame may have made a timecode and a rest: the film's own, then clocks of more decimals.

    The shortest that does it is the user's own; more decimals than a float holds are never asked for.
    """
    scale = frame_scale(earlier)
    if scale is None or not scale.drop_frame:
        return
    if filmed.start_timecode is None or CLOCK.fullmatch(filmed.start_timecode):
        yield None
    moment = scale.start / scale.rate + Fraction(earlier.start_offset_s) - exact_offset(filmed)
    for decimals in range(1, _MOST_DECIMALS + 1):
        yield clock_text(max(Fraction(0), moment), decimals)


def _counted(source: Source, rate: Fraction, timebase: Timebase) -> Source:
    """Return the source with a start that counts frames as the user says."""
    start, nominal = source.start_timecode or "", math.ceil(rate)
    asked = timebase.drop_frame
    if CLOCK.fullmatch(start) or not start:
        if not asked:
            return source
        frames = clock_seconds(start) * rate
        whole = nearest(frames)  # the nearest, as editing programs put the sound
        rest_s = Fraction(0) if source.has_picture else (frames - whole) / rate  # a picture begins on a frame
        return msgspec.structs.replace(
            source,
            start_timecode=label(whole, nominal, drop_frame=True),
            start_offset_s=float(exact_offset(source) + rest_s),
        )
    drops = start[8] != ":" if asked is None else asked
    whose = "--start-timecode" if timebase.start_timecode else f"--frame-rate: {source.name}: its start timecode"
    if drops and rate not in DROP_FRAME_RATES:
        raise RuleError(f"{whose} {start!r}: {rate_text(rate)} frames a second have no drop-frame")
    text = _marked(start, drops=drops)
    try:
        frame_of(text, nominal, drop_frame=drops)
    except RuleError as error:
        raise RuleError(f"{whose} {str(error).removeprefix('timecode ')}") from error
    return msgspec.structs.replace(source, start_timecode=text)

"""One event as an edited file has it, and its numbers as they are written there."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ...errors import TimelineError
from ...model import Event, Origin, Rejection, Source
from ...units import nearest

_COARSEST_S = Fraction(1, 1000)
"""The step of the coarsest tool, REAPER: what is off by more was moved."""

_WHOLE = re.compile(r"[+-]?\d+(,0*|\.0?)?|[^.,]*")
"""A whole number of a table with decimal commas, where a point may part thousands: `48.000` is 48000 or 48."""

_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}\.\d{3}")
"""What may have a point between its thousands in any table: `96.000` is 96000 where it was written with one."""

_NO_TIMECODE = "a number of seconds from the film's first sample, such as 19.75, and no timecode"

_LONGEST_NUMBER = 40
_WIDEST_EXPONENT = 100


@dataclass(frozen=True)
class Point:
    """A time as a row gives it: as a sample, in seconds, or both; not negative.

    `step_s` is the step to which the seconds were written: the tool may have rounded by up to that. `said` is how the
    file says it, for messages: the sample, then the seconds.
    """

    sample: int | None = None
    seconds: Fraction | None = None
    step_s: Fraction = Fraction(0)
    said: tuple[str, ...] = field(default=(), compare=False)

    def said_as(self, sample: int) -> str:
        """Return how the file says a sample that this was taken for."""
        return self.said[0 if self.sample == sample else -1] if self.said else f"sample {sample}"

    @property
    def tool_step_s(self) -> Fraction:
        """Return the step, as far as a tool may be the reason for it: what is off by more was moved."""
        return min(self.step_s, _COARSEST_S)

    def exact_s(self, rate_hz: int) -> Fraction:
        """Return the seconds as written, or those of the sample."""
        if self.seconds is not None:
            return self.seconds
        assert self.sample is not None
        return Fraction(self.sample, rate_hz)

    def nearest(self, rate_hz: int) -> int:
        """Return the sample, or the one nearest to the seconds, halves upwards."""
        if self.sample is not None:
            return self.sample
        assert self.seconds is not None
        return nearest_sample(self.seconds, rate_hz)

    def may_be(self, sample: int, rate_hz: int) -> bool:
        """Return whether this is the given sample, as far as the digits tell; seconds alone have to be fine enough."""
        if self.sample is not None:
            return self.sample == sample and (self.seconds is None or self.seconds_may_be(sample, rate_hz))
        return replace(self, step_s=self.tool_step_s).seconds_may_be(sample, rate_hz)

    def seconds_may_be(self, sample: int, rate_hz: int) -> bool:
        """Return whether the seconds are those of the given sample, rounded or cut off at their last digit."""
        assert self.seconds is not None
        if nearest_sample(self.seconds, rate_hz) == sample:
            return True
        return -self.step_s / 2 <= Fraction(sample, rate_hz) - self.seconds < self.step_s


@dataclass(frozen=True)
class Edit:
    """One event of an edited file; None where the file does not say.

    `place` is where it stands in the file, for messages. `text` is a label in which an id may stand. `blast_start` is
    a column that nobody edits, which tells where the onset was. `aside` is what stands in columns that are not read but
    that somebody may take for ones that are, by their names. `emptied` are a table's confidence, gain and ends of the
    window that have columns, but nothing in this row.
    """

    place: str
    onset: Point
    id: str | None = None
    text: str = ""
    window_start: Point | None = None
    window_stop: Point | None = None
    confidence: Decimal | None = None
    gain_db: Decimal | None = None
    blast_start: int | None = None
    origin: Origin | None = None
    aside: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    emptied: tuple[str, ...] = ()


@dataclass(frozen=True)
class Pair:
    """A row, the original event that it is of, if any, and its id, if it has one."""

    edit: Edit
    was: Event | None
    id: str | None

    def tells_its_past(self, rate_hz: int) -> bool:
        """Return whether the row says where it was: by its blast, and that it is no copy, by its id or its place."""
        before = self.edit.blast_start
        return before is not None and (self.id is not None or self.edit.onset.may_be(before, rate_hz))


@dataclass(frozen=True)
class EditedFile:
    """An edited file that has been read.

    `shows_ends` says that the tool shows each event as a range: who moves it sees where it ends. `own` are the events
    as a JSON timeline itself says they were before the edits; `source` and `rejections` are its, too. `aside` is what
    it says of the whole film and is not read, as in `Edit`; `made_with` is what it says of how it was made.
    `steps` are those to which the tool has written the numbers of a column, where that is coarse.
    """

    path: Path
    edits: tuple[Edit, ...]
    shows_ends: bool = False
    notes: tuple[str, ...] = ()
    source: Source | None = None
    own: Mapping[str, Event] = field(default_factory=lambda: MappingProxyType({}))
    rejections: tuple[Rejection, ...] = ()
    aside: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    made_with: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    steps: Mapping[str, Decimal] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True)
class Cell:
    """A piece of text in a file: where it stands, what it is called there, and what it says."""

    path: Path
    place: str
    name: str
    text: str

    @property
    def said(self) -> str:
        """Return the cell as messages name it."""
        return f"{self.name} = {self.text!r}"

    def refused(self, expected: str) -> TimelineError:
        """Return the error that says what was expected in place of the text."""
        return TimelineError(f"{self.path}: {self.place}: {self.said}: expected {expected}")

    def number(self, *, decimal_comma: bool = False, expected: str = "a number") -> Decimal:
        """Return the number that the text is; with `decimal_comma`, a comma may part its decimals."""
        text = self.text.strip()
        if decimal_comma and text.count(",") == 1 and "." not in text:
            text = text.replace(",", ".")
        try:
            number = Decimal(text) if len(text) <= _LONGEST_NUMBER and "_" not in text else Decimal("nan")
        except InvalidOperation:
            number = Decimal("nan")
        if not number.is_finite() or abs(number.adjusted()) > _WIDEST_EXPONENT:
            raise self.refused(expected)
        return number

    def sample(self, *, decimal_comma: bool = False) -> int:
        """Return the sample index that the text is; `48001.0` is one, `1.2E+08` has lost digits."""
        number = self.number(decimal_comma=decimal_comma)
        text = self.text.strip()
        if _THOUSANDS.fullmatch(text) or (decimal_comma and not _WHOLE.fullmatch(text)):
            raise self.refused("a whole number of samples, without a point between its thousands")
        if number != number.to_integral_value() or _exponent(number) > 0:
            raise self.refused("a whole number of samples, with all its digits")
        if number < 0:
            raise self.refused("a sample from 0, the first of the track")
        return int(number)

    def seconds(self, *, decimal_comma: bool = False) -> Point:
        """Return the time that the text is, in seconds."""
        expected = _NO_TIMECODE if ":" in self.text else "a number of seconds"
        number = self.number(decimal_comma=decimal_comma, expected=expected)
        if number < 0:
            raise self.refused("a time from 0, the first frame of the track")
        return Point(seconds=Fraction(number), step_s=Fraction(10) ** _exponent(number), said=(self.said,))


def with_common_steps(edits: Sequence[Edit]) -> tuple[Edit, ...]:
    """Return the rows with the steps to which their times were written.

    A tool writes a column with as many decimals, or as many digits, everywhere. A number that has fewer has lost zeros
    at its end, or was typed.
    """
    onsets = _with_common_steps([edit.onset for edit in edits])
    starts = _with_common_steps([edit.window_start for edit in edits])
    stops = _with_common_steps([edit.window_stop for edit in edits])
    return tuple(
        replace(edit, onset=onset or edit.onset, window_start=start, window_stop=stop)
        for edit, onset, start, stop in zip(edits, onsets, starts, stops, strict=True)
    )


def _with_common_steps(points: Sequence[Point | None]) -> list[Point | None]:
    timed = [point for point in points if point is not None and point.seconds is not None]
    finest = min((point.step_s for point in timed), default=Fraction(0))
    most = max((_magnitude(point) / point.step_s for point in timed), default=Fraction(1))
    return [
        replace(point, step_s=min(point.step_s, max(finest, _magnitude(point) / most)))
        if point is not None and point.seconds is not None
        else point
        for point in points
    ]


def _magnitude(point: Point) -> Fraction:
    """Return the place of a time's first digit, a power of ten."""
    assert point.seconds is not None
    if not point.seconds:
        return point.step_s
    return Fraction(10) ** math.floor(math.log10(point.seconds))


def nearest_sample(seconds: Fraction, rate_hz: int) -> int:
    """Return the sample nearest to a time, halves upwards."""
    return nearest(seconds * rate_hz)


def _exponent(number: Decimal) -> int:
    exponent = number.as_tuple().exponent
    assert isinstance(exponent, int)  # the number is finite
    return exponent

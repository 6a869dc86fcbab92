"""What the numbers of a row mean, beside those of the event that it was: which was edited, and which only rounded."""

import re
from decimal import Decimal

from ...errors import TimelineError
from ...model import Event
from ..geometry import FROM_GAIN_DB, TO_GAIN_DB
from .gains import gain_in_label
from .row import Edit, EditedFile, Point, nearest_sample

WITH_CONFIDENCE = re.compile(r"(\S+) ([01]\.\d\d)")
"""A label as it is exported: an id and a confidence."""

_FINE, _TENTH = Decimal("0.01"), Decimal("0.1")
"""A program that rounds gains and confidences keeps a hundredth, a spreadsheet perhaps a tenth; less was typed."""


def settled(edited: EditedFile, edit: Edit, name: str, point: Point, before: int | None, rate_hz: int) -> int:
    """Return the sample that a row means: what it was before, unless sample or seconds say that it was moved."""
    if before is not None and point.may_be(before, rate_hz):
        return before
    if point.sample is None or point.seconds is None or point.seconds_may_be(point.sample, rate_hz):
        return point.nearest(rate_hz)
    if point.sample == before:
        return nearest_sample(point.seconds, rate_hz)
    if before is not None and point.seconds_may_be(before, rate_hz):
        return point.sample
    seconds = f"{float(point.seconds):.9g}"
    raise TimelineError(
        f"{edited.path}: {edit.place}: {name}_sample = {point.sample} and {name}_s = {seconds} contradict each other: "
        f"that is sample {nearest_sample(point.seconds, rate_hz)} at {rate_hz} Hz; expected one time, or one cell empty"
    )


def ends(
    edited: EditedFile, edit: Edit, was: Event | None, onset: int, *, moved: bool, rate_hz: int
) -> tuple[int | None, int | None]:
    """Return the ends of the window that were set by hand.

    An end that is where it was is not, unless its event was moved in a tool that shows the event with it. Where the
    original is not known every end counts, but of a moved row of a table, whose window stayed behind.
    """
    stays_behind = moved and not edited.shows_ends
    if was is None and stays_behind:
        return None, None
    found: list[int | None] = []
    for name, point, before in (
        ("window_start", edit.window_start, was.window.start if was else None),
        ("window_stop", edit.window_stop, was.window.stop if was else None),
    ):
        end = None if point is None else settled(edited, edit, name, point, before, rate_hz)
        if end is None or (end == before and stays_behind):
            found.append(None)
            continue
        if (end > onset) if name == "window_start" else (end <= onset):
            wanted = "at most" if name == "window_start" else "more than"
            said, limit = f"{name}_sample = {end}", str(onset)
            if edited.shows_ends and point is not None:  # no column there has such a name
                said, limit = point.said[-1], edit.onset.said[-1]
            elif point is not None and point.sample != end and point.seconds is not None:  # the cell that was taken
                said, limit = f"{name}_s = {float(point.seconds):.9g}", f"{onset / rate_hz:.9g}"
            raise TimelineError(f"{edited.path}: {edit.place}: {said}: expected {wanted} {limit}, the onset")
        found.append(None if end == before and not moved else end)
    start, stop = found
    return start, stop


def confidence(edited: EditedFile, edit: Edit, was: Event | None) -> float | None:
    """Return the confidence that the file has, unless that is the original's with fewer digits."""
    said = edit.confidence
    if said is None:
        rated = None if was else WITH_CONFIDENCE.match(edit.text)
        said = Decimal(rated[2]) if rated else None
    if said is None:
        return was.confidence if was else None
    if not 0 <= said <= 1:
        raise TimelineError(f"{edited.path}: {edit.place}: confidence = {said}: expected 0 to 1")
    step = edited.steps.get("confidence", _FINE)
    return was.confidence if was and _rounds_to(was.confidence, said, step) else float(said)


def gain_db(edited: EditedFile, edit: Edit, was: Event | None, identity: str) -> float:
    """Return the gain that the file has, in its column or in its label; without one, the original's or none."""
    said = edit.gain_db if edit.gain_db is not None else gain_in_label(edited, edit, identity)
    if said is None:
        return was.gain_db if was else 0.0
    if not FROM_GAIN_DB <= said <= TO_GAIN_DB:
        expected = f"{FROM_GAIN_DB} to {TO_GAIN_DB} dB"
        raise TimelineError(f"{edited.path}: {edit.place}: gain_db = {said}: expected {expected}")
    step = edited.steps.get("gain_db", _FINE)
    return was.gain_db if was and _rounds_to(was.gain_db, said, step) else float(said)


def _rounds_to(value: float, said: Decimal, column_step: Decimal) -> bool:
    """Return whether what is said is a value, rounded or cut off at the last digit that is said, or at a hundredth.

    In a column whose longest number has one decimal it may be rounded to that.
    """
    exponent = said.as_tuple().exponent
    assert isinstance(exponent, int)
    before, now = Decimal(repr(value)), abs(said)
    if before * said < 0:
        return False
    if exponent == -1 and column_step == _TENTH:
        return -_TENTH / 2 <= abs(before) - now < _TENTH / 2
    step = min(Decimal(1).scaleb(exponent), _FINE)
    return float(said) == value or -step / 2 <= abs(before) - now < step

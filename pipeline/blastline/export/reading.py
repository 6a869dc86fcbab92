"""Reading `timeline.json` back, and saying in one line why a file cannot be used."""

import codecs
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec

from ..errors import TimelineError
from ..misfits import misfit
from ..model import SCHEMA, Timeline
from .geometry import event_complaints, source_complaints
from .kinds import kind_of_content, kind_of_json, kind_of_table, kind_of_text

_EXPECTED = "a timeline.json"
_LONGEST_SHOWN = 40
_LARGEST_INTEGER = 2**53  # beyond it a number that has been a float is another
_NUMBER = re.compile(r"(?<=[:,\[\s])-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?(?=\s*[,\]}])")
_MALFORMED = re.compile(r"JSON is malformed: (.*) \(byte (\d+)\)")


def read_timeline(path: Path) -> Timeline:
    """Return the timeline in a file.

    Raises TimelineError where there is no such file, where it is not JSON, where its schema is not the one this
    version writes, or where a field is missing or holds what it cannot: two events of one id, a negative time, an
    onset outside its window or the film.
    """
    plain = read_plain(path, read_text(path, expected=_EXPECTED), expected=_EXPECTED)
    try:
        timeline = msgspec.convert(plain, Timeline)
    except msgspec.ValidationError as error:
        raise TimelineError(f"{path}: {_with_way_out(misfit(plain, error, Timeline))}") from error
    for complaint in _complaints(timeline):
        raise TimelineError(f"{path}: {_with_way_out(complaint)}")
    return timeline


def _with_way_out(complaint: str) -> str:
    """Return a complaint, and what makes the timeline whole where it is of an event that was edited by hand."""
    if re.match(r"events\[\d+\](\.\w+: is missing|\.onset_s = )", complaint):
        return f"{complaint}; of an edited timeline `blastline render FILM --timeline FILE` makes a whole one"
    return complaint


def read_plain(path: Path, text: str, *, expected: str) -> Any:
    """Return what a timeline's JSON holds as plain data, once its schema has proved to be the one that is known.

    Raises TimelineError, which says what was expected, for text that is no such JSON, and for integers that no sample
    count, and no array, can hold.
    """
    try:
        plain = msgspec.json.decode(text)
    except (msgspec.DecodeError, RecursionError) as error:
        raise TimelineError(f"{path}: {_not_json(text, error)}; expected {expected}") from error
    _refuse_schema(plain, path, expected=expected)
    for key, value in _integers(plain):
        if abs(value) > _LARGEST_INTEGER:
            raise TimelineError(f"{path}: {key} = {value}: expected a whole number up to 2^53")
    return plain


def read_text(path: Path, *, expected: str) -> str:
    """Return what is in a text file: UTF-8 or UTF-16 with or without a mark, otherwise Windows' Western alphabet.

    TimelineError says why it cannot be read, or that it holds what no text does, and what was expected there.
    """
    content = _content(path, expected=expected)
    if kind := kind_of_content(content):
        raise TimelineError(f"{path}: {kind}; expected {expected}")
    encoding = "utf-8-sig"
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encoding = "utf-16"
    elif b"\0" in content[:2]:
        encoding = "utf-16-be" if content[:1] == b"\0" else "utf-16-le"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError:
        text = content.decode("cp1252", errors="replace")
    if "\0" in text:
        raise TimelineError(f"{path}: not text; expected {expected}")
    return text


def _content(path: Path, *, expected: str) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError as error:
        raise TimelineError(f"{path}: no such file; expected {expected}") from error
    except OSError as error:
        raise TimelineError(f"{path}: cannot be read: {error.strerror}; expected {expected}") from error


def _not_json(text: str, error: Exception) -> str:
    """Return what a text is that is no JSON, or where it stops being any and why."""
    if what := kind_of_text(text):
        return what
    if what := kind_of_table(text):
        return f"{what}, which only `blastline render --timeline` reads"
    if not text.strip():
        return "an empty file"
    if isinstance(error, RecursionError):
        return "not JSON: nested too deeply"
    if said := _MALFORMED.fullmatch(str(error)):
        return f"{_place(text.encode()[: int(said[2])].decode(errors='ignore'))}: not JSON: {said[1]}"
    huge = next((number for number in _NUMBER.finditer(text) if math.isinf(float(number[0]))), None)
    if isinstance(error, msgspec.ValidationError) and huge:
        return f"{_place(text[: huge.start()])}: {huge[0][:_LONGEST_SHOWN]}: too large for a number"
    return "not JSON: it ends too early"


def _place(before: str) -> str:
    """Return the line and column that come after a text."""
    return f"line {before.count(chr(10)) + 1}, column {len(before) - (before.rfind(chr(10)) + 1) + 1}"


def _refuse_schema(plain: Any, path: Path, *, expected: str) -> None:
    if what := kind_of_json(plain):
        raise TimelineError(f"{path}: {what}; expected {expected}")
    if not isinstance(plain, dict) or "schema" not in plain:
        raise TimelineError(f"{path}: JSON without schema = {SCHEMA!r}; expected {expected}")
    found = plain["schema"]
    if found != SCHEMA:
        writer = f", written by blastline {plain['version']}" if "version" in plain else ""
        raise TimelineError(f"{path}: schema = {found!r}{writer}: this version reads only {SCHEMA!r}")


def _integers(plain: Any) -> Iterator[tuple[str, int]]:
    """Yield every integer in plain data with the path of its key; without recursion, since data may nest deeply."""
    left = [("", plain)]
    while left:
        key, value = left.pop()
        if isinstance(value, dict):
            left += [(f"{key}.{name}" if key else name, each) for name, each in value.items()]
        elif isinstance(value, list):
            left += [(f"{key}[{index}]", each) for index, each in enumerate(value)]
        elif isinstance(value, int):
            yield key, value


def _complaints(timeline: Timeline) -> Iterator[str]:
    """Yield what the types alone cannot refuse."""
    yield from source_complaints(timeline.source)
    first_of: dict[str, int] = {}
    for index, event in enumerate(timeline.events):
        if event.id in first_of:
            yield f"events[{index}].id = {event.id!r}: events[{first_of[event.id]}] has it too; expected each id once"
        first_of[event.id] = index
        yield from event_complaints(event, f"events[{index}]", timeline.source)

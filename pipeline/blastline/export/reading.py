"""Reading `timeline.json` back, and saying in one line why a file cannot be used."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec

from ..errors import TimelineError, misfit
from ..model import SCHEMA, Event, Timeline


def read_timeline(path: Path) -> Timeline:
    """Return the timeline in a file.

    Raises TimelineError where there is no such file, where it is not JSON, where its schema is not the one this
    version writes, or where a field is missing or holds what it cannot: two events of one id, a negative time.
    """
    plain = read_plain(path, read_content(path, expected="a timeline.json"))
    try:
        timeline = msgspec.convert(plain, Timeline)
    except msgspec.ValidationError as error:
        raise TimelineError(f"{path}: {misfit(plain, error)}") from error
    for complaint in _complaints(timeline):
        raise TimelineError(f"{path}: {complaint}")
    return timeline


def read_plain(path: Path, content: bytes) -> Any:
    """Return what a timeline's JSON holds as plain data, once its schema has proved to be the one that is known."""
    try:
        plain = msgspec.json.decode(content)
    except (msgspec.DecodeError, RecursionError) as error:
        raise TimelineError(f"{path}: not JSON: {error}; expected a timeline.json") from error
    _refuse_schema(plain, path)
    return plain


def read_content(path: Path, *, expected: str) -> bytes:
    """Return what is in a file; TimelineError says why it cannot be read, and what was expected there."""
    try:
        return path.read_bytes()
    except FileNotFoundError as error:
        raise TimelineError(f"{path}: no such file; expected {expected}") from error
    except OSError as error:
        raise TimelineError(f"{path}: cannot be read: {error.strerror}; expected {expected}") from error


def _refuse_schema(plain: Any, path: Path) -> None:
    if not isinstance(plain, dict) or "schema" not in plain:
        raise TimelineError(f"{path}: not a timeline; expected an object with schema = {SCHEMA!r}")
    found = plain["schema"]
    if found != SCHEMA:
        writer = f", written by blastline {plain['version']}" if "version" in plain else ""
        raise TimelineError(f"{path}: schema = {found!r}{writer}: this version reads only {SCHEMA!r}")


def _complaints(timeline: Timeline) -> Iterator[str]:
    """Yield what the types alone cannot refuse."""
    first_of: dict[str, int] = {}
    for index, event in enumerate(timeline.events):
        if event.id in first_of:
            yield f"events[{index}].id = {event.id!r}: events[{first_of[event.id]}] has it too; expected each id once"
        first_of[event.id] = index
        for key, value in _times(event):
            if value < 0:
                yield f"events[{index}].{key} = {value}: expected a time from 0, the first frame of the track"


def _times(event: Event) -> Iterator[tuple[str, float]]:
    """Yield each time of an event that its type lets be negative; ranges do not run backwards, so starts are enough."""
    yield "onset_s", event.onset_s
    yield "blast.start_sample", event.blast.start
    for index, reflection in enumerate(event.reflections):
        yield f"reflections[{index}].delay_ms", reflection.delay_ms

"""The edited `timeline.json`: every field of an event but its onset may be missing, and is found out again."""

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from ...errors import TimelineError
from ...misfits import listed, misfit, shown
from ...model import Event, Origin, Ratio, Rejection, Source, Window
from ..geometry import reflection_complaints, source_complaints
from ..reading import read_plain
from .row import Edit, EditedFile, Point

_Seconds = Annotated[float, Meta(ge=0.0, le=1e9)]
_Sample = Annotated[int, Meta(ge=0, le=2**53)]

_EVENT_ASIDE = (
    "timecode",
    "drive.model",
    "window.fade_in_samples",
    "window.fade_out_samples",
    "blast.stop_sample",
    "reflections",
)
"""What somebody may edit though it is chosen, planned or measured anew."""

_FILM_ASIDE = (
    "level_db",
    "phase",
    "background",
    "quality",
    "source.start_timecode",
    "source.frame_rate",
    "source.sample_rate_hz",
    "source.frames",
)

_USUAL: Mapping[str, Any] = {"confidence": 1.0, "timecode": "", "burst": None, "shot_in_burst": None}
"""What an event may lack and still be the one that it was: it is as usual, or nothing is taken from it."""

MADE_WITH = ("quality", "rules_digest", "actuator", "phase", "background", "level_db")
"""What a timeline says of its making."""


class _Blast(msgspec.Struct, frozen=True):
    start_sample: int | None = None


class _Window(msgspec.Struct, frozen=True):
    start_sample: _Sample | None = None
    stop_sample: _Sample | None = None


class _Event(msgspec.Struct, frozen=True):
    id: str | None = None
    onset_sample: _Sample | None = None
    onset_s: _Seconds | None = None
    confidence: Ratio | None = None
    gain_db: float | None = None
    origin: Origin | None = None
    blast: _Blast | None = None
    window: _Window | None = None


class _Timeline(msgspec.Struct, frozen=True):
    source: Source
    events: tuple[_Event, ...]
    rejections: tuple[Rejection, ...] = ()


def read_document(text: str, path: Path, *, expected: str) -> EditedFile:
    """Return the events of a timeline that somebody edited; its schema has to be the one this version reads.

    `expected` says which files were, where this is none. Keys of events and windows that no timeline has are left
    aside, with a note.
    """
    plain = read_plain(path, text, expected=expected)
    _refuse_repeated_keys(text, path)
    try:
        timeline = msgspec.convert(plain, _Timeline)
    except msgspec.ValidationError as error:
        raise TimelineError(f"{path}: {misfit(plain, error, _Timeline)}") from error
    for complaint in source_complaints(timeline.source):
        raise TimelineError(f"{path}: {complaint}")
    edits = tuple(
        _edit(event, _said(fields, _EVENT_ASIDE), index, path)
        for index, (event, fields) in enumerate(zip(timeline.events, plain["events"], strict=True))
    )
    return EditedFile(
        path,
        edits,
        notes=_notes(plain["events"]),
        source=timeline.source,
        own=_as_it_was(plain["events"], path),
        rejections=timeline.rejections,
        aside=_said(plain, _FILM_ASIDE),
        made_with=_said(plain, MADE_WITH),
    )


def _refuse_repeated_keys(text: str, path: Path) -> None:
    """Raise TimelineError where a group has a key twice: of a line that was copied, one would be lost unseen."""

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        group: dict[str, Any] = {}
        for key, value in pairs:
            if key in group:
                where = f"of {group['id']!r} " if isinstance(group.get("id"), str) else ""
                both = f"{shown(group[key])} and {shown(value)}"
                raise TimelineError(f"{path}: {key} {where}is there twice, as {both}; expected it once")
            group[key] = value
        return group

    try:
        json.loads(text, object_pairs_hook=once)
    except RecursionError as error:
        raise TimelineError(f"{path}: not JSON that can be read: nested too deeply") from error


def _notes(plain: list[Any]) -> tuple[str, ...]:
    names = list(dict.fromkeys(name if name.isprintable() else repr(name) for name in _unknown(plain)))
    if not names:
        return ()
    return (f"not used: key {listed(names)}",)


def _unknown(plain: list[Any]) -> Iterator[str]:
    """Yield the keys of events and their windows that are none of a timeline's: misspelt, or in another's place."""
    of_event, of_window = ({each.encode_name for each in msgspec.structs.fields(kind)} for kind in (Event, Window))
    for fields in plain:
        yield from (key for key in fields if key not in of_event)
        yield from (f"window.{key}" for key in fields.get("window") or {} if key not in of_window)


def _said(fields: Mapping[str, Any], names: Iterable[str]) -> dict[str, Any]:
    """Return what stands in keys that are not read but that somebody may edit, by their names."""
    return {name: value for name in names if (value := value_at(fields, name)) is not None}


def value_at(fields: Mapping[str, Any], name: str) -> Any:
    """Return the plain value of a key, as in `window.start_sample`; None where there is none."""
    value: Any = fields
    for key in name.split("."):
        value = value.get(key) if isinstance(value, dict) else None
    return value


def _edit(event: _Event, aside: Mapping[str, Any], index: int, path: Path) -> Edit:
    place = f"events[{index}]"
    if event.onset_sample is None and event.onset_s is None:
        raise TimelineError(f"{path}: {place}: no onset; expected onset_sample or onset_s")
    if event.id is not None and "\0" in event.id:
        raise TimelineError(f"{path}: {place}.id = {event.id!r}: expected a text without NUL, which no table can hold")
    window = event.window or _Window()
    seconds = None if event.onset_s is None else Decimal(repr(event.onset_s))
    return Edit(
        place,
        _onset(event.onset_sample, seconds),
        id=event.id,
        window_start=None if window.start_sample is None else Point(window.start_sample),
        window_stop=_stop(window.stop_sample),
        confidence=None if event.confidence is None else Decimal(repr(event.confidence)),
        gain_db=None if event.gain_db is None else Decimal(repr(event.gain_db)),
        blast_start=_from_0(event.blast.start_sample) if event.blast else None,
        origin=event.origin,
        aside=aside,
    )


def _from_0(sample: int | None) -> int | None:
    return sample if sample is not None and sample >= 0 else None


def _stop(sample: int | None) -> Point | None:
    return None if sample is None else Point(sample, said=(f"window.stop_sample = {sample}",))


def _onset(sample: int | None, seconds: Decimal | None) -> Point:
    said = () if sample is None else (f"onset_sample = {sample}",)
    if seconds is None:
        return Point(sample, said=said)
    exponent = seconds.as_tuple().exponent
    assert isinstance(exponent, int)  # JSON holds no NaN
    point = Point(sample, Fraction(seconds), Fraction(10) ** exponent, (*said, f"onset_s = {seconds}"))
    return replace(point, step_s=point.tool_step_s)  # nobody cuts off the digits of a whole column, as in a table


def _as_it_was(plain: list[Any], path: Path) -> Mapping[str, Event]:
    """Return the events of which enough is there, by id; the blast, which nobody edits, tells where an onset was.

    Onsets and windows are somebody's edits, which are judged beside the film; nobody edits a reflection. One
    number of an onset is enough, so neither is asked for here.
    """
    found: dict[str, Event] = {}
    for index, fields in enumerate(plain):
        said = {key: value for key, value in fields.items() if value is not None}
        try:
            event = msgspec.convert({**_USUAL, **said, "onset_sample": 0, "onset_s": 0.0}, Event)
        except msgspec.ValidationError:
            continue  # an event that was added with its onset alone has no past
        for complaint in reflection_complaints(event.reflections, f"events[{index}]"):
            raise TimelineError(f"{path}: {complaint}")
        if event.blast.start >= 0:
            found.setdefault(event.id, msgspec.structs.replace(event, onset_sample=event.blast.start))
    return found

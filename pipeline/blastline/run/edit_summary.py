"""What somebody has edited of a timeline, counted and in words."""

from bisect import bisect_left, bisect_right
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any

import msgspec

from ..export.edits import EditedFile, Wanted, Wish, value_at
from ..misfits import listed
from ..model import Edits, Event, Source, Timeline
from ..render import PlannedWindow
from ..timecode import frame_scale, timecode_at
from . import names

_MOST_MISSING = 10

_DRIVE_INSTEAD = "--drive chooses it, for all shots"
_FADES_INSTEAD = "the rules' [windows] have it, for all shots"
_INSTEAD = {
    "timecode": "onset_s or onset_sample moves a shot",
    "drive_model": _DRIVE_INSTEAD,
    "drive.model": _DRIVE_INSTEAD,
    "window.fade_in_samples": _FADES_INSTEAD,
    "window.fade_out_samples": _FADES_INSTEAD,
    "level_db": "--level sets it",
    "phase": "--phase chooses it",
    "background": "--background chooses it",
    "quality": "--quality chooses it",
    "source.start_timecode": "--start-timecode sets it",
    "source.frame_rate": "--frame-rate sets it",
}
"""What does what somebody may have meant who edited a table's column, or a JSON's key, that is not read."""

_MEASURED = "it is measured in the film"
_STAYS = frozenset({"drive_model", "drive.model", "window.fade_in_samples", "window.fade_out_samples"})
"""What nobody expects to change when a shot is moved."""

_TOLD_OF_MOVED = _STAYS | {"timecode"}
_CLOCK_STEPS_HZ = 1000  # a film without frames has its times to the millisecond


def unused_settings(edited: EditedFile, original: Timeline) -> Iterator[str]:
    """Yield a note for each key of the whole film that an edited JSON has otherwise than its original."""
    plain = _as_in_json(original)
    for name, now in edited.aside.items():
        if now != value_at(plain, name):
            yield f"not used: {name}, which was edited; {_INSTEAD.get(name, _MEASURED)}"


def summarise_edits(
    edited: EditedFile,
    wanted: Wanted,
    windows: Sequence[PlannedWindow],
    source: Source,
    *,
    has_original: bool,
    is_named: bool,
) -> Edits:
    """Return how many events an edited file keeps, moves, changes, adds and deletes, with what a user has to know.

    `windows` are those of the wishes. `has_original` says whether the original timeline is known, `is_named` whether
    anything names the film.
    """
    notes = list(edited.notes)
    if not is_named:
        notes.append(
            f"no original (--original, or a {names.TIMELINE} beside the file): nothing names the film, and every event "
            "is measured anew"
        )
    if not has_original and edited.own:
        notes.append(
            "nothing to compare the timeline with (--original), which matters only if it was edited: it tells itself "
            "which shots were moved; what was deleted cannot be known, and is still felt where it shared a window; "
            "changed gains, ends and confidences hold as they stand, and count as kept"
        )
        notes += _gaps(edited, wanted)
    notes += wanted.notes
    notes += _unheeded(edited, wanted, source)
    starts, stops = _overruled(wanted.wishes, windows)
    notes += _overruled_ends(starts, stops)
    told = {edit.place for edit in edited.edits if edit.blast_start is not None}
    used = [_as_used(wish, starts, stops) for wish in wanted.wishes]
    ways = [_way(wish, tells_onset=wish.place in told) for wish in used]
    return Edits(
        file=edited.path.name,
        kept=ways.count("kept"),
        moved=ways.count("moved"),
        changed=ways.count("changed"),
        added=ways.count("added"),
        deleted=len(wanted.deleted),
        as_given=ways.count("as given"),
        notes=tuple(notes),
    )


def _unheeded(edited: EditedFile, wanted: Wanted, source: Source) -> Iterator[str]:
    """Yield a note for each column or key that is not read and was edited, and does not follow from a shot's new place.

    Where it is another for every shot, nobody typed it: the file was exported or rendered with other options.
    """
    aside = {edit.place: edit.aside for edit in edited.edits}
    originals = {wish.was.id: _as_in_json(wish.was) for wish in wanted.wishes if wish.was is not None}
    for name in dict.fromkeys(name for said in aside.values() for name in said):
        told = [
            (wish, aside[wish.place][name], _exported(originals[wish.was.id], name))
            for wish in wanted.wishes
            if wish.was is not None and (wish.unmoved or name in _TOLD_OF_MOVED) and name in aside[wish.place]
        ]
        other = [
            wish.id
            for wish, now, before in told
            if before is not None and now != before and not (name == "timecode" and _came_along(now, wish, source))
        ]
        if other and (len(other) < len(told) or len(told) == 1):
            instead = _INSTEAD.get(name, _MEASURED)
            yield f"not used: the {name} of {_listed(other)}, which was edited; {instead}"


def _came_along(timecode: str, wish: Wish, source: Source) -> bool:
    """Return whether a shot's timecode was edited with its time: it is that of its new place, to a frame."""
    if wish.unmoved:
        return False
    scale = frame_scale(source)
    step = round(source.sample_rate_hz / (scale.rate if scale else _CLOCK_STEPS_HZ))
    return timecode in {timecode_at(source, wish.onset + aside) for aside in (-step, 0, step)}


def _overruled(wishes: Sequence[Wish], windows: Sequence[PlannedWindow]) -> tuple[frozenset[str], frozenset[str]]:
    """Return the ids of the wishes whose start, and whose end, is in the midst of a window that others begin or end."""
    starts, stops = set(), set()
    for planned in windows:
        for wish in (wishes[index] for index in planned.shots):
            was = wish.was.window if wish.was is not None else None
            if wish.start not in (None, planned.window.start, was and was.start):
                starts.add(wish.id)
            if wish.stop not in (None, planned.window.stop, was and was.stop):
                stops.add(wish.id)
    return frozenset(starts), frozenset(stops)


def _overruled_ends(starts: Collection[str], stops: Collection[str]) -> Iterator[str]:
    """Yield a note for the ends that were set and are not used."""
    if starts:
        yield f"not used: the start that was set of {_listed(starts)}: the shared window begins with its first shot"
    if stops:
        yield f"not used: the end that was set of {_listed(stops)}: the shared window ends with a later shot"


def _as_used(wish: Wish, starts: Collection[str], stops: Collection[str]) -> Wish:
    """Return a wish without the ends that are not used."""
    return replace(wish, start=None if wish.id in starts else wish.start, stop=None if wish.id in stops else wish.stop)


def _listed(ids: Collection[str]) -> str:
    return listed(sorted(ids))


def _as_in_json(kept: Timeline | Event) -> Any:
    """Return what an edited JSON has where nothing was edited: lists, where ours has tuples."""
    return msgspec.json.decode(msgspec.json.encode(kept))


def _exported(plain: Mapping[str, Any], name: str) -> Any:
    """Return what a table or JSON has of an event in a column or key that is not read back."""
    return value_at(plain, "drive.model" if name == "drive_model" else name)


def _gaps(edited: EditedFile, wanted: Wanted) -> list[str]:
    """Return a note for the shots that are missing in the bursts, which are numbered without gaps."""
    bursts: dict[int, dict[int, int]] = {}
    for event in edited.own.values():
        if event.burst is not None and event.shot_in_burst is not None:
            bursts.setdefault(event.burst, {})[event.shot_in_burst] = event.onset_sample
    known = sorted(event.onset_sample for event in edited.own.values())
    bare = sorted(wish.onset for wish in wanted.wishes if wish.was is None)
    missing = [
        f"{burst}.{number}"
        for burst, there in sorted(bursts.items())
        for number in islice(_missing(there, known, bare), _MOST_MISSING + 1)
    ]
    if not missing:
        return []
    more = " and more" if len(missing) > _MOST_MISSING else ""
    return [f"missing in its burst: shot {', '.join(missing[:_MOST_MISSING])}{more}; give the original with --original"]


def _missing(there: Mapping[int, int], known: Sequence[int], bare: Sequence[int]) -> Iterator[int]:
    """Yield the numbers that no shot of a burst has; `there` are the onsets of the others.

    Events that say no more than their onset, `bare` ascending, may be those they lie between: as many are not missed.
    `known` are the onsets of all others, ascending.
    """
    before = 0
    for number, onset in sorted(there.items()):
        after = bisect_left(known, onset)
        since = known[after - 1] if after else -1
        perhaps = bisect_left(bare, onset) - bisect_right(bare, since)
        yield from range(before + 1 + perhaps, number)
        before = number


def _way(wish: Wish, *, tells_onset: bool) -> str:
    """Return in which way an event was edited.

    Where there is no original, only a row that tells where its onset was tells whether it is there still.
    """
    if wish.was is None:
        if wish.origin == "added":
            return "added"
        if not tells_onset:
            return "as given"
        return "moved" if wish.origin == "moved" else "kept"
    if wish.changed:
        return "changed"
    return "kept" if wish.unmoved else "moved"

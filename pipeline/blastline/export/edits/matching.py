"""What became of each event: edited rows beside the events that they were exported from.

A row is an original event by its id, or, where it has none or a new one, by its time. As long as the digits of the file
allow it, an event is where it was; otherwise it was moved. An original that no row is any more was deleted.
"""

import re
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

from ...errors import TimelineError
from ...model import Event, Origin, Window
from .counts import refuse_other_counts
from .meaning import WITH_CONFIDENCE, confidence, ends, gain_db, settled
from .nexts import without_ends_at_the_next
from .noted import notes_on
from .row import EditedFile, Pair
from .shared import with_shared_windows

_OWN_ID = re.compile(r"shot-\d{1,18}\b")


@dataclass(frozen=True)
class Wish:
    """An event as it is wanted. `place` is where the edited file says so.

    `was` is the original event where there is one. `window` is to be kept as it is; where it is None, `start` and
    `stop` are ends set by hand, and one that is None is to be planned. `confidence` is None where nobody rated it.
    `onset_said` and `stop_said` are how the file says onset and end, for messages.
    """

    place: str
    id: str
    onset: int
    origin: Origin
    was: Event | None
    window: Window | None
    start: int | None
    stop: int | None
    confidence: float | None
    gain_db: float
    onset_said: str = ""
    stop_said: str = ""

    @property
    def unmoved(self) -> bool:
        """Return whether the event is an original one and where it was."""
        return self.was is not None and self.was.onset_sample == self.onset

    @property
    def changed(self) -> bool:
        """Return whether an unmoved event's window, gain or confidence is another."""
        was = self.was
        if was is None or not self.unmoved:
            return False
        ends = self.start is not None or self.stop is not None
        return ends or (self.gain_db, self.confidence) != (was.gain_db, was.confidence)


@dataclass(frozen=True)
class Wanted:
    """All events that are wanted, by onset, the originals that none of them was, and what a user has to know."""

    wishes: tuple[Wish, ...]
    deleted: tuple[Event, ...]
    notes: tuple[str, ...] = ()


def match(edited: EditedFile, originals: Mapping[str, Event] | None, *, rate_hz: int) -> Wanted:
    """Return what an edited file wants of a film at `rate_hz`; `originals` by id, None where they are not known.

    Raises TimelineError where two rows have one id or one onset, where two cells of a row contradict each other and
    nothing tells which was edited, where whole numbers count no samples, or where a window does not hold its onset.
    """
    known = edited.own if originals is None else originals
    pairs = list(_paired(edited, known, rate_hz))
    if edited.shows_ends:
        refuse_other_counts(edited, pairs, rate_hz=rate_hz)
        pairs = without_ends_at_the_next(pairs, known.values(), rate_hz=rate_hz)
    if originals is None:
        pairs = with_shared_windows(pairs, rate_hz=rate_hz)
        known = {**known, **{pair.was.id: pair.was for pair in pairs if pair.was is not None}}
    ids = ((pair.edit.place, pair.id, f"id = {pair.id!r}") for pair in pairs if pair.id is not None)
    _refuse_repeats(edited.path, ids)
    fresh = _free_ids({*known, *(pair.id for pair in pairs if pair.id is not None)})
    told = [originals is not None or (bool(known) and not pair.tells_its_past(rate_hz)) for pair in pairs]
    wishes = [
        _wish(edited, pair, next(fresh) if pair.id is None else pair.id, rate_hz, known=is_told)
        for pair, is_told in zip(pairs, told, strict=True)
    ]
    _refuse_repeats(edited.path, map(_said_onset, pairs, wishes))
    _refuse_rounded_repeats(edited.path, pairs, wishes, rate_hz)
    taken = {wish.was.id for wish in wishes if wish.was is not None}
    deleted = tuple(event for event in known.values() if event.id not in taken)
    kept = _with_whole_windows(wishes, known.values())
    notes = tuple(notes_on(edited, pairs, wishes))
    return Wanted(tuple(sorted(kept, key=lambda wish: wish.onset)), deleted, notes)


def _paired(edited: EditedFile, known: Mapping[str, Event], rate_hz: int) -> Iterator[Pair]:
    """Yield each row with its original: by id, and of those that have none or a new one by time.

    An event that somebody gave another id keeps it, and is the same event still.
    """
    ids = [edit.id or _id_in(edit.text, known) for edit in edited.edits]
    named = set(ids)
    free = {event.onset_sample: event for event in known.values() if event.id not in named}
    onsets = sorted(free)
    for edit, identity in zip(edited.edits, ids, strict=True):
        if identity is not None and identity in known:
            yield Pair(edit, known[identity], identity)
            continue
        place = edit.onset.nearest(rate_hz)
        after = bisect_left(onsets, place)
        near = [onset for onset in onsets[max(0, after - 1) : after + 1] if edit.onset.may_be(onset, rate_hz)]
        was = free.pop(min(near, key=lambda onset: abs(onset - place)), None) if near else None
        yield Pair(edit, was, was.id if was is not None and identity is None else identity)


def _id_in(text: str, known: Mapping[str, Event]) -> str | None:
    """Return the id with which a label begins: one that is known, or one as this program writes them."""
    if text in known:
        return text
    parts = text.split(" ")
    for count in range(len(parts) - 1, 0, -1):
        if (start := " ".join(parts[:count])) in known:
            return start
    said = _OWN_ID.match(text) or WITH_CONFIDENCE.fullmatch(text)
    return said[0].split(" ")[0] if said else None


def _free_ids(taken: Iterable[str]) -> Iterator[str]:
    """Yield ids that follow the highest that is taken."""
    numbers = [int(name.removeprefix("shot-")) for name in taken if _OWN_ID.fullmatch(name)]
    number = max(numbers, default=0)
    while True:
        number += 1
        yield f"shot-{number:04d}"


def _refuse_repeats(path: Path, values: Iterable[tuple[str, object, str]]) -> None:
    """Raise TimelineError where two rows have one value; values come with their place, and how the row says them."""
    first: dict[object, str] = {}
    for place, value, said in values:
        if value in first:
            raise TimelineError(f"{path}: {place}: {said}: {first[value]} has it too; expected each once")
        first[value] = place


def _said_onset(pair: Pair, wish: Wish) -> tuple[str, object, str]:
    """Return where a row is, the sample that it is on, and its time as the row has it."""
    onset, said = pair.edit.onset, f"onset_sample = {wish.onset}"
    if onset.sample is None and onset.seconds is not None:
        said = f"{onset.said[-1]}, sample {wish.onset}"
    return wish.place, wish.onset, said


def _refuse_rounded_repeats(path: Path, pairs: Iterable[Pair], wishes: Iterable[Wish], rate_hz: int) -> None:
    """Raise TimelineError for a row that is no original, but as far as its digits tell at the onset of another."""
    by_onset = sorted(zip(pairs, wishes, strict=True), key=lambda row: row[1].onset)
    for before, after in pairwise(by_onset):
        for (pair, wish), (_, other) in ((before, after), (after, before)):
            if wish.was is None and pair.edit.onset.may_be(other.onset, rate_hz):
                said = f"onset_s = {float(pair.edit.onset.exact_s(rate_hz)):.9g}"
                raise TimelineError(
                    f"{path}: {wish.place}: {said}: {other.place} has it too, at {other.onset / rate_hz:.9g} s; "
                    "expected each once"
                )


def _wish(edited: EditedFile, pair: Pair, identity: str, rate_hz: int, *, known: bool) -> Wish:
    edit, was = pair.edit, pair.was
    before = was.onset_sample if was else edit.blast_start
    onset = settled(edited, edit, "onset", edit.onset, before, rate_hz)
    moved = was is not None and was.onset_sample != onset
    if was is None and edit.blast_start is not None:
        moved = edit.blast_start != onset
    start, stop = ends(edited, edit, was, onset, moved=moved, rate_hz=rate_hz)
    return Wish(
        edit.place,
        identity,
        onset,
        _origin(pair, moved=moved, known=known),
        was,
        window=None,
        start=start,
        stop=stop,
        confidence=confidence(edited, edit, was),
        gain_db=gain_db(edited, edit, was, pair.id or ""),
        onset_said=edit.onset.said_as(onset),
        stop_said="" if edit.window_stop is None or stop is None else edit.window_stop.said_as(stop),
    )


def _origin(pair: Pair, *, moved: bool, known: bool) -> Origin:
    """Return where an event comes from; `known` says that its original would be.

    What was none of them is new, whatever its row says: a copied row still says "found".
    """
    edit, was = pair.edit, pair.was
    if was is None and known:
        return "added"
    said = edit.origin if was is None else was.origin
    if said is None:
        exported = edit.confidence is not None or WITH_CONFIDENCE.match(edit.text) or _OWN_ID.match(edit.text)
        said = "found" if exported and pair.id is not None else "added"
    return "moved" if moved and said == "found" else said


def _with_whole_windows(wishes: Iterable[Wish], originals: Iterable[Event]) -> Iterator[Wish]:
    """Yield the wishes, each with its original window where nobody has touched any event of it.

    One that has become too short for its fades keeps its ends alone. Shots that follow closely share a window. Where
    one of them is gone, it must not go on in the window of the others; where somebody has put another with an end of
    its own between them, that end is one of theirs.
    """
    listed = list(wishes)
    untouched = {
        wish.was.id
        for wish in listed
        if wish.was is not None and wish.unmoved and wish.start is None and wish.stop is None
    }
    mates: dict[Window, set[str]] = {}
    for event in originals:
        mates.setdefault(event.window, set()).add(event.id)
    added = sorted(wish.onset for wish in listed if wish.was is None and wish.stop is not None)
    for wish in listed:
        if wish.was is None or not wish.unmoved or _has_any_of(wish.was.window, added):
            yield wish
        elif mates[wish.was.window] <= untouched and wish.was.window.fits_fades:
            yield replace(wish, window=wish.was.window)
        elif len(mates[wish.was.window]) == 1:
            own = wish.was.window  # the end that was not touched stays
            yield replace(
                wish,
                start=own.start if wish.start is None else wish.start,
                stop=own.stop if wish.stop is None else wish.stop,
            )
        else:
            yield wish


def _has_any_of(window: Window, onsets: Sequence[int]) -> bool:
    """Return whether any of some ascending onsets is inside a window."""
    return bisect_left(onsets, window.start) < bisect_left(onsets, window.stop)

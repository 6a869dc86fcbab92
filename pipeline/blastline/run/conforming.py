"""A timeline for a new cut of its film: listen to both, find what of the old is where in the new, move the events.

old film ─► fingerprint ┐
new film ─► fingerprint ┴► segments ─► each event's place ─► windows planned anew ─► timeline, tables
"""

from collections.abc import Collection, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from .. import __version__
from ..conform import (
    Course,
    Film,
    Lost,
    Placed,
    find_courses,
    hear,
    moment,
    new_timecode,
    place,
    retimed,
    write_events,
    write_stretches,
)
from ..detect import group_bursts
from ..errors import OutputError, SoundtrackError
from ..export import read_timeline
from ..model import Event, Rejection, Timeline, encode
from ..progress import Progress, no_progress, report_progress
from ..ruleset import ConformRules, Rules, WindowRules, load_conform, load_rules
from ..soundtrack import Soundtrack, open_soundtrack
from ..staging import staged
from ..streams import Streams
from ..timebase import AS_FILMED, Timebase
from ..units import samples_from_s
from . import names
from .belonging import require_same_film
from .conforming_events import as_played, begun_by_hand, moved_events
from .export_rows import files_of_results
from .listening import BLOCK

_SHORTEST_S = 1.0


@dataclass(frozen=True)
class Conformed:
    """The new timeline, and how it came to be: the old events with where each went, and the segments."""

    timeline: Timeline
    events: tuple[Event, ...]
    places: tuple[Placed | Lost, ...]
    courses: tuple[Course, ...]

    @property
    def placed(self) -> tuple[Placed, ...]:
        """Return where the events went that were placed."""
        return tuple(place for place in self.places if isinstance(place, Placed))

    @property
    def lost(self) -> tuple[tuple[Event, Lost, str], ...]:
        """Return the events that were not placed, each with why and the new film's timecode at which it is missing."""
        pairs = zip(self.events, self.places, strict=True)
        source = self.timeline.source
        return tuple((event, place, new_timecode(place, source)) for event, place in pairs if isinstance(place, Lost))


def conform(
    timeline: Path,
    folder: Path,
    *,
    old: Path,
    new: Path,
    mix: str | None = None,
    stream: Streams | None = None,
    timebase: Timebase = AS_FILMED,
    rules: Path | None = None,
    overwrite: bool = False,
    progress: Progress = no_progress,
) -> Conformed:
    """Re-time a timeline from the film that it was made from to a new cut and write the result to `folder`.

    The timeline is given as its file or as its result's folder. `mix`, `stream` and `timebase` are the new film's;
    without a mix it is the timeline's. Raises BlastlineError for a timeline, film or folder that cannot be used;
    nothing is written then.
    """
    timeline = names.timeline_of(timeline)
    read = read_timeline(timeline)
    known, hearing = load_rules(read.quality, rules), load_conform(rules)
    if (folder / names.TIMELINE).exists() and (folder / names.TIMELINE).samefile(timeline):
        raise OutputError(f"{folder / names.TIMELINE}: is the old timeline; choose another folder for the new one")
    with (
        _place(folder, timeline, films=[old, new], overwrite=overwrite) as hidden,
        open_soundtrack(old, stream=read.source.stream, mix=read.source.mix, spool_folder=hidden) as old_track,
        open_soundtrack(
            new, stream=stream, mix=mix or read.source.mix, spool_folder=hidden, timebase=timebase
        ) as new_track,
    ):
        beside = any(event.heard_in == "sides" for event in read.events)
        before = _heard(old_track, old, "old film", progress, kept_sides=beside)
        require_same_film(old, old_track.source(), timeline, read.source)
        after = _heard(new_track, new, "new film", progress, kept_sides=beside)
        done = _conformed(read, before, after, (old_track, new_track), known, hearing, progress)
        if not done.courses:
            several = max(old_track.channels, new_track.channels) > 1
            advice = " (where its channels cancel in the mix, --mix 0 hears the first alone)" if several else ""
            raise SoundtrackError(f"{new}: nothing of {old} was found in it; expected a cut of the same film{advice}")
        (hidden / names.TIMELINE).write_bytes(encode(done.timeline))
        write_events(hidden / names.EVENTS, done.events, done.places, source=done.timeline.source)
        write_stretches(hidden / names.STRETCHES, done.courses)
    return done


def _place(folder: Path, timeline: Path, *, films: Collection[Path], overwrite: bool) -> AbstractContextManager[Path]:
    """Return the place for the results, beside which no drive stays: the new timeline has none, so it is another's."""
    files, stale = [names.TIMELINE, *names.TABLES], files_of_results()
    return staged(
        folder, names=files, stale=stale, films=films, spared=[timeline], seal=names.TIMELINE, overwrite=overwrite
    )


def _heard(track: Soundtrack, path: Path, stage: str, progress: Progress, *, kept_sides: bool) -> Film:
    """Decode a film once. Raises SoundtrackError where there is too little to recognise it by."""
    blocks = track.blocks(BLOCK, sides=True, kept_sides=kept_sides)
    film = hear(track, report_progress(blocks, progress, track.expected_frames, stage=stage))
    if film.duration_s < _SHORTEST_S:
        raise SoundtrackError(f"{path}: lasts {film.duration_s:.3f} s; expected at least {_SHORTEST_S:g} s of film")
    if not film.fingerprint.frames.any():
        raise SoundtrackError(f"{path}: is silent from beginning to end; there is nothing to find it by")
    return film


def _conformed(
    timeline: Timeline,
    old: Film,
    new: Film,
    tracks: tuple[Soundtrack, Soundtrack],
    rules: Rules,
    hearing: ConformRules,
    progress: Progress,
) -> Conformed:
    """Return the timeline of the new film; `tracks` are the old film's and the new one's."""

    def tell(done: int, total: int) -> None:
        progress("matching", done, total)

    courses = find_courses(old, new, tell)
    progress("placing", 0, None)
    events = tuple(sorted(timeline.events, key=lambda event: event.onset_sample))
    onsets_s = [event.onset_sample / old.rate_hz for event in events]
    places = place(onsets_s, courses, old, new, hearing, mixes=[event.heard_in for event in events])
    shots = [
        (event, retimed(event, each, courses, old, new))
        for event, each in zip(events, places, strict=True)
        if isinstance(each, Placed)
    ]
    shots.sort(key=lambda pair: pair[1].shot.onset)
    source = tracks[1].source()
    shots = as_played(shots, tracks, (timeline.source, source), alike=_are_alike(*tracks), tier=rules.tier)
    bursts = group_bursts([each.shot for _, each in shots], rate_hz=new.rate_hz, rules=rules.tier.bursts)
    shots = [(event, replace(each, shot=shot)) for (event, each), shot in zip(shots, bursts, strict=True)]
    rejections = (*_rejections(timeline, courses, old, new), *_missing(events, places, new))
    made = msgspec.structs.replace(
        timeline,
        version=__version__,
        rules_digest=rules.digest,
        source=source,
        actuator=None,
        events=moved_events(shots, begun_by_hand(events, old.rate_hz, _plans(rules)), source, rules),
        rejections=tuple(sorted(rejections, key=lambda each: each.at_sample)),
        checks=(),
        edits=None,
        budget=None,
    )
    return Conformed(made, events, tuple(places), tuple(courses))


def _plans(rules: Rules) -> list[WindowRules]:
    """Return the rules that may have planned the old windows: those given, and the built-in ones."""
    if rules.overlay is None:
        return [rules.tier.windows]
    return [rules.tier.windows, load_rules(rules.quality).tier.windows]


def _are_alike(one: Soundtrack, other: Soundtrack) -> bool:
    """Return whether the channels of two films play from the same places."""
    here, there = one.channels_in_space, other.channels_in_space
    return here is not None and there is not None and here.azimuths_deg == there.azimuths_deg


def _rejections(timeline: Timeline, courses: Sequence[Course], old: Film, new: Film) -> Iterator[Rejection]:
    """Yield what the old film's timeline turned down, where the new film has its moment."""
    for each in timeline.rejections:
        new_s = moment(each.at_sample / old.rate_hz, courses, within_s=0.5 / old.rate_hz)
        if new_s is not None and -0.5 / new.rate_hz <= new_s < new.duration_s:
            at = min(max(0, samples_from_s(new_s, new.rate_hz)), new.frames - 1)
            yield msgspec.structs.replace(each, at_sample=at)


def _missing(events: Sequence[Event], places: Sequence[Placed | Lost], new: Film) -> Iterator[Rejection]:
    """Yield each event that was not placed, at the moment of the new film at which it is missing."""
    for event, each in zip(events, places, strict=True):
        if isinstance(each, Lost):
            at = min(max(0, samples_from_s(each.near_s, new.rate_hz)), new.frames - 1)
            evidence = {"old_onset_s": event.onset_s, "likeness": each.likeness}
            yield Rejection(at, f"{event.id}: {each.reason.value}", evidence)

"""A film with the shots that somebody has edited: detection is skipped, what was not touched is kept.

edited file, original timeline ──► what is wanted ──► measured in the film where it is new ──► windows
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec

from ..detect import (
    Detection,
    audio_around,
    drop_claimed_reflections,
    group_bursts,
    shot_at,
    shot_in_clearer_mix,
    side_as_main,
    with_azimuths,
)
from ..errors import TimelineError
from ..export import read_timeline
from ..export.edits import EditedFile, Wanted, Wish, match, read_edits
from ..model import Decision, Edits, Event, Rejection, Shot, Source
from ..progress import Progress, report_progress
from ..render import is_lacking, plan_windows, with_gains
from ..report import OverviewMeter
from ..ruleset import QualityRules, Rules
from ..soundtrack import Soundtrack, heard_mix, open_soundtrack
from ..streams import Streams, streams_text
from ..timebase import Timebase, recalled
from ..units import ms_from_samples, samples_from_ms
from . import names
from .edit_settings import other_settings, settings_of
from .edit_summary import summarise_edits, unused_settings
from .editing_windows import DELETED, settled_windows
from .listening import BLOCK, HeardFilm, Mark
from .options import Setup

_MEND = "re-time the timeline with `blastline conform`, or give the film that it is of"
_SURE = 1.0  # who sets an event by hand has no doubt
_REGAINED_MS = 25.0  # a rejection so near to an added event is that event


@dataclass(frozen=True)
class Editing:
    """An edited file and what is known of the timeline that it was exported from.

    `original` is None where that is not known; `named_by` is the file that names the film, None where none does.
    `made_with` is what that says of the options of its run.
    """

    edited: EditedFile
    original: Mapping[str, Event] | None
    rejections: tuple[Rejection, ...]
    source: Source | None
    named_by: Path | None
    made_with: Mapping[str, Any]


def read_editing(path: Path, *, original: Path | None) -> Editing:
    """Return an edited file with its original timeline: the one that is given, else `timeline.json` beside the file.

    An edited JSON without an original tells by itself where its events were; so it does where it is said to be its own
    original, beside which nothing would differ. Raises TimelineError for a file that cannot be used.
    """
    edited = read_edits(path)
    if original is not None and original.exists() and original.samefile(path):
        original = None
        edited = replace(edited, notes=(*edited.notes, "not used: --original, which is the edited file itself"))
    beside = path.parent / names.TIMELINE
    if original is None and beside.is_file() and not beside.samefile(path):
        original = beside
    if original is None:
        named_by = path if edited.source else None
        return Editing(edited, None, edited.rejections, edited.source, named_by, edited.made_with)
    timeline = read_timeline(original)
    if edited.source is not None and edited.source.sha256 != timeline.source.sha256:
        raise TimelineError(
            f"{path}: is of {_named(edited.source)}, but its original {original} of {_named(timeline.source)}; "
            "give its own with --original"
        )
    edited = replace(edited, notes=(*edited.notes, *unused_settings(edited, timeline)))
    events = {event.id: event for event in timeline.events}
    return Editing(edited, events, timeline.rejections, timeline.source, original, settings_of(timeline))


def with_other_settings(editing: Editing, setup: Setup) -> Editing:
    """Return an edited file with a note on the options of this run that its timeline was not made with, if any."""
    others = ", ".join(other_settings(editing.made_with, setup))
    if not others:
        return editing
    note = f"other options than the {'timeline' if editing.original is None else 'original'} was made with: {others}"
    return replace(editing, edited=replace(editing.edited, notes=(*editing.edited.notes, note)))


def timebase_of(film: Path, editing: Editing, *, said: Timebase, stream: Streams | None, mix: str) -> Timebase:
    """Return the time base of a film that is rendered again: what was said of it first holds until said anew."""
    earlier = editing.source
    if earlier is None:
        return said
    with open_soundtrack(film, stream=stream, mix=mix) as track:
        return recalled(said, earlier, track.describe())


def hear_edited(
    track: Soundtrack, rules: Rules, editing: Editing, *, progress: Progress, meter: OverviewMeter | None
) -> tuple[HeardFilm, Edits]:
    """Decode the film once and return the shots that an edited file wants of it, and how many were edited in which way.

    Raises TimelineError where the film is not the one that the timeline is of, or ends before an event.
    """
    edited, path = editing.edited, editing.edited.path
    if editing.source and editing.source.sample_rate_hz != track.rate_hz:
        raise TimelineError(
            f"{editing.named_by}: is of {_named(editing.source)}, but the film has {track.rate_hz} Hz; {_MEND}"
        )
    wanted = match(edited, editing.original, rate_hz=track.rate_hz)
    blocks = report_progress(track.blocks(BLOCK, kept_sides=True), progress, track.expected_frames)
    for _ in meter.watch(blocks) if meter else blocks:
        pass
    source = track.source()
    _require_same_film(editing, source)
    wanted = replace(wanted, wishes=tuple(_inside(wish, source, path) for wish in wanted.wishes))
    wishes = wanted.wishes
    shots = _shots(wishes, track, source, rules)
    windows = plan_windows(
        shots,
        frames=source.frames,
        rate_hz=source.sample_rate_hz,
        rules=rules.tier.windows,
        given=settled_windows(wanted, shots, source, rules, rejections=editing.rejections),
    )
    found = Detection(shots, _rejections(editing, wanted, source.sample_rate_hz))
    marks = tuple(Mark(wish.id, wish.origin, wish.gain_db, _decided(wish)) for wish in wishes)
    windows = with_gains(windows, shots, [wish.gain_db for wish in wishes])
    return HeardFilm(track, source, found, windows, marks), summarise_edits(
        edited,
        wanted,
        windows,
        source,
        has_original=editing.original is not None,
        is_named=editing.named_by is not None,
    )


def _named(source: Source) -> str:
    return f"{source.name} (sha256 {source.sha256[:12]}, {source.frames} frames at {source.sample_rate_hz} Hz)"


def _require_same_film(editing: Editing, found: Source) -> None:
    expected = editing.source
    if expected is None:
        return
    if found.sha256 == expected.sha256 and found.stream != expected.stream:
        raise TimelineError(
            f"{editing.named_by}: is of sound stream {streams_text(expected.stream)} of {expected.name}, "
            f"not {streams_text(found.stream)}; give --stream {streams_text(expected.stream)}"
        )
    if found.sha256 == expected.sha256 and heard_mix(found.mix) != heard_mix(expected.mix):
        raise TimelineError(
            f"{editing.named_by}: its shots were heard in the mix {expected.mix}, not {found.mix}; "
            f"give --mix {expected.mix}"
        )
    if (found.sha256, found.frames) != (expected.sha256, expected.frames):
        raise TimelineError(f"{editing.named_by}: is of {_named(expected)}, but the film is {_named(found)}; {_MEND}")


def _inside(wish: Wish, source: Source, path: Path) -> Wish:
    """Return a wish inside the film; an end that a tool has rounded to just past the film's is the film's."""
    frames, rate_hz = source.frames, source.sample_rate_hz
    length = f"{frames} frames, {frames / rate_hz:.6g} s"
    if wish.onset >= frames:
        raise TimelineError(
            f"{path}: {wish.place}: {wish.onset_said}: expected a time in the film, which has {length}; "
            f"its last sample is {frames - 1}, at {(frames - 1) / rate_hz:.9g} s"
        )
    start, stop = (wish.start, wish.stop) if wish.window is None else (wish.window.start, wish.window.stop)
    if stop is None or stop <= frames:
        return wish
    if ms_from_samples(stop - frames, rate_hz) >= 1.0:
        raise TimelineError(
            f"{path}: {wish.place}: {wish.stop_said or f'window ends at sample {stop}'}: expected a time in the film, "
            f"which has {length}"
        )
    return replace(wish, window=None, start=start, stop=frames)


def _shots(wishes: Sequence[Wish], track: Soundtrack, source: Source, rules: Rules) -> tuple[Shot, ...]:
    """Return each wish as a shot: as its mix sounds in the film, or as it was where it was not moved."""
    tier, rate_hz = rules.tier, source.sample_rate_hz
    heard = [_heard(wish, track, source, rules.tier) for wish in wishes]
    toward = with_azimuths(heard, track.channels_in_space, rate_hz=rate_hz, rules=tier.channels)
    parted = drop_claimed_reflections(toward, rate_hz=rate_hz, rules=tier.bursts)
    kept = [
        _as_it_was(shot, wish.was) if wish.unmoved and wish.was is not None else shot
        for wish, shot in zip(wishes, parted, strict=True)
    ]
    return group_bursts(kept, rate_hz=rate_hz, rules=tier.bursts)


def _heard(wish: Wish, track: Soundtrack, source: Source, tier: QualityRules) -> Shot:
    """Return a wish as a shot of the mix in which it is heard.

    That is its own mix, where it was not moved. What is moved from the sides is heard where it stands out more, all
    else in the mains, or in the sides where two channels cancel in those.
    """
    span = audio_around(wish.onset, frames=source.frames, rate_hz=source.sample_rate_hz, tier=tier)
    clip = track.read(span, sides=True)
    confidence = _SURE if wish.confidence is None else wish.confidence
    if wish.was is not None and wish.unmoved:
        mix = wish.was.heard_in
    elif wish.was is not None and wish.was.heard_in == "sides":
        return shot_in_clearer_mix(wish.onset, clip, confidence=confidence, tier=tier)
    else:
        mix = "sides" if is_lacking(clip, wish.onset) else "mains"
    shot = shot_at(wish.onset, side_as_main(clip) if mix == "sides" else clip, confidence=confidence, tier=tier)
    return msgspec.structs.replace(shot, heard_in=mix)


def _decided(wish: Wish) -> tuple[Decision, ...]:
    """Return how closely an event was looked at, where nobody has moved it since."""
    return wish.was.decisions if wish.unmoved and wish.was is not None else ()


def _as_it_was(shot: Shot, was: Event) -> Shot:
    return msgspec.structs.replace(
        shot,
        peak_dbfs=was.peak_dbfs,
        snr_db=was.snr_db,
        blast=was.blast,
        reflections=was.reflections,
        azimuth_deg=was.azimuth_deg,
        azimuth_focus=was.azimuth_focus,
    )


def _rejections(editing: Editing, wanted: Wanted, rate_hz: int) -> tuple[Rejection, ...]:
    """Return the original's rejections without those where an event was put, and with the events that were deleted."""
    near = samples_from_ms(_REGAINED_MS, rate_hz)
    placed_anew = [wish.onset for wish in wanted.wishes if not wish.unmoved]
    still = [r for r in editing.rejections if all(abs(r.at_sample - onset) > near for onset in placed_anew)]
    deleted = [Rejection(e.onset_sample, DELETED, {"probability": e.confidence}) for e in wanted.deleted]
    return tuple(sorted([*still, *deleted], key=lambda r: r.at_sample))

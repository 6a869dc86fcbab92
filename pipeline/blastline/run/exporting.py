"""Writing a timeline in other formats."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from ..errors import TimelineError
from ..export import (
    HAPTIC_FORMATS,
    HapticTrack,
    export_timeline,
    known_formats,
    needs_drive,
    read_timeline,
    require_frame_rate,
    rounding,
)
from ..model import Timeline
from ..progress import Note, no_note
from ..ruleset import load_haptics
from ..staging import staged
from ..timebase import AS_FILMED, Timebase, retimed
from . import names
from .belonging import film_of, profile_of, require_unchanged
from .driving import open_drive
from .export_rows import files_of_results
from .haptics import decode_drive, rounding_notes, tell_silent, track_of


def export(
    timeline: Path,
    folder: Path,
    *,
    formats: Iterable[str],
    timebase: Timebase = AS_FILMED,
    drive: Path | None = None,
    actuator: str | None = None,
    rules: Path | None = None,
    overwrite: bool = False,
    note: Note = no_note,
) -> list[Path]:
    """Write a timeline, given as its file or its result's folder, in other formats into `folder`; return the files.

    `timebase` is what the user says about the film's timecode. The haptic formats are made from the drive, looked for
    beside the timeline. `note` is told what had to be rounded.
    Raises BlastlineError for a timeline, drive, format, time base or folder it cannot use, and writes nothing then.
    """
    chosen = [known.name for known in known_formats(formats)]
    timeline = names.timeline_of(timeline)
    as_written = read_timeline(timeline)
    read = retimed(as_written, timebase)
    require_frame_rate(chosen, read.source)
    files = [file for known in known_formats(chosen) for file in known.files]
    sets = [pattern for known in known_formats(chosen) for pattern in known.sets]
    with staged(
        folder,
        names=files,
        sets=sets,
        stale=(*files_of_results(), *names.TABLES) if _replaces_another_films(read, folder, files) else (),
        spared=[path for path in (timeline, drive) if path is not None],
        seal=names.TIMELINE,
        overwrite=overwrite,
    ) as hidden:
        track = None
        if needs_drive(chosen):
            track = _haptic_track(read, timeline, drive=drive, actuator=actuator, rules=rules, note=note)
            require_unchanged(timeline, as_written)
        written = export_timeline(read, hidden, formats=chosen, track=track, rounding=rounding_notes(note))
    unused = () if needs_drive(chosen) else _unused(drive=drive, actuator=actuator)
    for line in (*unused, *rounding(read, chosen)):
        note(line)
    return [folder / file.name for file in written]


def _unused(*, drive: Path | None, actuator: str | None) -> Iterator[str]:
    """Yield a line where something was given that only formats which are made from the drive have a use for."""
    given = [name for name, value in (("--drive", drive), ("--actuator", actuator)) if value is not None]
    if given:
        yield f"not used: {' and '.join(given)}; only {', '.join(HAPTIC_FORMATS)} are made from the drive"


def _replaces_another_films(timeline: Timeline, folder: Path, files: Iterable[str]) -> bool:
    """Return whether one of the files to be written takes the place of the timeline of another film.

    The drive beside it would then be taken for that of the new one. A timeline that cannot be read tells of no film.
    """
    if names.TIMELINE not in files:
        return False
    return film_of(folder / names.TIMELINE) not in (None, timeline.source.sha256)


def _haptic_track(
    timeline: Timeline, path: Path, *, drive: Path | None, actuator: str | None, rules: Path | None, note: Note
) -> HapticTrack:
    """Return what the haptic formats are written from; `path` is the timeline's file, beside which its drive lies."""
    if actuator is None and timeline.actuator is None and drive is None:
        raise TimelineError(
            f"{path}: has no drive and names no actuator; haptic formats are made from a drive: `blastline render` "
            "makes one, or give --drive and --actuator"
        )
    profile = profile_of(timeline, path, actuator=actuator, rules=rules, note=note)
    file = drive or path.parent / names.DRIVE
    if drive is None and not file.is_file():
        raise TimelineError(f"{file}: no such file; haptic formats are made from the drive: give it with --drive")
    with open_drive(file) as made:
        decode_drive(timeline, made, file, note)
        track = track_of(timeline, made, profile=profile, rules=load_haptics(rules))
    if timeline.events and not track.segments:
        count = len(timeline.events)
        raise TimelineError(f"{file}: is at rest in the windows of all {count} shots: not the drive of this timeline")
    tell_silent(track, note)
    return track

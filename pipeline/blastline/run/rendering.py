"""The main job: a film in, an aligned drive, its timeline and its report out.

listen -> choose a model for each window -> render -> write -> check what was written -> other formats -> report
"""

from collections.abc import Collection, Iterable
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path

import msgspec

from ..export import export_timeline, known_formats, needs_drive, require_frame_rate, require_late_enough, rounding
from ..model import DriveInfo, Edits, Timeline
from ..progress import Note, Progress, no_note, no_progress
from ..report import OverviewMeter, typeset, write_report
from ..soundtrack import Soundtrack, open_soundtrack
from ..staging import Files, require_free, require_utf_8, staged
from ..timecode import late_stamp
from . import names
from .belonging import film_of
from .checking import checked, markers_of
from .driving import open_drive, write_drive_of
from .editing import Editing, hear_edited, read_editing, timebase_of, with_other_settings
from .export_rows import export_rows, files_of_results
from .haptics import rounding_notes, tell_silent, track_of
from .listening import HeardFilm, assemble, listen
from .options import RenderOptions, Setup, require_seat, set_up, with_files


def render(
    film: Path, folder: Path, options: RenderOptions, progress: Progress = no_progress, note: Note = no_note
) -> Timeline:
    """Find the shots of a film and write drive, timeline and report to `folder`; return the timeline with its checks.

    With `options.timeline`, an edited timeline or its result's folder, its events are rendered instead of what would be
    found. `note` is told what the timeline's formats had to round.
    Raises BlastlineError for input, rules or an output folder that cannot be used; nothing is written then.
    """
    options = with_files(options)
    setup = set_up(options, progress)
    stale = _stale(options)
    place = _place(film, folder, options, stale)
    timebase, editing = options.timebase, None
    if options.timeline is not None:
        editing = with_other_settings(read_editing(options.timeline, original=options.original), setup)
        timebase = timebase_of(film, editing, said=timebase, stream=options.stream, mix=options.mix)
    with (
        place as hidden,
        open_soundtrack(film, stream=options.stream, mix=options.mix, spool_folder=hidden, timebase=timebase) as track,
    ):
        require_frame_rate(options.formats, track.describe(frames=track.expected_frames or 0))
        require_late_enough(options.formats, track.describe())
        require_seat(setup.options.actuator, setup.profile, track.rate_hz)
        meter = OverviewMeter(track.rate_hz) if options.report else None
        timeline = _driven(track, hidden, setup, editing, meter)
        with open_drive(hidden / names.DRIVE) as drive:
            profile, rules, markers = setup.profile, setup.rules, markers_of(hidden / names.DRIVE)
            timeline = checked(timeline, track, drive, profile=profile, rules=rules, progress=progress, markers=markers)
            written = write_formats(timeline, hidden, drive, setup, note)
            if meter is not None:
                write_report_of(timeline, hidden, written, track=track, drive=drive, meter=meter, setup=setup)
        if timeline.edits is None or film_of(folder / names.TIMELINE) != timeline.source.sha256:
            stale += names.TABLES  # they tell of other shots
    for line in rounding(timeline, options.formats):
        note(line)
    return timeline


def require_place(film: Path, folder: Path, options: RenderOptions) -> None:
    """Raise OutputError or RuleError where `render` could not write what is asked for, before it listens."""
    require_utf_8(folder)
    require_free(folder, **_files(film, with_files(options), _stale(options)))


def _files(film: Path, options: RenderOptions, stale: Collection[str]) -> Files:
    formats = known_formats(options.formats)
    files = [file for each in formats for file in each.files]
    return Files(
        names=[names.DRIVE, *files, *([names.REPORT] * options.report)],
        sets=[pattern for each in formats for pattern in each.sets],
        stale=stale,
        films=[film],
        spared=[path for path in (options.timeline, options.original) if path is not None],
        overwrite=options.overwrite,
    )


def _stale(options: RenderOptions) -> list[str]:
    """Return what other runs may have left beside a result, but for the tables that may be of the same film.

    Those are, beside a timeline that may be replaced; without one, which timeline they were of nobody knows.
    """
    return [*files_of_results(), *(() if options.overwrite else names.TABLES)]


def _place(film: Path, folder: Path, options: RenderOptions, stale: Collection[str]) -> AbstractContextManager[Path]:
    """Return the place for the results, from which nothing `stale` stays where it may be overwritten.

    What is stale is looked up at the end, when it is known of which film the results are.
    """
    require_utf_8(folder)
    if options.timeline is not None:  # it will be named in the result
        require_utf_8(options.timeline, advice="rename the file")
    return staged(folder, seal=names.TIMELINE, **_files(film, options, stale))


def _driven(
    track: Soundtrack, folder: Path, setup: Setup, editing: Editing | None, meter: OverviewMeter | None
) -> Timeline:
    """Write the drive of a film and return its timeline, without checks."""
    heard, edits = _heard(track, setup, editing, meter)
    warned = msgspec.structs.replace(heard.source, warnings=(*heard.source.warnings, *late_stamp(heard.source)))
    heard = replace(heard, source=warned)
    timeline = driven_timeline(heard, write_drive_of(heard, folder / names.DRIVE, setup), setup)
    return msgspec.structs.replace(timeline, edits=edits, budget=setup.options.budget)


def driven_timeline(heard: HeardFilm, drives: dict[int, DriveInfo], setup: Setup) -> Timeline:
    """Return the timeline of a film whose drive was rendered as asked for, without checks."""
    return msgspec.structs.replace(
        assemble(heard, setup.rules, drives, setup.actuator),
        phase=setup.options.phase,
        background=setup.options.background,
        level_db=setup.rules.tier.render.level_db,
    )


def _heard(
    track: Soundtrack, setup: Setup, editing: Editing | None, meter: OverviewMeter | None
) -> tuple[HeardFilm, Edits | None]:
    """Return the film with its shots, found or named by an edited timeline, and what was edited."""
    if editing is None:
        return listen(track, setup.rules, setup.progress, meter), None
    return hear_edited(track, setup.rules, editing, progress=setup.progress, meter=meter)


def write_formats(timeline: Timeline, folder: Path, drive: Soundtrack, setup: Setup, note: Note) -> list[Path]:
    """Write the formats that were asked for and return their files."""
    haptic, formats = None, setup.options.formats
    if needs_drive(formats):
        haptic = track_of(timeline, drive, profile=setup.profile, rules=setup.haptics)
        tell_silent(haptic, note)
    return export_timeline(timeline, folder, formats=formats, track=haptic, rounding=rounding_notes(note))


def write_report_of(
    timeline: Timeline,
    folder: Path,
    written: Iterable[Path],
    *,
    track: Soundtrack,
    drive: Soundtrack,
    meter: OverviewMeter,
    setup: Setup,
) -> None:
    """Write the report of a result whose files have been written."""
    setup.progress("reporting", 0, None)
    options = setup.options
    write_report(
        folder / names.REPORT,
        timeline,
        overview=meter.overview(),
        audio=track,
        drive=drive,
        profile=setup.profile,
        exports=export_rows(written=[file.name for file in written]),
        options={
            "drive": options.drive,
            "phase": options.phase,
            "background": options.background,
            "level": typeset(f"{timeline.level_db:+g} dB"),
        },
    )

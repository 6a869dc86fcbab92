"""The main job: a film in, an aligned drive, its timeline and its report out.

listen -> choose a model for each window -> render -> write -> check what was written -> report
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec

from .. import scene
from ..align import check_files
from ..errors import OutputError, RuleError
from ..export import export_timeline, known_formats, needs_drive, require_frame_rate, rounding
from ..model import ActuatorRef, Background, Clip, DriveChoice, DriveInfo, Edits, Phase, Quality, Span, Timeline
from ..render import RenderedWindow, compose, drive_filters, hear_window, measure, needed_audio, render_window
from ..report import OverviewMeter, write_report
from ..ruleset import ActuatorProfile, Rules, load_actuator, load_haptics, load_rules
from ..soundtrack import Cue, Soundtrack, open_soundtrack, write_drive
from ..staging import staged
from ..timebase import AS_FILMED, Timebase
from .editing import Editing, hear_edited, read_editing
from .exports import exports
from .haptics import rounding_notes, tell_silent, track_of
from .listening import BLOCK, Listened, assemble, listen
from .progress import Note, Progress, no_note, no_progress

DRIVE_NAME, REPORT_NAME = "drive.wav", "report.html"
LARGEST_LEVEL_DB = 40.0


@dataclass(frozen=True)
class RenderOptions:
    """What a user may ask of `render`, with what they get when they do not ask."""

    quality: Quality = "standard"
    actuator: str = "crowson-t108sm"
    rules: Path | None = None
    drive: DriveChoice = "auto"
    phase: Phase = "causal"
    background: Background = "mute"
    level_db: float | None = None
    mix: str = "mains"
    stream: int | None = None
    formats: tuple[str, ...] = ("json", "csv")
    timebase: Timebase = AS_FILMED
    report: bool = True
    overwrite: bool = False
    timeline: Path | None = None
    original: Path | None = None


@dataclass(frozen=True)
class Setup:
    """What a run was asked for, read and checked."""

    options: RenderOptions
    rules: Rules
    profile: ActuatorProfile
    actuator: ActuatorRef
    progress: Progress = field(repr=False)


def render(
    film: Path, folder: Path, options: RenderOptions, progress: Progress = no_progress, note: Note = no_note
) -> Timeline:
    """Find the shots of a film and write drive, timeline and report to `folder`; return the timeline with its checks.

    With `options.timeline`, an edited timeline, its events are rendered instead of what would be found. `note` is told
    what the timeline's formats had to round.
    Raises BlastlineError for input, rules or an output folder that cannot be used; nothing is written then.
    """
    profile, digest = load_actuator(options.actuator, options.rules)
    rules = _levelled(load_rules(options.quality, options.rules), options.level_db)
    haptics = load_haptics(options.rules)
    setup = Setup(options, rules, profile, ActuatorRef(profile.name, digest), progress)
    formats = known_formats(options.formats)
    files = [file for known in formats for file in known.files]
    names = [DRIVE_NAME, *files, *([REPORT_NAME] if options.report else [])]
    sets = [pattern for known in formats for pattern in known.sets]
    _refuse_to_replace(film, folder, names)
    if options.original is not None and options.timeline is None:
        raise RuleError(f"--original {options.original}: there is no edited timeline; give one with --timeline")
    editing = None if options.timeline is None else read_editing(options.timeline, original=options.original)
    with staged(folder, names=names, sets=sets, overwrite=options.overwrite) as hidden:
        with open_soundtrack(
            film, stream=options.stream, mix=options.mix, spool_folder=hidden, timebase=options.timebase
        ) as track:
            require_frame_rate(options.formats, track.described())
            meter = OverviewMeter(track.rate_hz) if options.report else None
            heard, edits = _heard(track, setup, editing, meter)
            drives = _write_drive(hidden / DRIVE_NAME, heard, setup)
            timeline = msgspec.structs.replace(
                assemble(heard, rules, drives, setup.actuator),
                phase=options.phase,
                background=options.background,
                level_db=rules.tier.render.level_db,
                edits=edits,
            )
            with open_soundtrack(hidden / DRIVE_NAME) as drive:
                timeline = checked(timeline, track, drive, setup)
                haptic = None
                if needs_drive(options.formats):
                    haptic = track_of(timeline, drive, profile=profile, rules=haptics)
                    tell_silent(haptic, note)
                if meter is not None:
                    setup.progress("reporting", 0, None)
                    write_report(
                        hidden / REPORT_NAME,
                        timeline,
                        overview=meter.overview(),
                        audio=track,
                        drive=drive,
                        profile=profile,
                        exports=exports(written=options.formats),
                        options={
                            "drive": options.drive,
                            "phase": options.phase,
                            "background": options.background,
                            "level": f"{timeline.level_db:+g} dB",
                        },
                    )
        export_timeline(timeline, hidden, formats=options.formats, track=haptic, rounding=rounding_notes(note))
    for line in rounding(timeline, options.formats):
        note(line)
    return timeline


def _levelled(rules: Rules, level_db: float | None) -> Rules:
    """Return the rules with the level that was asked for, if one was; RuleError where it is out of range."""
    if level_db is None:
        return rules
    if not abs(level_db) <= LARGEST_LEVEL_DB:
        raise RuleError(f"--level: {level_db:g} dB: expected -{LARGEST_LEVEL_DB:g} to {LARGEST_LEVEL_DB:g}")
    tier = rules.tier
    louder = msgspec.structs.replace(tier, render=msgspec.structs.replace(tier.render, level_db=level_db))
    return replace(rules, tier=louder)


def _heard(
    track: Soundtrack, setup: Setup, editing: Editing | None, meter: OverviewMeter | None
) -> tuple[Listened, Edits | None]:
    """Return the film with its shots, found or named by an edited timeline, and what was edited."""
    if editing is None:
        return listen(track, setup.rules, setup.progress, meter), None
    return hear_edited(track, setup.rules, editing, progress=setup.progress, meter=meter)


def _write_drive(path: Path, heard: Listened, setup: Setup) -> dict[int, DriveInfo]:
    """Render every window into the drive's file and return what was done for each shot, by its index."""
    drives: dict[int, DriveInfo] = {}

    def noted() -> Iterator[RenderedWindow]:
        for number, done in enumerate(_rendered(heard, setup), start=1):
            drives.update(zip(done.planned.shots, done.drives, strict=True))
            yield done
            setup.progress("rendering", number, len(heard.windows))

    source = heard.source
    film = _cuts(heard.track, source.frames) if setup.options.background == "direct" else ()
    cues = [Cue(shot.onset, mark.id, len(shot.span)) for shot, mark in zip(heard.found.shots, heard.marks, strict=True)]
    write_drive(
        path,
        compose(film, noted(), setup.options.background),
        rate_hz=source.sample_rate_hz,
        frames=source.frames,
        time_reference=heard.track.time_reference,
        cues=cues,
        description=f"vibration drive for {setup.profile.name}",
    )
    return drives


def _rendered(heard: Listened, setup: Setup) -> Iterator[RenderedWindow]:
    options, render_rules = setup.options, setup.rules.tier.render
    filters = drive_filters(setup.profile, heard.source.sample_rate_hz, options.phase)
    for planned in heard.windows:
        audio = heard.track.cut(needed_audio(planned, frames=heard.source.frames, filters=filters, rules=render_rules))
        window = hear_window(audio, planned, filters=filters, rules=render_rules)
        model, reason = scene.choose(measure(window), setup.rules.scenes, options.drive)
        yield render_window(window, heard.found.shots, model=model, reason=reason, background=options.background)


def _cuts(track: Soundtrack, frames: int) -> Iterator[Clip]:
    """Read the film once more, exactly."""
    for start in range(0, frames, BLOCK):
        yield track.cut(Span(start, min(start + BLOCK, frames)))


def checked(timeline: Timeline, track: Soundtrack, drive: Soundtrack, setup: Setup) -> Timeline:
    """Return the timeline with the checks of the files: `track` has been decoded, `drive` has just been opened."""
    setup.progress("checking", 0, None)
    checks = check_files(
        timeline,
        audio=track,
        drive=drive,
        profile=setup.profile,
        rules=setup.rules.align,
        phase=setup.options.phase,
        background=setup.options.background,
    )
    return msgspec.structs.replace(timeline, checks=checks)


def _refuse_to_replace(film: Path, folder: Path, names: Iterable[str]) -> None:
    for name in names:
        if (folder / name).exists() and film.exists() and (folder / name).samefile(film):
            raise OutputError(f"{folder / name}: is the film itself; choose another folder for the results")

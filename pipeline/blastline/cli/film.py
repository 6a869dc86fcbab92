"""`render`, `detect`, `check` and `export`."""

from pathlib import Path
from typing import Annotated

import typer

from ..model import Timeline, encode
from ..timebase import parse_timebase
from .options import (
    DRIVING,
    WRITING,
    ActuatorOption,
    BackgroundOption,
    DriveOption,
    EditedTimeline,
    Film,
    Formats,
    FrameRate,
    LevelOption,
    MadeFor,
    Mix,
    OriginalTimeline,
    Overwrite,
    PhaseOption,
    QualityOption,
    Quiet,
    ReportOption,
    ResultFolder,
    RulesOption,
    StartTimecode,
    Stream,
    listed,
)
from .progress import shown_progress
from .summary import say_checks, say_summary

FAILED_CHECK = 1


def render(
    film: Film,
    folder: ResultFolder,
    quality: QualityOption = "standard",
    rules: RulesOption = None,
    mix: Mix = "mains",
    stream: Stream = None,
    timeline: EditedTimeline = None,
    original: OriginalTimeline = None,
    actuator: ActuatorOption = "crowson-t108sm",
    drive: DriveOption = "auto",
    phase: PhaseOption = "causal",
    background: BackgroundOption = "mute",
    level_db: LevelOption = None,
    start_timecode: StartTimecode = None,
    frame_rate: FrameRate = None,
    formats: Formats = "json,csv",
    report: ReportOption = True,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
) -> int:
    """Find a film's gunshots and write a vibration drive for them, with a timeline and a report.

    Example: `blastline render film.mkv -o result`
    """
    from .. import run

    options = run.RenderOptions(
        quality=quality,
        actuator=actuator,
        rules=rules,
        drive=drive,
        phase=phase,
        background=background,
        level_db=level_db,
        mix=mix,
        stream=stream,
        timebase=parse_timebase(start_timecode, frame_rate),
        formats=listed(formats),
        report=report,
        overwrite=overwrite,
        timeline=timeline,
        original=original,
    )
    notes: list[str] = []
    with shown_progress(quiet=quiet) as progress:
        made = run.render(film, folder, options, progress, notes.append)
    if not quiet:
        for note in notes:
            typer.echo(note, err=True)
        say_summary(made, folder / "report.html" if report else folder)
    say_checks(made, quiet=quiet, err=True)
    return _code(made)


def detect(
    film: Film,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="The timeline to write.",
            show_default="standard output",
            rich_help_panel=WRITING,
        ),
    ] = None,
    quality: QualityOption = "standard",
    rules: RulesOption = None,
    mix: Mix = "mains",
    stream: Stream = None,
    start_timecode: StartTimecode = None,
    frame_rate: FrameRate = None,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
) -> None:
    """Find a film's gunshots and write only the timeline, as JSON.

    Example: `blastline detect film.mkv -o timeline.json`
    """
    from .. import run
    from ..staging import staged

    timebase = parse_timebase(start_timecode, frame_rate)

    def found() -> bytes:
        with shown_progress(quiet=quiet) as progress:
            timeline = run.detect(
                film, quality=quality, rules=rules, mix=mix, stream=stream, timebase=timebase, progress=progress
            )
        return encode(timeline)

    if output is None:
        typer.echo(found(), nl=False)
        return
    with staged(output.parent, names=[output.name], overwrite=overwrite) as hidden:
        (hidden / output.name).write_bytes(found())


def check(
    target: Annotated[
        Path, typer.Argument(metavar="DIR|TIMELINE", help="A result's folder or its timeline.json.", show_default=False)
    ],
    audio: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="The film, where it has moved.", show_default="looked for beside the timeline"
        ),
    ] = None,
    drive: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The drive to check.", show_default="drive.wav beside the timeline"),
    ] = None,
    actuator: MadeFor = None,
    rules: RulesOption = None,
    quiet: Quiet = False,
) -> int:
    """Check on the files themselves that drive and film are aligned: exit code 0 where they are, 1 where not.

    Example: `blastline check result --audio film.mkv`
    """
    from .. import run

    with shown_progress(quiet=quiet) as progress:
        timeline = run.check(target, audio=audio, drive=drive, actuator=actuator, rules=rules, progress=progress)
    say_checks(timeline, quiet=quiet, err=False)
    return _code(timeline)


def export(
    timeline: Annotated[Path, typer.Argument(metavar="TIMELINE", help="A timeline.json.", show_default=False)],
    formats: Formats,
    folder: ResultFolder,
    start_timecode: StartTimecode = None,
    frame_rate: FrameRate = None,
    drive: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="The drive, for the formats that are made from it: ahap, haptic, hjif.",
            show_default="drive.wav beside the timeline",
            rich_help_panel=DRIVING,
        ),
    ] = None,
    actuator: MadeFor = None,
    rules: RulesOption = None,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
) -> None:
    """Write a timeline in the formats of other tools; prints each file's name.

    What rounding to frames or milliseconds moves, and what a haptic format cannot hold, is told on standard error.

    Example: `blastline export result/timeline.json --format resolve,reaper -o cues`
    """
    from .. import run

    def note(line: str) -> None:
        if not quiet:
            typer.echo(line, err=True)

    files = run.export(
        timeline,
        folder,
        formats=listed(formats),
        timebase=parse_timebase(start_timecode, frame_rate),
        drive=drive,
        actuator=actuator,
        rules=rules,
        overwrite=overwrite,
        note=note,
    )
    for file in files:
        typer.echo(file)


def formats() -> None:
    """List the formats of `--format`: the files, how exact their times are, and the tool that opens them.

    Example: `blastline formats`
    """
    from .. import run

    for row in run.exports():
        typer.echo(f"{row.name:<9} {', '.join(row.files):<24} {row.exactness}\n{'':<9} {row.tool}: {row.how}")


def _code(timeline: Timeline) -> int:
    return 0 if all(check.passed for check in timeline.checks) else FAILED_CHECK

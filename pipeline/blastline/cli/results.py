"""`check`, `export` and `formats`: what comes after a run, of its timeline and its drive."""

from pathlib import Path
from typing import Annotated

import typer

from ..streams import parse_streams
from ..timebase import parse_timebase
from .options import (
    DRIVING,
    Formats,
    FrameRate,
    MadeFor,
    Overwrite,
    Quiet,
    Result,
    ResultFolder,
    RulesOption,
    StartTimecode,
)
from .progress import shown_progress
from .summary import say_checks
from .values import items_of

_NAME_WIDTH, _FILES_WIDTH = 9, 24  # columns of `blastline formats`; longer lists of files have a line of their own


def check(
    target: Result,
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
    stream: Annotated[
        str | None,
        typer.Option(
            metavar="N[,N...]",
            help="The sound stream of --audio, from 0; several are joined, as in `render`.",
            show_default="as in the timeline",
        ),
    ] = None,
    actuator: MadeFor = None,
    rules: RulesOption = None,
    quiet: Quiet = False,
) -> int:
    """Check on the files themselves that drive and film are aligned: exit code 0 where they are, 1 where not.

    Example: `blastline check result --audio film.mkv`
    """
    from .. import run

    notes: list[str] = []
    with shown_progress(quiet=quiet) as progress:
        timeline = run.check(
            target,
            audio=audio,
            drive=drive,
            actuator=actuator,
            stream=parse_streams(stream),
            rules=rules,
            progress=progress,
            note=notes.append,
        )
    if not quiet:
        for note in notes:
            typer.echo(note, err=True)
    code = say_checks(timeline, quiet=quiet, err=False, each_kind=True)
    if not quiet and timeline.actuator is None and drive is None:
        _say_no_drive((target if target.is_dir() else target.parent) / run.DRIVE)
    return code


def _say_no_drive(beside: Path) -> None:
    """Say on stderr that no drive was checked, as the timeline has none, nor the one that may lie beside it."""
    this = f"{beside}; the timeline has no drive, so this one is another's"
    none = "a drive; the timeline has none, and only its events were held against the film"
    typer.echo(f"not checked: {this if beside.is_file() else none}", err=True)


def export(
    timeline: Result,
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
        formats=items_of(formats),
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

    for row in run.export_rows():
        files = ", ".join(row.files)
        if len(files) > _FILES_WIDTH:
            files = f"{files}\n{'':{_NAME_WIDTH + _FILES_WIDTH + 1}}"
        typer.echo(f"{row.name:{_NAME_WIDTH}} {files:{_FILES_WIDTH}} {row.exactness}")
        typer.echo(f"{'':{_NAME_WIDTH}} {row.tool}: {row.how}")

"""`render`, `detect`, `check` and `export`."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import OutputError
from ..model import Timeline, encode
from ..timebase import parse_timebase
from .options import (
    DRIVING,
    WRITING,
    ActuatorOption,
    BackgroundOption,
    BudgetOption,
    DriveOption,
    EditedTimeline,
    Film,
    Formats,
    FrameRate,
    LevelOption,
    MadeFor,
    MaxCostOption,
    Mix,
    OriginalTimeline,
    Overwrite,
    PhaseOption,
    QualityOrBudget,
    Quiet,
    ReportOption,
    ResultFolder,
    RulesOption,
    StartTimecode,
    Stream,
    listed,
)
from .progress import shown_progress
from .summary import say_checks, say_summary, say_warnings

if TYPE_CHECKING:
    from ..run import Allowance, RenderOptions

FAILED_CHECK = 1


def render(
    film: Film,
    folder: ResultFolder,
    quality: QualityOrBudget = None,
    budget: BudgetOption = None,
    max_cost: MaxCostOption = None,
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

    allowed = run.allowance(budget=budget, max_cost=max_cost, quality=quality)
    options = run.RenderOptions(
        quality=quality or "standard",
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
    if allowed is not None:
        options = _within(film, allowed, options, drives=True, quiet=quiet)
    notes: list[str] = []
    with shown_progress(quiet=quiet) as progress:
        made = run.render(film, folder, options, progress, notes.append)
    say_warnings(made)
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
    quality: QualityOrBudget = None,
    budget: BudgetOption = None,
    max_cost: MaxCostOption = None,
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

    allowed = run.allowance(budget=budget, max_cost=max_cost, quality=quality)
    timebase = parse_timebase(start_timecode, frame_rate)
    options = run.RenderOptions(
        quality=quality or "standard", rules=rules, mix=mix, stream=stream, timebase=timebase, report=False
    )

    def found() -> Timeline:
        asked = options if allowed is None else _within(film, allowed, options, drives=False, quiet=quiet)
        with shown_progress(quiet=quiet) as progress:
            return run.detect(
                film,
                quality=asked.quality,
                rules=rules,
                mix=mix,
                stream=stream,
                timebase=timebase,
                budget=asked.budget,
                progress=progress,
            )

    if output is None:
        if sys.stdout is None:
            raise OutputError("standard output is closed, so the timeline has nowhere to go; give -o")
        timeline = found()
        typer.echo(encode(timeline), nl=False)
    else:
        with staged(output.parent, names=[output.name], films=[film], overwrite=overwrite) as hidden:
            timeline = found()
            (hidden / output.name).write_bytes(encode(timeline))
    say_warnings(timeline)


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
    stream: Annotated[
        int | None,
        typer.Option(min=0, help="The sound stream of --audio, from 0.", show_default="the one of the timeline"),
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
            stream=stream,
            rules=rules,
            progress=progress,
            note=notes.append,
        )
    if not quiet:
        for note in notes:
            typer.echo(note, err=True)
    say_checks(timeline, quiet=quiet, err=False)
    beside = (target if target.is_dir() else target.parent) / run.DRIVE
    if not quiet and timeline.actuator is None and drive is None and beside.is_file():
        typer.echo(f"not checked: {beside}; the timeline has no drive, so this one is another's", err=True)
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


def _within(
    film: Path, allowed: "Allowance", options: "RenderOptions", *, drives: bool, quiet: bool
) -> "RenderOptions":
    """Return the options with the quality that fits the budget, which counts from the start of the process; say so."""
    from .. import run

    with shown_progress(quiet=quiet) as progress:
        fitted = run.within(film, allowed, options, drives=drives, since_cpu_s=0.0, progress=progress)
    if fitted.budget is not None and not quiet:
        typer.echo(fitted.budget.note, err=True)
    return fitted


def _code(timeline: Timeline) -> int:
    return 0 if all(check.passed for check in timeline.checks) else FAILED_CHECK

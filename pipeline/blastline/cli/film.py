"""`render` and `detect`: from a film to its timeline and drive."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import OutputError
from ..model import Timeline, encode
from ..ruleset import DEFAULT_ACTUATOR
from ..streams import parse_streams
from ..timebase import parse_timebase
from .options import (
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
)
from .progress import shown_progress
from .summary import say_checks, say_found, say_summary, say_warnings
from .values import items_of, timeline_file

if TYPE_CHECKING:
    from ..run import Allowance, RenderOptions


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
    actuator: ActuatorOption = DEFAULT_ACTUATOR,
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
    """Find a film's gunshots and write a vibration drive for them, with a timeline (always as json) and a report.

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
        stream=parse_streams(stream),
        timebase=parse_timebase(start_timecode, frame_rate),
        formats=tuple(dict.fromkeys(("json", *items_of(formats)))),  # `check`, `export` and `conform` read it
        report=report,
        overwrite=overwrite,
        timeline=timeline,
        original=original,
    )
    if allowed is not None:
        run.require_place(film, folder, options)  # before minutes of measuring
        options = _within(film, allowed, options, drives=True, quiet=quiet)
    notes: list[str] = []
    with shown_progress(quiet=quiet) as progress:
        made = run.render(film, folder, options, progress, notes.append)
    say_warnings(made)
    if not quiet:
        for note in notes:
            typer.echo(note, err=True)
        say_summary(made, folder / "report.html" if report else folder)
    return say_checks(made, quiet=quiet, err=True)


def detect(
    film: Film,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            parser=timeline_file,
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
    options = run.RenderOptions(
        quality=quality or "standard",
        rules=rules,
        mix=mix,
        stream=parse_streams(stream),
        timebase=parse_timebase(start_timecode, frame_rate),
        report=False,
    )

    def found() -> Timeline:
        asked = options if allowed is None else _within(film, allowed, options, drives=False, quiet=quiet)
        with shown_progress(quiet=quiet) as progress:
            return run.detect(film, asked, progress)

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
    if not quiet:
        say_found(timeline)


def _within(
    film: Path, allowed: "Allowance", options: "RenderOptions", *, drives: bool, quiet: bool
) -> "RenderOptions":
    """Return the options with the quality that fits the budget, which counts from the start of the process; say so."""
    from .. import run

    with shown_progress(quiet=quiet) as progress:
        fitted = run.choose_quality(film, allowed, options, drives=drives, since_cpu_s=0.0, progress=progress)
    if fitted.budget is not None and not quiet:
        typer.echo(fitted.budget.note, err=True)
    return fitted

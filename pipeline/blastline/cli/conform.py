"""`conform`."""

from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..streams import parse_streams
from ..timebase import parse_timebase
from ..timecode import clock_text
from .options import FINDING, TIMECODE, Overwrite, Quiet, Result, ResultFolder, RulesOption
from .progress import shown_progress
from .summary import say_warnings

if TYPE_CHECKING:
    from ..run import Conformed

_MOST_LISTED = 20

NewMix = Annotated[
    str | None,
    typer.Option(
        metavar="MIX",
        help="Which channels of the new film to listen to: mains, lfe, center, all, or their numbers from 0: 0,1.",
        show_default="as in the timeline",
        rich_help_panel=FINDING,
    ),
]
NewStream = Annotated[
    str | None,
    typer.Option(
        metavar="N[,N...]",
        help="Which sound stream of the new film, from 0; several are joined, as in `render`.",
        show_default="its default stream",
        rich_help_panel=FINDING,
    ),
]
NewStartTimecode = Annotated[
    str | None,
    typer.Option(
        "--start-timecode",
        metavar="HH:MM:SS:FF",
        help="The timecode of the new film's first picture, as in `render`.",
        show_default="as the new film says",
        rich_help_panel=TIMECODE,
    ),
]
NewFrameRate = Annotated[
    str | None,
    typer.Option(
        "--frame-rate",
        metavar="RATE",
        help="The new film's frames a second, as in `render`.",
        show_default="as the new film says",
        rich_help_panel=TIMECODE,
    ),
]


def conform(
    timeline: Result,
    old: Annotated[
        Path,
        typer.Option("--from", metavar="OLD", help="The film that the timeline was made from.", show_default=False),
    ],
    new: Annotated[Path, typer.Option("--to", metavar="NEW", help="The new cut of the film.", show_default=False)],
    folder: ResultFolder,
    mix: NewMix = None,
    stream: NewStream = None,
    rules: RulesOption = None,
    start_timecode: NewStartTimecode = None,
    frame_rate: NewFrameRate = None,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
) -> None:
    """Move a timeline to a new cut of its film by listening to both; what cannot be found is listed, never guessed.

    Writes timeline.json for the new cut, conform.csv (where each shot went) and stretches.csv (which part of the old
    film is where in the new one). Shots that were not placed do not change the exit code.

    Example: `blastline conform result/timeline.json --from old.wav --to new.mkv -o conformed`
    """
    from .. import run

    with shown_progress(quiet=quiet) as progress:
        done = run.conform(
            timeline,
            folder,
            old=old,
            new=new,
            mix=mix,
            stream=parse_streams(stream),
            timebase=parse_timebase(start_timecode, frame_rate),
            rules=rules,
            overwrite=overwrite,
            progress=progress,
        )
    say_warnings(done.timeline)
    if not quiet:
        _say_lost(done)
        _say_stretches(done)


def _say_lost(done: "Conformed") -> None:
    """List on stderr what was not placed."""
    lost = done.lost
    for event, place, missing in lost[:_MOST_LISTED]:
        where = f"old film {event.timecode}, missing in the new one at {missing}"
        typer.echo(f"not placed: {event.id}: {place.reason.value} ({where})", err=True)
    if len(lost) > _MOST_LISTED:
        typer.echo(f"not placed: {len(lost) - _MOST_LISTED} more, in conform.csv", err=True)


def _say_stretches(done: "Conformed") -> None:
    for number, course in enumerate(done.courses, start=1):
        segment = course.segment
        both = (segment.start_s, segment.stop_s), segment.new_span_s
        spans = " -> ".join(f"{_clock(low)} to {_clock(high)}" for low, high in both)
        kept = ", pitch kept" if course.keeps_pitch else ""
        typer.echo(f"stretch {number}: {spans}, speed {1.0 / segment.line.scale:.6f}{kept}")
    residuals = [abs(each.residual_ms) for each in done.placed]
    placed, count = len(residuals), len(done.places)
    most = f"; largest residual {max(residuals):.3f} ms" if residuals else ""
    typer.echo(f"{placed} of {count} shots placed, {count - placed} not{most}")


def _clock(time_s: float) -> str:
    return clock_text(Fraction(max(0.0, time_s)), 3, hour_digits=1)

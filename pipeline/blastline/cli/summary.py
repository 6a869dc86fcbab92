"""What a run found, in a few lines for people."""

from pathlib import Path

import typer

from ..model import Edits, Timeline
from ..plurals import counted

FAILED_CHECK = 1
_NEARLY = 0.5  # as likely a shot as not


def say_summary(timeline: Timeline, results: Path) -> None:
    """Say on stderr how many shots there are, how they are driven, and where the results are."""
    from .. import run

    models = [event.drive.model for event in timeline.events if event.drive is not None]
    say_found(timeline)
    if timeline.edits is not None:
        _say_edits(timeline.edits)
    if models:
        driven = ", ".join(f"{models.count(model)} {model}" for model in sorted(set(models)))
        typer.echo("; ".join([f"drive: {driven}", *run.told_options(timeline)]), err=True)
        for line in run.told_faintness(timeline):
            typer.echo(f"note: {line}", err=True)
    typer.echo(f"results: {results}", err=True)


def say_found(timeline: Timeline) -> None:
    """Say on stderr how many shots there are, and how many more there may be."""
    bursts = {event.burst for event in timeline.events if event.burst is not None}
    told = [counted(len(timeline.events), "shot"), counted(len(bursts), "burst")]
    nearly = sum(each.evidence.get("probability", 0.0) >= _NEARLY for each in timeline.rejections)
    if nearly and timeline.edits is None:
        told.append(
            f"{nearly} more nearly taken for {'a shot' if nearly == 1 else 'shots'} (rejections in the timeline)"
        )
    typer.echo(", ".join(told), err=True)


def say_warnings(timeline: Timeline) -> None:
    """Say on stderr what of the film was damaged and how it was mended; it is no progress, so quiet hides nothing.

    An edited file without events may be meant, or a copy that failed.
    """
    for warning in timeline.source.warnings:
        typer.echo(f"warning: {warning}", err=True)
    if timeline.edits is not None and not timeline.events:
        typer.echo(f"warning: {timeline.edits.file}: no events: the drive is silent", err=True)


def _say_edits(edits: Edits) -> None:
    ways = ("kept", "moved", "changed", "added", "deleted", "as_given")
    counts = ", ".join(f"{number} {way.replace('_', ' ')}" for way in ways if (number := getattr(edits, way)))
    typer.echo(f"edits: {edits.file}: {counts or 'no shots'}", err=True)
    for note in edits.notes:
        typer.echo(f"note: {note}", err=True)


def say_checks(timeline: Timeline, *, quiet: bool, err: bool, each_kind: bool = False) -> int:
    """List the checks that failed and, unless quiet, how many passed; on stderr or on standard output.

    With `each_kind` what passed is listed as well. Return the exit code: 0, or `FAILED_CHECK`.
    """
    from .. import run

    if each_kind and not quiet:
        for line in run.told_passes(timeline):
            typer.echo(f"passed: {line}", err=err)
        for line in run.told_unmeasured(timeline):
            typer.echo(f"not measured: {line}", err=err)
    for line in run.told_failures(timeline):
        typer.echo(f"failed: {line}", err=err)
    if not quiet:
        typer.echo(f"checks: {run.told_count(timeline)}", err=err)
    return 0 if all(check.passed for check in timeline.checks) else FAILED_CHECK

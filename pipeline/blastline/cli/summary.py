"""What a run found, in a few lines for people."""

from pathlib import Path

import typer

from ..model import Check, Edits, Timeline

FAILED_CHECK = 1
_ALL_DIGITS = 17


def say_summary(timeline: Timeline, results: Path) -> None:
    """Say on stderr how many shots there are, how they are driven, and where the results are."""
    models = [event.drive.model for event in timeline.events if event.drive is not None]
    say_found(timeline)
    if timeline.edits is not None:
        _say_edits(timeline.edits)
    if models:
        driven = ", ".join(f"{models.count(model)} {model}" for model in sorted(set(models)))
        typer.echo(f"drive: {driven}", err=True)
    typer.echo(f"results: {results}", err=True)


def say_found(timeline: Timeline) -> None:
    """Say on stderr how many shots there are."""
    bursts = {event.burst for event in timeline.events if event.burst is not None}
    typer.echo(f"{_count(len(timeline.events), 'shot')}, {_count(len(bursts), 'burst')}", err=True)


def say_warnings(timeline: Timeline) -> None:
    """Say on stderr what of the film was damaged and how it was mended; it is no progress, so quiet hides nothing."""
    for warning in timeline.source.warnings:
        typer.echo(f"warning: {warning}", err=True)


def _say_edits(edits: Edits) -> None:
    ways = ("kept", "moved", "changed", "added", "deleted")
    counts = ", ".join(f"{number} {way}" for way in ways if (number := getattr(edits, way)))
    typer.echo(f"edits: {edits.file}{': ' if counts else ''}{counts}", err=True)
    for note in edits.notes:
        typer.echo(f"note: {note}", err=True)


def say_checks(timeline: Timeline, *, quiet: bool, err: bool) -> int:
    """List the checks that failed and, unless quiet, how many passed; on stderr or on standard output.

    Return the exit code: 0, or `FAILED_CHECK`.
    """
    checks = timeline.checks
    failed = [check for check in checks if not check.passed]
    for check in failed:
        typer.echo(f"failed: {_described(check)}", err=err)
    if not quiet:
        typer.echo(f"checks: {len(checks) - len(failed)} of {len(checks)} passed", err=err)
    return FAILED_CHECK if failed else 0


def _described(check: Check) -> str:
    """Return a check's name, its event, what was measured and what it had to stay within: told apart, however near."""
    value, bound, unit = check.measured, check.limit, f" {check.unit}" if check.unit else ""
    usual = 11 if check.name == "drive_speed" else 6
    digits = usual
    if value is not None and bound is not None:
        digits = next((n for n in range(usual, _ALL_DIGITS) if f"{value:.{n}g}" != f"{bound:.{n}g}"), usual)
    measured = "not measured" if value is None else f"{value:.{digits}g}{unit}"
    limit = "" if bound is None else f" (limit {bound:.{digits}g}{unit})"
    return f"{check.name}, {check.event or 'the film'}: {measured}{limit}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"

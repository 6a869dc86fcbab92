"""How far a run is: bars with the time left on a terminal, a short line per stage elsewhere, nothing when quiet."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

import typer

from ..interruption import heed_interruption
from ..progress import Progress, no_progress


@contextmanager
def shown_progress(*, quiet: bool) -> Iterator[Progress]:
    """Yield a function that shows progress on stderr in the way that suits it."""
    if quiet:
        yield _heeding(no_progress)
    elif sys.stderr is not None and sys.stderr.isatty():
        with _bars() as shown:
            yield _heeding(shown)
    else:
        yield _heeding(_lines())


def _heeding(show: Progress) -> Progress:
    """Return a function that shows progress unless the run is to end."""

    def heed_and_show(stage: str, done: int, total: int | None) -> None:
        heed_interruption()
        show(stage, done, total)

    return heed_and_show


def _lines() -> Progress:
    """Return a function that writes the name of each stage once, when it starts."""
    begun: set[str] = set()

    def show(stage: str, done: int, total: int | None) -> None:
        if stage not in begun:
            begun.add(stage)
            typer.echo(f"blastline: {stage} ...", err=True)

    return show


@contextmanager
def _bars() -> Iterator[Progress]:
    """Yield a function that draws a bar for each stage; one whose total is unknown pulses."""
    from rich.console import Console
    from rich.progress import BarColumn, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bars

    columns = (
        TextColumn("{task.description:<12}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeRemainingColumn(),
        TextColumn("left,"),
        TimeElapsedColumn(),
    )
    tasks: dict[str, TaskID] = {}
    with Bars(*columns, console=Console(stderr=True)) as bars:

        def show(stage: str, done: int, total: int | None) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=total)
            bars.update(tasks[stage], completed=done, total=total)

        yield show

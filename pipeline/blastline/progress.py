"""Telling the user how far a long piece of work has come."""

from collections.abc import Callable, Iterable, Iterator

from .model import Clip

Progress = Callable[[str, int, int | None], None]
"""Told of work done: the stage's name, how much is done, and how much there is where that is known."""


def no_progress(stage: str, done: int, total: int | None) -> None:
    """Tell nobody."""


def report_progress(
    blocks: Iterable[Clip], progress: Progress, total: int | None, *, stage: str = "listening"
) -> Iterator[Clip]:
    """Yield the blocks and tell of each when it has been dealt with."""
    for block in blocks:
        yield block
        progress(stage, block.span.stop, total)


Note = Callable[[str], None]
"""Is told a line that the user should know but need not act on."""


def no_note(line: str) -> None:
    """Say nothing."""

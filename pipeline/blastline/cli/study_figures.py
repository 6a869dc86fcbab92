"""The file that a study writes its figures into."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ..staging import staged


@contextmanager
def figures_file(output: Path | None, *, overwrite: bool) -> Iterator[Callable[[bytes], object]]:
    """Yield what writes the figures, which does nothing without a file; the file appears when it is whole.

    Raises OutputError before the study begins where the file exists and `overwrite` is not set, or cannot be written.
    """
    if output is None:
        yield lambda figures: None
        return
    with staged(output.parent, names=[output.name], overwrite=overwrite) as hidden:
        yield (hidden / output.name).write_bytes


def as_json(figures: object) -> bytes:
    """Return the figures of a study as JSON for people as well."""
    import msgspec

    return msgspec.json.format(msgspec.json.encode(figures), indent=1) + b"\n"

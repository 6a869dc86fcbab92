"""What stands in a folder of results at each moment at which a run could be killed while it moves its files."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

Files = dict[str, bytes]


def shown(folder: Path) -> Files:
    """Return the files below a folder but for hidden ones, with what they hold."""
    every = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    return {name: path.read_bytes() for name, path in every.items() if ".blastline-" not in name}


@contextmanager
def moments(folder: Path, *, broken_off: tuple[int, ...] = ()) -> Iterator[list[Files]]:
    """Yield what is shown before each move of a file and after the last; Ctrl-C comes before the moves of given number.

    The list grows while files are moved, forwards or back.
    """
    move, seen = Path.replace, list[Files]()

    def seen_move(path: Path, target: Any) -> Path:
        seen.append(shown(folder))
        if len(seen) - 1 in broken_off:
            raise KeyboardInterrupt
        return move(path, target)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Path, "replace", seen_move)
        try:
            yield seen
        finally:
            seen.append(shown(folder))

"""Results appear whole or not at all.

A run writes into a hidden folder beside its results and moves each file into place when every one is finished. An
error or an interruption removes the hidden folder and leaves earlier results as they were.
"""

import shutil
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import OutputError


@contextmanager
def staged(folder: Path, *, names: Collection[str], overwrite: bool) -> Iterator[Path]:
    """Yield a hidden folder to write into; on success move all its files into `folder`.

    `names` are the files that the run is going to write. Raises OutputError where one of them exists and `overwrite`
    is not set, or where `folder` cannot be made or written.
    """
    _refuse_existing(folder, names, overwrite)
    made = _missing_parents(folder)
    try:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            hidden = Path(tempfile.mkdtemp(prefix=".blastline-", dir=folder))
        except OSError as error:
            raise OutputError(f"{folder}: cannot write here: {error.strerror}") from error
        try:
            yield hidden
            _move_all(hidden, folder)
        finally:
            shutil.rmtree(hidden, ignore_errors=True)
        made = []
    except OSError as error:
        if isinstance(error, OutputError) or error.errno is None:
            raise
        raise OutputError(f"{error.filename or folder}: cannot write: {error.strerror}") from error
    finally:
        for parent in made:
            if parent.is_dir() and not any(parent.iterdir()):
                parent.rmdir()


def _refuse_existing(folder: Path, names: Collection[str], overwrite: bool) -> None:
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{folder}: is a file; expected a folder for the results")
    there = [name for name in names if (folder / name).exists()]
    if there and not overwrite:
        raise OutputError(f"{folder / there[0]}: exists already; give --overwrite to replace it, or another folder")


def _missing_parents(folder: Path) -> list[Path]:
    """Return the folders that will have to be made for `folder`, innermost first."""
    return [path for path in (folder, *folder.parents) if not path.exists()]


def _move_all(hidden: Path, folder: Path) -> None:
    for file in sorted(path for path in hidden.rglob("*") if path.is_file()):
        target = folder / file.relative_to(hidden)
        target.parent.mkdir(parents=True, exist_ok=True)
        file.replace(target)

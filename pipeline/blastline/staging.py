"""Results appear whole or not at all.

A run writes into a hidden folder beside its results and moves each file into place when every one is finished. An
error or an interruption removes the hidden folder and leaves earlier results as they were.
"""

import shutil
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import BlastlineError, OutputError


@contextmanager
def staged(folder: Path, *, names: Collection[str], overwrite: bool, sets: Collection[str] = ()) -> Iterator[Path]:
    """Yield a hidden folder to write into; on success move all its files into `folder`.

    `names` are the files that the run is going to write; `sets` are patterns such as `reel-*.haptic`, for files whose
    number is not known yet: those that an earlier run left and this one does not write again are removed. Raises
    OutputError where one of them exists and `overwrite` is not set, or where `folder` cannot be made or written.
    """
    _refuse_existing(folder, names, sets, overwrite)
    made = _missing_parents(folder)
    try:
        hidden = _hidden_folder(folder)
        try:
            yield hidden
            _move_all(hidden, folder, sets)
            made = []
        except OSError as error:
            told = _output_error(error, hidden, folder)
            if told is None:
                raise
            raise told from error
        finally:
            shutil.rmtree(hidden, ignore_errors=True)
    finally:
        for parent in made:
            if parent.is_dir() and not any(parent.iterdir()):
                parent.rmdir()


def _hidden_folder(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(prefix=".blastline-", dir=folder))
    except OSError as error:
        raise OutputError(f"{folder}: cannot write here: {error.strerror}") from error


def _output_error(error: OSError, hidden: Path, folder: Path) -> OutputError | None:
    """Return a failure to write in the user's words, with the file's final name; None for any other error."""
    place = Path(str(error.filename)) if error.filename else hidden
    if isinstance(error, BlastlineError) or error.errno is None or not place.is_relative_to(hidden):
        return None
    return OutputError(f"{folder / place.relative_to(hidden)}: cannot write: {error.strerror}")


def _refuse_existing(folder: Path, names: Collection[str], sets: Collection[str], overwrite: bool) -> None:
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{folder}: is a file; expected a folder for the results")
    there = [folder / name for name in names if (folder / name).exists()]
    there += [file for pattern in sets for file in sorted(folder.glob(pattern))]
    for file in there:
        _refuse_folder(file)
    if there and not overwrite:
        raise OutputError(f"{there[0]}: exists already; give --overwrite to replace it, or another folder")


def _refuse_folder(target: Path) -> None:
    if target.is_dir():
        raise OutputError(f"{target}: is a folder; expected the name of a file to write")


def _missing_parents(folder: Path) -> list[Path]:
    """Return the folders that will have to be made for `folder`, innermost first."""
    return [path for path in (folder, *folder.parents) if not path.exists()]


def _move_all(hidden: Path, folder: Path, sets: Collection[str]) -> None:
    """Move every file into place, and away what else was of a set; where that fails half-way, put all of it back."""
    files = sorted(path.relative_to(hidden) for path in hidden.rglob("*") if path.is_file())
    earlier = Path(tempfile.mkdtemp(prefix="earlier-", dir=hidden))
    stale = {path.relative_to(folder) for pattern in sets for path in folder.glob(pattern)} - set(files)
    done: list[Path] = []
    try:
        for file in files:
            target = folder / file
            target.parent.mkdir(parents=True, exist_ok=True)
            done.append(file)
            _refuse_folder(target)
            if target.exists():
                (earlier / file).parent.mkdir(parents=True, exist_ok=True)
                target.replace(earlier / file)
            (hidden / file).replace(target)
        for file in sorted(stale):
            (folder / file).replace(earlier / file)
    except BaseException:
        for file in stale:
            _put_back(earlier / file, folder / file, moved=False)
        for file in done:
            _put_back(earlier / file, folder / file, moved=not (hidden / file).exists())
        raise


def _put_back(before: Path, target: Path, *, moved: bool) -> None:
    if before.exists():
        before.replace(target)
    elif moved:
        target.unlink(missing_ok=True)

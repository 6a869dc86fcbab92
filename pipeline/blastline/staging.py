"""Results appear whole or not at all.

A run writes into a hidden folder beside its results and moves each file into place when every one is finished. An
error or an interruption removes the hidden folder and leaves earlier results as they were. Of several runs into one
folder only one at a time moves its files. A run that is killed while it does leaves some of them, but never the file
that is the seal of a whole result.
"""

import errno
import os
import shutil
import stat
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NotRequired, TypedDict, Unpack

from .abandoned import EARLIER, clear_abandoned, held_folder, keeps_earlier
from .errors import BlastlineError, OutputError
from .interruption import heed_interruption, remember_written
from .moving import alone_in, refuse_locked

_FULL = {errno.ENOSPC, errno.EFBIG, errno.EDQUOT}


class Files(TypedDict):
    """Which files of a folder a run writes, replaces, removes and leaves alone.

    `names` are the files that the run is going to write; `sets` are patterns such as `reel-*.haptic`, for files whose
    number is not known yet: those that an earlier run left and this one does not write again are removed. So is, with
    `overwrite`, what `stale` names: whatever else an earlier run may have written. `films` are never replaced, and
    neither they nor what is `spared` is removed.
    """

    names: Collection[str]
    overwrite: bool
    sets: NotRequired[Collection[str]]
    stale: NotRequired[Collection[str]]
    films: NotRequired[Collection[Path]]
    spared: NotRequired[Collection[Path]]


@dataclass(frozen=True)
class _Results:
    """`Files` in their folder; `seal` as for `staged`."""

    folder: Path
    names: Collection[str]
    overwrite: bool
    sets: Collection[str] = ()
    stale: Collection[str] = ()
    films: Collection[Path] = ()
    spared: Collection[Path] = ()
    seal: str | None = None


@contextmanager
def staged(folder: Path, *, seal: str | None = None, **files: Unpack[Files]) -> Iterator[Path]:
    """Yield a hidden folder to write into; on success move all its files into `folder`.

    `seal` is the file by which others know that a result is whole: it comes last, and an earlier one goes before any
    other file of its result. Raises OutputError where one of the files, or one that is stale, exists and `overwrite` is
    not set, now or when files are to be moved into place, where it is no regular file, or where `folder` cannot be
    written.
    """
    wanted = _Results(folder, seal=seal, **files)
    _refuse_existing(wanted, wanted.names)
    refuse_locked(folder)
    made = _missing_parents(folder)
    try:
        hidden, held = _hidden_folder(folder)
        whole = False
        try:
            clear_abandoned(folder)
            _require_nameable(hidden, wanted.names)
            yield hidden
            heed_interruption()
            with alone_in(folder):
                _move_all(hidden, wanted)
            made, whole = [], True
        except OSError as error:
            told = _output_error(error, hidden, wanted)
            if told is None:
                raise
            raise told from error
        finally:
            if whole or not keeps_earlier(hidden):  # what could not be put back is nowhere else
                _remove(hidden)
            if held is not None:
                os.close(held)
    finally:
        for parent in made:
            with suppress(OSError):  # another run may be writing there by now
                parent.rmdir()


def require_free(folder: Path, **files: Unpack[Files]) -> None:
    """Raise what `staged` would raise of these files before anything is written, for who has long to go until then."""
    wanted = _Results(folder, **files)
    _refuse_existing(wanted, wanted.names)


def require_utf_8(path: Path, *, advice: str = "choose another folder for the results") -> None:
    """Raise OutputError for a name that no text can hold, and the libraries that write and read sound cannot use."""
    try:
        str(path).encode("utf-8")
    except UnicodeEncodeError:
        raise OutputError(f"{path}: the name is not valid UTF-8; {advice}") from None


def _hidden_folder(folder: Path) -> tuple[Path, int | None]:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return held_folder(folder)
    except OSError as error:
        raise OutputError(f"{folder}: cannot write here: {error.strerror}") from error


def _remove(hidden: Path) -> None:
    """Remove a hidden folder to its end, though an end of the run is asked for meanwhile."""
    try:
        shutil.rmtree(hidden, ignore_errors=True)
    except KeyboardInterrupt:  # while this one is on its way out, no other is raised
        shutil.rmtree(hidden, ignore_errors=True)
        raise


def _require_nameable(hidden: Path, names: Collection[str]) -> None:
    """Raise OSError for a name that the file system does not take: better now than when all the work is done."""
    for name in names:
        with suppress(FileNotFoundError):
            (hidden / name).lstat()


def _output_error(error: OSError, hidden: Path, wanted: _Results) -> OutputError | None:
    """Return a failure to write in the user's words, with the file's final name; None for any other error."""
    folder = wanted.folder
    if isinstance(error, OutputError):
        told = str(error).replace(f"{hidden}{os.sep}", str(folder / "_")[:-1]).replace(str(hidden), str(folder))
        return OutputError(told) if told != str(error) else None
    if isinstance(error, BlastlineError) or error.errno is None:
        return None
    if error.filename is None:
        # an open file that cannot grow does not tell its name; a failure to read has other numbers
        full = error.errno in _FULL
        return OutputError(f"{_unfinished(hidden, wanted)}: cannot write: {error.strerror}") if full else None
    place = Path(str(error.filename))
    if not place.is_relative_to(hidden):
        return None
    return OutputError(f"{folder / place.relative_to(hidden)}: cannot write: {error.strerror}")


def _unfinished(hidden: Path, wanted: _Results) -> Path:
    """Return the final name of the file that was written last; that of the folder where none was."""
    if len(wanted.names) == 1 and not wanted.sets:
        return wanted.folder / next(iter(wanted.names))
    files = [path for path in hidden.iterdir() if path.is_file()]
    newest = max(files, key=lambda path: path.stat().st_mtime_ns, default=None)
    return wanted.folder if newest is None else wanted.folder / newest.name


def _refuse_existing(wanted: _Results, names: Collection[str]) -> None:
    folder = wanted.folder
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{folder}: is a file; expected a folder for the results")
    there = [folder / name for name in names if os.path.lexists(folder / name)]
    there += [file for pattern in wanted.sets for file in sorted(folder.glob(pattern))]
    for file in there:
        _refuse_irregular(file)
        if _is_one_of(file, wanted.films):
            raise OutputError(f"{file}: is the film itself; choose another folder or name for the results")
    if there and not wanted.overwrite:
        raise OutputError(f"{there[0]}: exists already; give --overwrite to replace it, or another place")
    if not wanted.overwrite and (left := sorted(_stale(wanted))):
        raise OutputError(
            f"{left[0]}: exists already, from another run; give --overwrite to remove it, or another place"
        )


def _refuse_irregular(target: Path) -> None:
    """Raise OutputError for what moving a file into its place would destroy: a folder, a pipe, a device, a link."""
    if target.is_dir():
        raise OutputError(f"{target}: is a folder; expected the name of a file to write")
    if os.path.lexists(target) and not stat.S_ISREG(target.lstat().st_mode):
        what = "a link" if target.is_symlink() else "a pipe, a device or the like"
        raise OutputError(f"{target}: is {what}; expected the name of a regular file to write")


def _is_one_of(file: Path, others: Collection[Path]) -> bool:
    return any(other.exists() and file.samefile(other) for other in others)


def _missing_parents(folder: Path) -> list[Path]:
    """Return the folders that will have to be made for `folder`, innermost first."""
    return [path for path in (folder, *folder.parents) if not path.exists()]


def _move_all(hidden: Path, wanted: _Results) -> None:
    """Move every file into place and away what earlier runs left; where that fails half-way, put all of it back."""
    files = sorted(path.relative_to(hidden) for path in hidden.rglob("*") if path.is_file())
    _refuse_existing(wanted, [*wanted.names, *map(str, files)])
    earlier = Path(tempfile.mkdtemp(prefix=EARLIER, dir=hidden))
    begun: list[tuple[Path, Path]] = []
    try:
        for source, target in _moves(hidden, files, earlier, wanted):
            target.parent.mkdir(parents=True, exist_ok=True)
            begun.append((source, target))
            source.replace(target)
    except BaseException:
        for source, target in reversed(begun):  # the seal of the new goes first, that of the earlier comes last
            if target.exists() and not source.exists():
                target.replace(source)
        raise
    remember_written()
    with suppress(OSError):  # for nobody's use from here on: were this run killed now, the next may clear it away
        earlier.rename(hidden / "replaced")


def _moves(hidden: Path, files: Collection[Path], earlier: Path, wanted: _Results) -> list[tuple[Path, Path]]:
    """Return what is moved where, in an order in which a seal stands beside the files of its own run alone.

    earlier seal away ─► each other file: earlier one away, new one in ─► what else is left away ─► new seal in
    """
    folder, seal = wanted.folder, None if wanted.seal is None else Path(wanted.seal)
    every = [*files, *sorted(_left_by_earlier_runs(wanted) - set(files))]
    away = {file: (folder / file, earlier / file) for file in every if (folder / file).exists()}
    into = {file: (hidden / file, folder / file) for file in files}
    others = [moves.get(file) for file in every if file != seal for moves in (away, into)]
    first, last = (None, None) if seal is None else (away.get(seal), into.get(seal))
    return [move for move in (first, *others, last) if move is not None]


def _left_by_earlier_runs(wanted: _Results) -> set[Path]:
    """Return the files of sets, and the stale ones where they may be removed, that are in the folder."""
    folder = wanted.folder
    found = {path for pattern in wanted.sets for path in folder.glob(pattern)}
    if wanted.overwrite:
        found |= _stale(wanted)
    return {path.relative_to(folder) for path in found}


def _stale(wanted: _Results) -> set[Path]:
    """Return the stale files that are in the folder and may be removed."""
    found = {path for pattern in wanted.stale for path in wanted.folder.glob(pattern)}
    kept = (*wanted.films, *wanted.spared)
    return {path for path in found if path.is_file() and not path.is_symlink() and not _is_one_of(path, kept)}

"""What is asked of a file before its sound is looked for, and how what is wrong with it is told."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ..errors import SoundtrackError


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Put the file's name before what is wrong with it."""
    try:
        yield
    except SoundtrackError as error:
        raise SoundtrackError(f"{path}: {error}") from error


def require_file(path: Path) -> None:
    """Raise SoundtrackError where a path is not that of a file with something in it that may be read."""
    try:
        str(path).encode("utf-8")  # what the libraries that open sound expect of a name
    except UnicodeEncodeError as error:
        raise SoundtrackError("the name is not valid UTF-8; rename the file") from error
    try:
        if path.is_dir():
            raise SoundtrackError("is a folder; expected an audio file or a film")
        if not path.exists():
            raise SoundtrackError("no such file")
        if not path.is_file():
            raise SoundtrackError("is not a regular file")
        if path.stat().st_size == 0:
            raise SoundtrackError("is empty (0 bytes)")
        path.open("rb").close()
    except OSError as error:
        if isinstance(error, SoundtrackError):
            raise
        raise SoundtrackError(f"cannot be read: {error.strerror}") from error


@dataclass(frozen=True)
class FileState:
    """Which file a path names, and what tells that somebody writes to it."""

    device: int
    inode: int
    bytes: int
    changed_ns: int


def file_state(path: Path) -> FileState:
    """Return what a path names now; SoundtrackError where that is nothing any more."""
    try:
        found = path.stat()
    except OSError as error:
        raise SoundtrackError(f"is gone while it is read: {error.strerror}") from error
    return FileState(found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns)


def require_unchanged(path: Path, opened: FileState | None) -> None:
    """Raise SoundtrackError where a path no longer names what was opened: the sound heard would not be the file's."""
    if opened is None:
        return
    now = file_state(path)
    if now != opened:
        sizes = "as long as before" if now.bytes == opened.bytes else f"{opened.bytes} bytes before, {now.bytes} now"
        raise SoundtrackError(f"was changed while it is read ({sizes}); expected a finished file")

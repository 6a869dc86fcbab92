"""Of several runs into one folder only one at a time moves its files; a run that was killed there hinders none.

A folder that is made for it is a lock on every system; where the system has locks that end with their process, it is
held by one of these as well, which tells a run that still moves its files from one that is gone.
"""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .abandoned import LOCK, hold
from .errors import OutputError

_LONGEST_WAIT_S = 20.0
"""Moving takes milliseconds: so long after its start, who does not hold the lock is gone."""


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Let no other run move its files into the folder meanwhile; OutputError where one does not come to its end."""
    lock, until_s = folder / LOCK, time.monotonic() + _LONGEST_WAIT_S
    while True:
        try:
            lock.mkdir()
            held = hold(lock)
            break
        except FileExistsError:
            if _cleared(lock):
                continue
            if time.monotonic() > until_s:
                raise _locked(lock) from None
            time.sleep(0.01)
        except OSError as error:
            raise OutputError(f"{folder}: cannot write here: {error.strerror}") from error
    try:
        yield
    finally:
        lock.rmdir()
        if held is not None:
            os.close(held)


def refuse_locked(folder: Path) -> None:
    """Raise OutputError where moving never ended and its run may still live: better now than after all the work."""
    lock = folder / LOCK
    if _is_old(lock) and not _cleared(lock):
        raise _locked(lock)


def _cleared(lock: Path) -> bool:
    """Remove the lock of a run that was killed and return whether it was one."""
    held = hold(lock) if _is_old(lock) else None
    if held is None:
        return False
    try:
        there, ours = lock.stat(), os.fstat(held)
        if (there.st_dev, there.st_ino) != (ours.st_dev, ours.st_ino):
            return False  # another run has cleared it, and this one is the lock of a third
        lock.rmdir()
    except OSError:
        return False
    finally:
        os.close(held)
    return True


def _is_old(lock: Path) -> bool:
    """Return whether a lock is there and so old that moving must have come to its end."""
    try:
        return time.time() - lock.stat().st_mtime > _LONGEST_WAIT_S
    except OSError:
        return False


def _locked(lock: Path) -> OutputError:
    return OutputError(f"{lock}: another run is writing here; remove it where that is not so")

"""Hidden folders of runs: each is locked while its run lives, and cleared by the next one after a run was killed."""

import os
import shutil
import tempfile
from pathlib import Path

HIDDEN, EARLIER = ".blastline-", "earlier-"
"""How the name of a run's hidden folder begins, and in it that of one which keeps the files that are being replaced."""

LOCK = f"{HIDDEN}moving"
"""The folder that says that a run is moving its files."""


def hold(hidden: Path, *, wait: bool = False) -> int | None:
    """Return an open descriptor of a hidden folder that locks it until it is closed or its process ends.

    None where another run holds it, unless that is waited for, or where the system has no such locks.
    """
    try:
        import fcntl
    except ImportError:
        return None
    try:
        descriptor = os.open(hidden, os.O_RDONLY)
    except OSError:
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:
        os.close(descriptor)
        return None
    return descriptor


def held_folder(folder: Path) -> tuple[Path, int | None]:
    """Make a hidden folder and hold it; return it with what `hold` returned.

    A folder that is not held yet looks abandoned: another run may clear it at that very moment, and it is made anew.
    """
    while True:
        hidden = Path(tempfile.mkdtemp(prefix=HIDDEN, dir=folder))
        held = hold(hidden, wait=True)
        if hidden.exists():
            return hidden, held
        if held is not None:
            os.close(held)


def clear_abandoned(folder: Path) -> None:
    """Remove what runs that were killed left half-written; but not where that holds files of an earlier result."""
    for left in folder.glob(f"{HIDDEN}*"):
        held = hold(left) if left.name != LOCK else None
        if held is None:
            continue
        try:
            if not keeps_earlier(left):
                shutil.rmtree(left, ignore_errors=True)
        finally:
            os.close(held)


def keeps_earlier(hidden: Path) -> bool:
    """Return whether a hidden folder holds files of an earlier result that were to be replaced and are nowhere else."""
    return any(path.is_file() for kept in hidden.glob(f"{EARLIER}*") for path in kept.rglob("*"))

"""Hidden folders of runs: each is locked while its run lives, and cleared by the next one after a run was killed."""

import os
import shutil
import time
from pathlib import Path

HIDDEN, EARLIER = ".blastline-", "earlier-"
"""How the name of a run's hidden folder begins, and in it that of one which keeps the files that are being replaced."""

LOCK = f"{HIDDEN}moving"
"""The folder that says that a run is moving its files."""

_YOUNG_S = 20.0  # a folder is made a moment before it is locked


def hold(hidden: Path) -> int | None:
    """Return an open descriptor of a hidden folder that locks it until it is closed or its process ends.

    None where another run holds it, or where the system has no such locks.
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
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        return None
    return descriptor


def clear_abandoned(folder: Path) -> None:
    """Remove what runs that were killed left half-written; but not where that holds files of an earlier result."""
    for left in folder.glob(f"{HIDDEN}*"):
        try:
            young = time.time() - left.stat().st_mtime < _YOUNG_S
        except OSError:  # its own run has just removed it
            continue
        if young or left.name == LOCK or any(left.glob(f"{EARLIER}*")):
            continue
        held = hold(left)
        if held is not None:
            shutil.rmtree(left, ignore_errors=True)
            os.close(held)

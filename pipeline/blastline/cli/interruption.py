"""What becomes of an interruption, also of one that comes while the command is still being loaded."""

import sys
from contextlib import suppress

from ..interruption import has_written

INTERRUPTED = 130


def told_interrupted() -> int:
    """Say that the run was interrupted and return its exit code."""
    # Python remembers an interruption inside any exec, which imports use, although it was caught, and would end by the
    # signal instead of our exit code; the next exec makes it forget
    exec("")
    if sys.stderr is not None:
        with suppress(OSError):  # where nobody can be told, the exit code still tells
            written = "all results had been written" if has_written() else "nothing was written"
            sys.stderr.write(f"blastline: interrupted; {written}\n")
    return INTERRUPTED

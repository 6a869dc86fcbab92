"""The command `blastline`: arguments, progress and exit codes."""

import os

from .interruption import told_interrupted

# The scan's matrix products are small: more threads cost more CPU than they save time. Read when numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

try:
    from .app import app, main
except KeyboardInterrupt:  # main, which tells it otherwise, is not there yet
    raise SystemExit(told_interrupted()) from None

__all__ = ["app", "main"]

"""The command `blastline`: arguments, progress and exit codes."""

import os

# The scan's matrix products are small: more threads cost more CPU than they save time. Read when numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from .app import app, main

__all__ = ["app", "main"]

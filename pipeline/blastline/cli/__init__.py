"""The command `blastline`: arguments, progress and exit codes."""

from .app import app, main

__all__ = ["app", "main"]

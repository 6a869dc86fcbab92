"""What the files of a result are called, and where its timeline is."""

from pathlib import Path

DRIVE, TIMELINE, REPORT = "drive.wav", "timeline.json", "report.html"
EVENTS, STRETCHES = "conform.csv", "stretches.csv"
TABLES = (EVENTS, STRETCHES)
"""What `conform` writes beside a timeline: how its shots came to this cut from another one."""


def timeline_of(result: Path) -> Path:
    """Return the timeline's file of a result that is given as its folder or as that file."""
    return result / TIMELINE if result.is_dir() else result

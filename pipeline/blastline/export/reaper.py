"""REAPER: the table that its Region/Marker Manager imports."""

import csv
from fractions import Fraction
from pathlib import Path

from ..model import Timeline
from ..timecode import clock_text
from .order import with_ends
from .words import label


def write_reaper(timeline: Timeline, path: Path) -> None:
    """Write a region per event, from its onset to the next one's or to the end of its window, as h:mm:ss.

    The project's ruler must show minutes and seconds, and the film's sound must start at 0. Nine decimals place a
    region to the sample at every rate.
    """
    rate_hz = timeline.source.sample_rate_hz
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["#", "Name", "Start", "End", "Length"])
        for number, (event, stop) in enumerate(with_ends(timeline), start=1):
            times = (Fraction(samples, rate_hz) for samples in (event.onset_sample, stop, stop - event.onset_sample))
            # one digit of hours and nine decimals: REAPER cannot take it for bars and beats
            table.writerow([f"R{number}", label(event), *(clock_text(time, 9, hour_digits=1) for time in times)])

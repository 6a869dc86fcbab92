"""REAPER: the table that its Region/Marker Manager imports."""

import csv
from pathlib import Path

from ..model import Timeline
from .words import label


def write_reaper(timeline: Timeline, path: Path) -> None:
    """Write a region per event, from its onset to the next one's or to the end of its window, in seconds.

    The project's ruler must show seconds, and the film's sound must start at 0. Nine decimals place a region to the
    sample at every rate.
    """
    rate_hz = timeline.source.sample_rate_hz
    events = sorted(timeline.events, key=lambda event: event.onset_sample)
    following = [*(event.onset_sample for event in events[1:]), None]
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["#", "Name", "Start", "End", "Length"])
        for number, (event, after) in enumerate(zip(events, following, strict=True), start=1):
            stop = max(event.onset_sample, event.window.stop)
            if after is not None:
                stop = max(event.onset_sample, min(stop, after))
            times = (event.onset_sample, stop, stop - event.onset_sample)
            table.writerow([f"R{number}", label(event), *(f"{samples / rate_hz:.9f}" for samples in times)])

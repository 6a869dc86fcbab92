"""REAPER: the table that its Region/Marker Manager imports."""

import csv
from pathlib import Path

from ..model import Timeline
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
            times = (event.onset_sample, stop, stop - event.onset_sample)
            table.writerow([f"R{number}", label(event), *(_clock(samples, rate_hz) for samples in times)])


def _clock(samples: int, rate_hz: int) -> str:
    """Return samples from the start as h:mm:ss with nine decimals; REAPER cannot take it for bars and beats."""
    billionths = (2_000_000_000 * samples + rate_hz) // (2 * rate_hz)
    whole, fraction = divmod(billionths, 1_000_000_000)
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}.{fraction:09}"

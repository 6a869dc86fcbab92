"""A film of four shots, its result, and what edits of that come to when they are rendered."""

import csv
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import soundfile
from numpy.typing import NDArray

from blastline.export import read_timeline
from blastline.model import Event, Timeline
from commands import RATE_HZ, Ended, blastline, write_film

SHOTS_S = (1.0, 2.5, 4.0, 4.1)
LENGTH_S = 7.0
FRAMES = round(LENGTH_S * RATE_HZ)
GUARD, FADE_IN = RATE_HZ // 1000, 5 * RATE_HZ // 1000

Row = dict[str, str]


def edited_film(folder: Path) -> Path:
    """Write the film and return it."""
    return write_film(folder / "film.wav", length_s=LENGTH_S, shots_s=SHOTS_S)


def first_result(folder: Path, film: Path) -> Path:
    """Return a folder whose timeline has exactly the film's four shots, the last two in one window."""
    out = folder / "out"
    rows = "".join(f"{round(shot_s * RATE_HZ)}\n" for shot_s in SHOTS_S)
    (folder / "first.csv").write_text(f"onset_sample\n{rows}")
    ended = blastline("render", film, "-o", out, "--timeline", folder / "first.csv", "--no-report")
    assert ended.code == 0, ended
    assert blastline("export", out / "timeline.json", "--format", "audacity,reaper", "-o", out).code == 0
    return out


def edited(result: Path, folder: Path, edit: Callable[[list[Row]], object]) -> Path:
    """Return a copy of the result's table, edited, with the original timeline beside it."""
    with (result / "timeline.csv").open(newline="") as text:
        rows = list(csv.DictReader(text))
    columns = list(rows[0])
    edit(rows)
    (folder / "timeline.json").write_bytes((result / "timeline.json").read_bytes())
    with (folder / "edited.csv").open("w", newline="") as text:
        table = csv.DictWriter(text, columns)
        table.writeheader()
        table.writerows(rows)
    return folder / "edited.csv"


def rendered(film: Path, file: Path, *more: str | Path) -> tuple[Ended, Timeline, NDArray[np.int32]]:
    """Render an edited timeline and return how that ended, the new timeline and the drive."""
    out = file.parent / "out"
    ended = blastline("render", film, "-o", out, "--timeline", file, "--no-report", "--overwrite", *more)
    assert ended.code == 0, ended
    return ended, read_timeline(out / "timeline.json"), soundfile.read(out / "drive.wav", dtype="int32")[0]


def by_id(timeline: Timeline) -> Mapping[str, Event]:
    """Return the events of a timeline by id."""
    return {event.id: event for event in timeline.events}


def felt_db(event: Event) -> float:
    """Return the level of what an event lets feel, against direct conversion."""
    assert event.drive is not None
    return event.drive.perceived_gain_db


def moving(drive: NDArray[np.int32], windows: list[tuple[int, int]]) -> None:
    """Assert that the drive is exactly 0 outside windows and moves in each."""
    outside = np.ones(drive.size, bool)
    for start, stop in windows:
        outside[start:stop] = False
        assert np.any(drive[start:stop])
    assert not np.any(drive[outside])

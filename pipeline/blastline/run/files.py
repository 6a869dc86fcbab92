"""Making files from files: a timeline in other formats, a scene's sound."""

from collections.abc import Callable, Collection, Iterable
from pathlib import Path

from .. import synth
from ..export import (
    FORMATS,
    export_timeline,
    known_formats,
    read_timeline,
    refuse_without_frames,
    resolution,
    rounding,
)
from ..model import Timeline
from ..report import ExportRow
from ..staging import staged
from ..timebase import AS_FILMED, Timebase, retimed
from .progress import Progress, no_progress


def export(
    timeline: Path,
    folder: Path,
    *,
    formats: Iterable[str],
    timebase: Timebase = AS_FILMED,
    overwrite: bool = False,
    tell: Callable[[str], None] | None = None,
) -> list[Path]:
    """Write a timeline in other formats into `folder` and return the files.

    `timebase` is what the user says about the film's timecode; `tell` is called with each line of `export.rounding`.
    Raises BlastlineError for a timeline, format, time base or folder that cannot be used; nothing is written then.
    """
    chosen = known_formats(formats)
    read = retimed(read_timeline(timeline), timebase)
    refuse_without_frames([known.name for known in chosen], read.source)
    names = [known.file_name for known in chosen]
    with staged(folder, names=names, overwrite=overwrite) as hidden:
        export_timeline(read, hidden, formats=[known.name for known in chosen])
    if tell is not None:
        for line in roundings(read, [known.name for known in chosen]):
            tell(line)
    return [folder / name for name in names]


def roundings(timeline: Timeline, formats: Iterable[str]) -> tuple[str, ...]:
    """Return a line for each way in which the formats round times, with the event that moves farthest."""
    return rounding(timeline, formats)


def exports(*, written: Collection[str] = ()) -> tuple[ExportRow, ...]:
    """Return every format: its file, the tool that opens it and how, how exact its times are, whether it is written."""
    rows = []
    for known in FORMATS.values():
        tool, _, how = known.tool.partition(": ")
        rows.append(ExportRow(known.name, known.file_name, tool, how, resolution(known.name), known.name in written))
    return tuple(rows)


def synthesise(
    scene_file: Path, folder: Path, *, overwrite: bool = False, progress: Progress = no_progress
) -> list[Path]:
    """Make the film-like scene of a TOML file: its sound and its truth; return the files.

    Raises BlastlineError for a scene or folder that cannot be used; nothing is written then.
    """
    progress("synthesising", 0, None)
    truth = synth.synthesise(scene_file, folder, overwrite=overwrite)
    return [folder / f"{truth.scene}.wav", folder / f"{truth.scene}.truth.json"]

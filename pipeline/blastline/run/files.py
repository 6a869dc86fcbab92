"""Making files from files: a timeline in other formats, a scene's sound."""

from collections.abc import Iterable
from pathlib import Path

from .. import synth
from ..export import (
    export_timeline,
    known_formats,
    read_timeline,
    require_frame_rate,
    rounding,
)
from ..staging import staged
from ..timebase import AS_FILMED, Timebase, retimed
from .progress import Note, Progress, no_note, no_progress


def export(
    timeline: Path,
    folder: Path,
    *,
    formats: Iterable[str],
    timebase: Timebase = AS_FILMED,
    overwrite: bool = False,
    note: Note = no_note,
) -> list[Path]:
    """Write a timeline in other formats into `folder` and return the files.

    `timebase` is what the user says about the film's timecode; `note` is told what rounding moves.
    Raises BlastlineError for a timeline, format, time base or folder that cannot be used; nothing is written then.
    """
    chosen = known_formats(formats)
    read = retimed(read_timeline(timeline), timebase)
    require_frame_rate([known.name for known in chosen], read.source)
    names = [known.file_name for known in chosen]
    with staged(folder, names=names, overwrite=overwrite) as hidden:
        export_timeline(read, hidden, formats=[known.name for known in chosen])
    for line in rounding(read, [known.name for known in chosen]):
        note(line)
    return [folder / name for name in names]


def synthesise(
    scene_file: Path, folder: Path, *, overwrite: bool = False, progress: Progress = no_progress
) -> list[Path]:
    """Make the film-like scene of a TOML file: its sound and its truth; return the files.

    Raises BlastlineError for a scene or folder that cannot be used; nothing is written then.
    """
    progress("synthesising", 0, None)
    truth = synth.synthesise(scene_file, folder, overwrite=overwrite)
    return [folder / f"{truth.scene}.wav", folder / f"{truth.scene}.truth.json"]

"""Making files from files: a timeline in other formats, a scene's sound."""

from collections.abc import Iterable
from pathlib import Path

from .. import synth
from ..export import export_timeline, known_formats, read_timeline
from ..staging import staged
from .progress import Progress, no_progress


def export(timeline: Path, folder: Path, *, formats: Iterable[str], overwrite: bool = False) -> list[Path]:
    """Write a timeline in other formats into `folder` and return the files.

    Raises BlastlineError for a timeline, format or folder that cannot be used; nothing is written then.
    """
    read = read_timeline(timeline)
    chosen = known_formats(formats)
    names = [known.file_name for known in chosen]
    with staged(folder, names=names, overwrite=overwrite) as hidden:
        export_timeline(read, hidden, formats=[known.name for known in chosen])
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

"""Making a film-like scene: its sound and its truth."""

from pathlib import Path

from .. import synth
from ..progress import Progress, no_progress


def synthesise(
    scene_file: Path, folder: Path, *, overwrite: bool = False, progress: Progress = no_progress
) -> list[Path]:
    """Make the film-like scene of a TOML file: its sound and its truth; return the files.

    Raises BlastlineError for a scene or folder that cannot be used; nothing is written then.
    """
    progress("synthesising", 0, None)
    truth = synth.synthesise(scene_file, folder, overwrite=overwrite)
    return [folder / f"{truth.scene}.wav", folder / f"{truth.scene}.truth.json"]

"""`synth`."""

from pathlib import Path
from typing import Annotated

import typer

from .options import Overwrite, Quiet, ResultFolder
from .progress import shown_progress


def synth(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene description (.toml).", show_default=False)],
    folder: ResultFolder,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
) -> None:
    """Make a film-like test scene, its sound and the exact truth about its shots; prints each file's name.

    Example: `blastline synth fixtures/demo.toml -o build/demo`
    """
    from .. import run

    with shown_progress(quiet=quiet) as progress:
        files = run.synthesise(scene, folder, overwrite=overwrite, progress=progress)
    for file in files:
        typer.echo(file)

"""`synth`."""

from pathlib import Path
from typing import Annotated

import typer

from .options import WRITING, Overwrite, Quiet
from .progress import shown_progress


def synth(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene description (.toml).", show_default=False)],
    folder: Annotated[
        Path,
        typer.Option("-o", "--output", metavar="DIR", help="Folder for the files.", rich_help_panel=WRITING),
    ],
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

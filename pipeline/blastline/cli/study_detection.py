"""`study detection`."""

import tempfile
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from .options import Overwrite, QualityOption, RulesOption
from .progress import shown_progress
from .study_figures import as_json, figures_file
from .study_options import (
    CORES,
    Clips,
    Corpus,
    Films,
    Fixtures,
    Fold,
    Jobs,
    MixLevels,
    NoProgress,
    Peers,
    RandomFilms,
    Seed,
    source_of,
)
from .study_tables import detection_table
from .values import results_folder


def detection(
    fixtures: Fixtures = None,
    random: RandomFilms = 0,
    corpus: Corpus = None,
    mix: MixLevels = None,
    clips: Clips = False,
    fold: Fold = None,
    films: Films = 24,
    seed: Seed = 1,
    quality: QualityOption = "standard",
    rules: RulesOption = None,
    peers: Peers = False,
    excerpts: Annotated[
        Path | None,
        typer.Option(
            "--excerpts",
            metavar="DIR",
            parser=results_folder,
            help="Write what was missed and what was false: events.csv, and a WAV of each.",
        ),
    ] = None,
    jobs: Jobs = CORES,
    overwrite: Overwrite = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write every figure, film by film, as JSON.")
    ] = None,
    quiet: NoProgress = False,
) -> None:
    """Find the shots of scenes or recordings whose truth is known, and say how many were found, and how exactly.

    Example: `blastline study detection --fixtures fixtures`

    Your own: `blastline study detection --corpus my-recordings --mix 6,30 --excerpts wrong`
    """
    from ..staging import require_utf_8, staged
    from ..study.detection import study_detection
    from ..study.events import EVENTS, EXCERPTS, write_events

    source = source_of(fixtures, corpus, mix, clips=clips, fold=fold, random=random, films=films, seed=seed)
    if excerpts is not None:
        require_utf_8(excerpts)
    with (
        figures_file(output, overwrite=overwrite) as write,
        tempfile.TemporaryDirectory(prefix="blastline-") as made,
        shown_progress(quiet=quiet) as progress,
    ):
        listen = partial(
            study_detection, source, Path(made), quality, rules, with_peers=peers, jobs=jobs, progress=progress
        )
        if excerpts is None:
            study, _ = listen()
        else:
            with staged(excerpts, names=[EVENTS], sets=EXCERPTS, overwrite=overwrite) as hidden:
                study, paths = listen()
                write_events(hidden, [(path, case.events) for path, case in zip(paths, study.cases, strict=True)])
        write(as_json(study))
    typer.echo(detection_table(study))

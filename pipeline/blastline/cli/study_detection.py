"""`study detection`, and the options that say what the studies of detection listen to."""

import os
import tempfile
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import RuleError
from .figures import as_json, figures_file
from .options import MESSAGES, Overwrite, QualityOption, RulesOption
from .progress import shown_progress
from .studied import detection_table

if TYPE_CHECKING:
    from ..study.mixes import Levels
    from ..study.sources import StudySource

LISTENING = "What to listen to"

Fixtures = Annotated[
    Path | None,
    typer.Option(
        "--fixtures",
        metavar="DIR",
        help="Scenes (*.toml); synthesised, then listened to.",
        rich_help_panel=LISTENING,
        show_default=False,
    ),
]
RandomFilms = Annotated[
    int,
    typer.Option(
        "--random",
        min=0,
        metavar="N",
        help="Random film-like scenes of a minute, one in four without a gun, that no training has heard.",
        rich_help_panel=LISTENING,
    ),
]
Corpus = Annotated[
    list[Path] | None,
    typer.Option(
        "--corpus",
        metavar="DIR",
        help="Recordings with an annotations.csv; repeatable.",
        rich_help_panel=LISTENING,
        show_default=False,
    ),
]
MixLevels = Annotated[
    str | None,
    typer.Option(
        "--mix",
        metavar="[rms:]LOW,HIGH",
        help="Mix the corpora's shots and other sounds over their beds, peaks (or rms) so many dB over the bed's rms.",
        rich_help_panel=LISTENING,
        show_default=False,
    ),
]
Clips = Annotated[
    bool,
    typer.Option(
        "--clips",
        help="Clips of 30 s, half of them with one shot of the corpora at -6, 0 or 6 dB, as in DCASE 2017.",
        rich_help_panel=LISTENING,
    ),
]
Fold = Annotated[
    int | None,
    typer.Option(
        min=0,
        max=3,
        metavar="N",
        help="Of the corpora only the sources that `study.train --hold-out N` on the same ones does not learn from.",
        rich_help_panel=LISTENING,
        show_default=False,
    ),
]
Films = Annotated[int, typer.Option(min=1, metavar="N", help="How many mixes or clips.", rich_help_panel=LISTENING)]
Seed = Annotated[
    int, typer.Option(min=0, metavar="N", help="Which random films, mixes or clips.", rich_help_panel=LISTENING)
]
Peers = Annotated[
    bool,
    typer.Option("--peers", "--peer", help="Score other onset detectors, those that are installed, on the same films."),
]
Jobs = Annotated[
    int,
    typer.Option(
        "--jobs",
        "-j",
        min=1,
        metavar="N",
        help="Measure so many films at once.",
        show_default="one for each core",
    ),
]
CORES = os.cpu_count() or 1
NoProgress = Annotated[bool, typer.Option("--quiet", "-q", help="Show no progress.", rich_help_panel=MESSAGES)]


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
            "--excerpts", metavar="DIR", help="Write what was missed and what was false: events.csv, and a WAV of each."
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


def source_of(
    fixtures: Path | None,
    corpus: list[Path] | None,
    mix: str | None,
    *,
    clips: bool,
    fold: int | None,
    random: int,
    films: int,
    seed: int,
) -> "StudySource":
    """Return what the options ask to listen to; RuleError for levels that are none."""
    from ..study.sources import StudySource

    levels = None if mix is None else _levels(mix)
    return StudySource(
        fixtures, tuple(corpus or ()), levels, clips=clips, fold=fold, random=random, films=films, seed=seed
    )


def _levels(text: str) -> "Levels":
    """Return the lowest and the highest level of an option such as 6,30 or rms:6,30."""
    from ..study.mixes import Levels

    try:
        low, high = (float(part) for part in text.removeprefix("rms:").split(","))
    except ValueError as error:
        raise RuleError(f"--mix {text}: expected two levels in dB, such as 6,30 or rms:6,30") from error
    if not -60.0 <= low <= high <= 80.0:
        raise RuleError(f"--mix {text}: expected the lower level first, both between -60 and 80 dB")
    return Levels(low, high, "rms" if text.startswith("rms:") else "peak")

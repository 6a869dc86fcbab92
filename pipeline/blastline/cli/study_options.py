"""Options that several studies share: what they listen to, and how."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import RuleError
from .options import MESSAGES

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
    typer.Option("--peers", help="Score other onset detectors, those that are installed, on the same films."),
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

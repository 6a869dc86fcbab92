"""`study pareto`."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..plurals import counted
from ..ruleset import DEFAULT_ACTUATOR
from .options import ActuatorOption, Overwrite, ResultFolder, RulesOption
from .progress import shown_progress
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

if TYPE_CHECKING:
    from ..study.pareto import ParetoStudy
    from ..study.peer_scores import PeerScore
    from ..study.tally import DetectionScore


OwnChanges = Annotated[
    list[str] | None,
    typer.Option(
        "--try",
        metavar="TABLE.KEY=VALUE",
        help="Another change of the standard tier to measure, such as verify.look_from=0.2; repeatable.",
        show_default=False,
    ),
]
WithRendering = Annotated[bool, typer.Option("--rendering/--no-rendering", help="Measure the drives as well.")]
Repeats = Annotated[
    int, typer.Option(min=1, max=9, metavar="N", help="Listen so often to each film; the least processor time counts.")
]


def pareto(
    folder: ResultFolder,
    fixtures: Fixtures = None,
    random: RandomFilms = 0,
    corpus: Corpus = None,
    mix: MixLevels = None,
    clips: Clips = False,
    fold: Fold = None,
    films: Films = 24,
    seed: Seed = 1,
    own: OwnChanges = None,
    peers: Peers = False,
    rendering: WithRendering = True,
    repeats: Repeats = 1,
    actuator: ActuatorOption = DEFAULT_ACTUATOR,
    rules: RulesOption = None,
    jobs: Jobs = CORES,
    overwrite: Overwrite = False,
    quiet: NoProgress = False,
) -> int:
    """Measure accuracy against cost: all tiers, single changes of them, and peers, on the same films in one run.

    Writes every figure (pareto.json, pareto.csv), the fronts as a picture (pareto.svg) and tables (pareto.md).
    Without --fixtures, --random and --corpus it listens to the scenes in ./fixtures.

    Exit code 1 where the tiers do not lie on the front, in order and well apart.

    Example: `blastline study pareto --fixtures fixtures --peers -o build/study`
    """
    from ..staging import staged
    from ..study.pareto import study_pareto
    from ..study.pareto_files import FILES, write_pareto

    scenes = Path("fixtures") if fixtures is None and not corpus and not random else fixtures
    source = source_of(scenes, corpus, mix, clips=clips, fold=fold, random=random, films=films, seed=seed)
    with staged(folder, names=FILES, overwrite=overwrite) as hidden, shown_progress(quiet=quiet) as progress:
        study = study_pareto(
            source,
            rules=rules,
            actuator=actuator,
            own=own or (),
            with_peers=peers,
            with_rendering=rendering,
            repeats=repeats,
            jobs=jobs,
            progress=progress,
        )
        write_pareto(hidden, study)
    typer.echo(pareto_table(study))
    return 0 if all(bar.met for bar in study.bars) else 1


def pareto_table(study: "ParetoStudy") -> str:
    """Return a row for each setting, peer and drive, with a star where it lies on the front, and the bars."""
    shots, minutes = study.detection[0].shots, study.detection[0].minutes
    lines = [
        f"{study.protocol}: {counted(shots, 'shot')} in {minutes:.1f} min; "
        "* nothing else beats it in both cost and F1 at 10 ms",
        "",
        f"{'detection':<40} {'read':>6} {'s/h':>7} {'2 ms':>6} {'10 ms':>6} {'50 ms':>6} {'95 %':>12} {'prec.':>6} "
        f"{'recall':>6} {'burst':>6} {'false/h':>8}",
        *(_detection_row(score, study.on_front) for score in study.detection),
        *(_row(peer, study.on_front, peer.f1_interval.low, peer.f1_interval.high) for peer in study.peers),
    ]
    if study.absent:
        lines.append(f"not installed: {', '.join(study.absent)}")
    memory = ", ".join(f"{name} {most:.0f} MB" for name, most in study.peak_memory_mb.items() if most is not None)
    lines += [f"memory at most: {memory}"] if memory else []
    if study.rendering is not None:
        weak, shots, seconds = study.rendering.weak, study.rendering.shots, study.rendering.window_s
        lines += [
            "",
            f"{weak} of {shots} shots are weak; {seconds:.0f} s of windows; lost: energy not felt as heard",
            f"{'rendering':<40} {'read':>6} {'s/h':>7} {'s/s':>7} {'ratio':>6} {'corr':>6} {'lost, %':>8} "
            f"{'above best':>11}",
        ]
        for point in study.rendering.points:
            lines.append(
                f"{_name(point.name, study.rendering_on_front)} {point.cost.times_read:6.1f} "
                f"{point.cost.cpu_s_per_hour:7.1f} {point.cpu_s_per_window_s:7.4f} {point.ratio:6.3f} "
                f"{point.correlation:6.3f} {100.0 * point.lost:8.3f} {point.above_best:11.2e}"
            )
    elif study.rendering_asked:
        lines += [
            "",
            "rendering: none of these shots is weak in direct conversion, so that no drive is better than another",
        ]
    return "\n".join([*lines, "", *map(str, study.bars)])


def _detection_row(score: "DetectionScore", on_front: Sequence[str]) -> str:
    sure, free = score.intervals.f1, score.false_per_gun_free_hour
    burst = f"{score.bursts.recall:6.3f}" if score.bursts else f"{'-':>6}"
    return f"{_row(score, on_front, sure.low, sure.high)} {burst} " + ("       -" if free is None else f"{free:8.1f}")


def _row(score: "DetectionScore | PeerScore", on_front: Sequence[str], low: float, high: float) -> str:
    f1 = " ".join(f"{score.f1_by_window_ms[window]:6.3f}" for window in ("2", "10", "50"))
    return (
        f"{_name(score.name, on_front)} {score.cost.times_read:6.1f} {score.cost.cpu_s_per_hour:7.2f} {f1} "
        f"{low:6.3f}-{high:.3f} {score.precision:6.3f} {score.recall:6.3f}"
    )


def _name(name: str, on_front: Sequence[str]) -> str:
    return f"{'*' if name in on_front else ' '} {name:<38}"

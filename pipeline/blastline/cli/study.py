"""`study segmentation`, `rendering`, `stability` and `conform`, and the group that all studies are in."""

from pathlib import Path
from typing import Annotated

import typer

from ..ruleset import DEFAULT_ACTUATOR
from . import study_detection, study_options, study_pareto
from .options import ActuatorOption, Overwrite, QualityOption, RulesOption
from .progress import shown_progress
from .study_figures import as_json, figures_file
from .study_tables import rendering_table, segmentation_table

group = typer.Typer(help="Measure accuracy on scenes and recordings with a known truth.")


@group.callback()
def describe() -> None:
    """Measure accuracy on scenes and recordings with a known truth."""


group.command()(study_detection.detection)
group.command()(study_pareto.pareto)


@group.command()
def segmentation(
    fixtures: study_options.Fixtures = None,
    random: Annotated[
        int, typer.Option("--random", metavar="N", min=0, help="So many random films of a minute as well.")
    ] = 0,
    seed: Annotated[int, typer.Option(min=0, help="The first film's seed; the others follow.")] = 1,
    quality: QualityOption = "standard",
    rules: RulesOption = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write every figure as JSON.")
    ] = None,
    overwrite: Overwrite = False,
    quiet: study_options.NoProgress = False,
) -> int:
    """Part the shots of synthetic films into blast and reflections, and compare with what is heard in them.

    Exit code 1 where a bar is missed. Example: `blastline study segmentation --fixtures fixtures`
    """
    from itertools import chain

    from ..errors import RuleError
    from ..study.segmentation import random_films, scene_films, score

    if fixtures is None and random == 0:
        raise RuleError("study segmentation: give --fixtures, --random or both")
    made = chain(scene_films(fixtures) if fixtures else (), random_films(range(seed, seed + random)))
    with figures_file(output, overwrite=overwrite) as write, shown_progress(quiet=quiet) as progress:
        result = score(made, quality, rules, progress=progress)
        write(as_json(result))
    typer.echo(segmentation_table(result))
    return 0 if all(bar.met for bar in result.bars) else 1


@group.command()
def rendering(
    fixtures: Annotated[
        Path, typer.Option("--fixtures", metavar="DIR", help="Scenes (*.toml); their true shots are rendered.")
    ],
    quality: QualityOption = "standard",
    actuator: ActuatorOption = DEFAULT_ACTUATOR,
    rules: RulesOption = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write every figure, shot by shot, as JSON.")
    ] = None,
    overwrite: Overwrite = False,
    quiet: study_options.NoProgress = False,
) -> int:
    """Render the shots of scenes in every way there is, say what is felt of them, and whether the bars are met.

    Exit code 1 where one is not. Example: `blastline study rendering --fixtures fixtures`
    """
    from ..study.rendering import score

    with figures_file(output, overwrite=overwrite) as write, shown_progress(quiet=quiet) as progress:
        result = score(fixtures, quality=quality, actuator=actuator, rules=rules, progress=progress)
        write(as_json(result))
    typer.echo(rendering_table(result))
    return 0 if all(bar.met for bar in result.bars) else 1


@group.command()
def stability(
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write every row as JSON as well.")
    ] = None,
    overwrite: Overwrite = False,
) -> int:
    """Measure the numbers at their extremes against independent references; exit code 1 where one misses its bar.

    Example: `blastline study stability`
    """
    from ..study.stability import measure_stability, stability_json

    bars = []
    with figures_file(output, overwrite=overwrite) as write:
        for family, bar in measure_stability():
            bars.append((family, bar))
            typer.echo(f"{family:<12} {bar}")
        write(stability_json(bars))
    missed = sum(not bar.met for _, bar in bars)
    typer.echo(f"\n{len(bars)} rows, {missed} miss their bar")
    return 1 if missed else 0


@group.command()
def conform(
    minutes: Annotated[float, typer.Option(min=1.0, max=60.0, help="Length of the film that is cut anew.")] = 10.0,
    seed: Annotated[int, typer.Option(min=0, help="Which film.")] = 11,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write every figure as JSON.")
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Cut a synthetic film anew in many ways, and say how many shots were found in each new cut, and how exactly.

    Example: `blastline study conform --minutes 5`
    """
    from ..study.conforming import score_all

    scores = []
    with figures_file(output, overwrite=overwrite) as write:
        typer.echo(f"{'new cut':<64} {'shots':>6} {'1 ms':>6} {'lost':>6} {'gone':>6} {'false':>6} {'worst, ms':>10}")
        for each in score_all(seed, minutes):
            scores.append(each)
            worst = f"{each.worst_ms:.4f}" if each.within or each.astray else "-"
            typer.echo(
                f"{each.name:<64} {each.surviving:6d} {each.within:6d} {each.lost:6d} {each.removed:6d} "
                f"{each.false:6d} {worst:>10}"
            )
        write(as_json(scores))

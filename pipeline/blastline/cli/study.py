"""`study detection`, `segmentation`, `rendering`, `stability` and `conform`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .options import ActuatorOption, QualityOption, RulesOption
from .studied import rendering_table, segmentation_table

if TYPE_CHECKING:
    from ..study.detection import DetectionScore

group = typer.Typer(help="Measure accuracy on scenes and recordings with a known truth.")


@group.callback()
def describe() -> None:
    """Measure accuracy on scenes and recordings with a known truth."""


@group.command()
def detection(
    fixtures: Annotated[
        Path | None, typer.Option("--fixtures", metavar="DIR", help="Scenes (*.toml); synthesised, then listened to.")
    ] = None,
    corpus: Annotated[
        list[Path] | None,
        typer.Option("--corpus", metavar="DIR", help="Recordings with an annotations.csv; repeatable."),
    ] = None,
    quality: QualityOption = "standard",
    rules: RulesOption = None,
    peer: Annotated[
        bool, typer.Option("--peer", help="Score librosa's onset detection on the same films as well.")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write every figure, film by film, as JSON.")
    ] = None,
) -> None:
    """Find the shots of scenes or recordings whose truth is known, and say how many were found, and how exactly.

    Example: `blastline study detection --fixtures fixtures`
    """
    import msgspec

    from ..errors import RuleError
    from ..study.detection import WINDOWS_MS, heard, recordings, scenes, score
    from ..study.peers import best_librosa_score

    if (fixtures is None) == (not corpus):
        raise RuleError("study detection: give either --fixtures or --corpus")
    cases = scenes(fixtures) if fixtures else recordings(corpus or [])
    result = score(cases, quality, rules)
    if output:
        output.write_bytes(msgspec.json.format(msgspec.json.encode(result), indent=1) + b"\n")
    typer.echo(_table(result))
    if peer:
        again = scenes(fixtures) if fixtures else recordings(corpus or [])
        best = best_librosa_score(heard(again), WINDOWS_MS, best_at_ms=50.0)
        f1 = ", ".join(f"{counts.f1:.3f} at {window_ms:g} ms" for window_ms, counts in best.counts.items())
        typer.echo(f"librosa at its best threshold ({best.threshold:g}): F1 {f1}")


@group.command()
def segmentation(
    fixtures: Annotated[
        Path | None, typer.Option("--fixtures", metavar="DIR", help="Scenes (*.toml); synthesised, then listened to.")
    ] = None,
    films: Annotated[
        int, typer.Option("--films", metavar="N", min=0, help="So many random films of a minute as well.")
    ] = 0,
    seed: Annotated[int, typer.Option(min=0, help="The first film's seed; the others follow.")] = 1,
    quality: QualityOption = "standard",
    rules: RulesOption = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write every figure as JSON.")
    ] = None,
) -> int:
    """Part the shots of synthetic films into blast and reflections, and compare with what is heard in them.

    Exit code 1 where a bar is missed. Example: `blastline study segmentation --fixtures fixtures`
    """
    from itertools import chain

    import msgspec

    from ..errors import RuleError
    from ..study.segmentation import random_films, scene_films, score

    if fixtures is None and films == 0:
        raise RuleError("study segmentation: give --fixtures, --films or both")
    made = chain(scene_films(fixtures) if fixtures else (), random_films(range(seed, seed + films)))
    result = score(made, quality, rules)
    if output:
        output.write_bytes(msgspec.json.format(msgspec.json.encode(result), indent=1) + b"\n")
    typer.echo(segmentation_table(result))
    return 0 if all(bar.met for bar in result.bars) else 1


@group.command()
def rendering(
    fixtures: Annotated[
        Path, typer.Option("--fixtures", metavar="DIR", help="Scenes (*.toml); their true shots are rendered.")
    ],
    quality: QualityOption = "standard",
    actuator: ActuatorOption = "crowson-t108sm",
    rules: RulesOption = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write every figure, shot by shot, as JSON.")
    ] = None,
) -> int:
    """Render the shots of scenes in every way there is, say what is felt of them, and whether the bars are met.

    Exit code 1 where one is not. Example: `blastline study rendering --fixtures fixtures`
    """
    import msgspec

    from ..study.rendering import score

    result = score(fixtures, quality=quality, actuator=actuator, rules=rules)
    if output:
        output.write_bytes(msgspec.json.format(msgspec.json.encode(result), indent=1) + b"\n")
    typer.echo(rendering_table(result))
    return 0 if all(bar.met for bar in result.bars) else 1


@group.command()
def stability(
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write every row as JSON as well.")
    ] = None,
) -> int:
    """Measure the numbers at their extremes against independent references; exit code 1 where one misses its bar.

    Example: `blastline study stability`
    """
    from ..study.stability import measure_stability, stability_json

    bars = []
    for family, bar in measure_stability():
        bars.append((family, bar))
        typer.echo(f"{family:<12} {bar}")
    if output:
        output.write_bytes(stability_json(bars))
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
) -> None:
    """Cut a synthetic film anew in many ways, and say how many shots were found in each new cut, and how exactly.

    Example: `blastline study conform --minutes 5`
    """
    import msgspec

    from ..study.conforming import score_all

    typer.echo(f"{'new cut':<64} {'shots':>6} {'1 ms':>6} {'lost':>6} {'gone':>6} {'false':>6} {'worst, ms':>10}")
    scores = []
    for each in score_all(seed, minutes):
        scores.append(each)
        typer.echo(
            f"{each.name:<64} {each.surviving:6d} {each.within:6d} {each.lost:6d} {each.removed:6d} {each.false:6d} "
            f"{each.worst_ms:10.4f}"
        )
    if output:
        output.write_bytes(msgspec.json.format(msgspec.json.encode(scores), indent=1) + b"\n")


def _table(score: "DetectionScore") -> str:
    lines = [f"{'film':<40} {'min':>6} {'shots':>6} {'found':>6} {'false':>6} {'missed':>7}"]
    lines += [
        f"{case.name[:40]:<40} {case.minutes:6.2f} {case.hits + case.missed:6d} {case.hits:6d} "
        f"{case.false:6d} {case.missed:7d}"
        for case in score.cases
        if case.hits + case.missed or case.false
    ]
    f1 = ", ".join(f"{value:.3f} at {window} ms" for window, value in score.f1_by_window_ms.items())
    recall = ", ".join(f"{value:.3f} at {level} dB" for level, value in score.recall_by_snr_db.items())
    lines += ["", f"quality {score.quality}: {score.shots} shots in {score.minutes:.1f} min", f"F1      {f1}"]
    lines += [f"at 10 ms: precision {score.precision:.3f}, recall {score.recall:.3f}"]
    lines += [f"recall  {recall}"] if recall else []
    if score.clear_error_median_ms is not None and score.clear_error_p95_ms is not None:
        lines.append(
            f"onset error of clear shots: median {score.clear_error_median_ms:.3f} ms, "
            f"95 % within {score.clear_error_p95_ms:.3f} ms"
        )
    lines.append(f"false events in {score.gun_free_minutes:.1f} gun-free minutes: {score.gun_free_false}")
    return "\n".join(lines)

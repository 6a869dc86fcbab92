"""`rules show` and `rules check`."""

from pathlib import Path
from typing import Annotated

import typer

from ..ruleset import load_conform, load_haptics, load_measuring, load_rules, toml_lines
from .options import QualityOption, RulesOption
from .values import rules_folder

group = typer.Typer(help="The numbers that blastline works with, and yours in their place.")


@group.command()
def show(quality: QualityOption = "standard", rules: RulesOption = None) -> None:
    """Print the rules of a quality, with yours laid over them: what each table's keys do, their values, their source.

    Example: `blastline rules show --quality draft --rules my-rules`
    """
    merged = load_rules(quality, rules)
    typer.echo(f"# digest {merged.digest}")
    tables = {
        f"quality/{quality}": merged.tier,
        "scenes": merged.scenes,
        "align": merged.align,
        "conform": load_conform(rules),
        "haptics": load_haptics(rules),
        "measuring": load_measuring(rules),
    }
    for name, table in tables.items():
        typer.echo(f"\n# {name}.toml")
        for line in toml_lines(table, explained=True):
            typer.echo(line)


@group.command()
def check(
    folder: Annotated[
        Path,
        typer.Argument(metavar="DIR", parser=rules_folder, help="A folder for --rules.", show_default=False),
    ],
) -> None:
    """Read every rule file of a folder and print the name of each that is sound; stops at the first that is not.

    Example: `blastline rules check my-rules`
    """
    from .. import run

    for name in run.check_rules(folder):
        typer.echo(name)

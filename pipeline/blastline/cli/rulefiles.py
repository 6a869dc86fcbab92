"""`rules show` and `rules check`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer

from ..ruleset import check_rules, load_conform, load_haptics, load_measuring, load_rules, to_builtins
from .options import QualityOption, RulesOption

group = typer.Typer(help="The numbers that blastline works with, and yours in their place.")


@group.command()
def show(quality: QualityOption = "standard", rules: RulesOption = None) -> None:
    """Print the rules of a quality, with yours laid over them, each table with its source.

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
        for line in _toml(to_builtins(table)):
            typer.echo(line)


@group.command()
def check(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder for --rules.", show_default=False)],
) -> None:
    """Read every rule file of a folder and print the name of each that is sound; stops at the first that is not.

    Example: `blastline rules check my-rules`
    """
    for name in check_rules(folder):
        typer.echo(name)


def _toml(plain: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of a TOML file: first the keys of the top level, then its tables; TOML has no word for None."""
    for key, value in plain.items():
        if value is not None and not isinstance(value, dict):
            yield f"{key} = {msgspec.json.encode(value).decode()}"
    for key, value in plain.items():
        if isinstance(value, dict):
            yield f"\n[{key}]"
            yield from _toml(value)

"""`actuator list` and `actuator show`."""

from typing import Annotated

import typer

from ..ruleset import actuator_names, load_actuator
from .options import RulesOption

group = typer.Typer(help="Actuator profiles: what a seat does with a drive, and what the skin feels of it.")


@group.command("list")
def list_profiles(rules: RulesOption = None) -> None:
    """Print the names of the profiles, each with where it comes from.

    Example: `blastline actuator list`
    """
    for name in actuator_names(rules):
        profile, _ = load_actuator(name, rules)
        typer.echo(f"{name:<24} {profile.source}")


@group.command()
def show(
    name: Annotated[
        str, typer.Argument(metavar="NAME|FILE", help="A profile's name, or its .toml file.", show_default=False)
    ],
    rules: RulesOption = None,
) -> None:
    """Print what is felt per volt (H) and what the compensator does about it (C), over frequency.

    Example: `blastline actuator show crowson-t108sm`
    """
    from .. import run

    profile, digest = load_actuator(name, rules)
    low, high = profile.lowpass, profile.highpass
    typer.echo(f"name    {profile.name}\nsource  {profile.source}\ndigest  {digest}")
    typer.echo(f"band    {high.corner_hz:g} Hz (order {high.order}) to {low.corner_hz:g} Hz (order {low.order})\n")
    typer.echo(f"{'Hz':>8} {'H dB':>8} {'H deg':>8} {'C dB':>8}")
    for frequency_hz, felt_db, felt_deg, compensator_db in run.actuator_table(name, rules):
        typer.echo(f"{frequency_hz:8.4g} {felt_db:8.2f} {felt_deg:8.1f} {compensator_db:8.2f}")

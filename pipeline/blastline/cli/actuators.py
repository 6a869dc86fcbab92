"""`actuator list`, `show`, `identify` and `fit`."""

from pathlib import Path
from typing import Annotated

import typer

from ..ruleset import actuator_names, load_actuator
from .actuator_summary import say_fitted, say_measured, say_profile
from .options import WRITING, Overwrite, Quiet, RulesOption
from .progress import shown_progress

FITTING, MEASURING = "Fitting", "Recordings"

group = typer.Typer(help="Actuator profiles: what a seat does with a drive, and what the skin feels of it.")

Excitation = Annotated[
    Path, typer.Option(metavar="WAV", help="What was sent to the actuator: noise.", rich_help_panel=MEASURING)
]
Response = Annotated[
    Path, typer.Option(metavar="WAV", help="What an accelerometer made of it.", rich_help_panel=MEASURING)
]
Channel = Annotated[
    int | None,
    typer.Option(
        metavar="N", min=0, help="Its channel, from 0.", show_default="the only one", rich_help_panel=MEASURING
    ),
]
MeasuredTable = Annotated[
    Path | None,
    typer.Option(
        "--csv",
        metavar="CSV",
        help="Write the measured response as well; `actuator fit` reads it.",
        show_default="not written",
        rich_help_panel=WRITING,
    ),
]
Output = Annotated[
    Path,
    typer.Option("-o", "--output", metavar="PROFILE", help="The profile to write (.toml).", rich_help_panel=WRITING),
]
PerceptionOption = Annotated[
    str,
    typer.Option(
        "--perception",
        metavar="NAME|FILE|none",
        help="The skin's threshold: iso-2631-wk, mpeg-psychohaptic, or your table (.csv, .toml); none leaves it out.",
        rich_help_panel=FITTING,
    ),
]
PeakOption = Annotated[
    float | None,
    typer.Option(
        "--peak-db",
        metavar="DB",
        min=-120.0,
        max=120.0,
        help="Level of what is felt of a full-scale drive where it is felt best, against full-scale sound.",
        show_default="as measured",
        rich_help_panel=FITTING,
    ),
]
GainOption = Annotated[
    float | None,
    typer.Option(
        "--largest-gain-db",
        metavar="DB",
        min=6.0,
        max=120.0,
        help="How much more the compensator may gain at its worst frequency than at its best.",
        show_default="60, from the rules",
        rich_help_panel=FITTING,
    ),
]
NameOption = Annotated[
    str | None,
    typer.Option(
        "--name",
        metavar="NAME",
        help="The profile's name.",
        show_default="that of its file",
        rich_help_panel=WRITING,
    ),
]


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
    picture: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Draw Bode plots as well, into a .png, .svg or .pdf file.",
            show_default="no picture",
            rich_help_panel=WRITING,
        ),
    ] = None,
    measured: Annotated[
        Path | None,
        typer.Option(
            metavar="CSV",
            help="The measured response that belongs to it, for the picture.",
            show_default="not drawn",
            rich_help_panel=WRITING,
        ),
    ] = None,
    perception: Annotated[
        str,
        typer.Option(
            metavar="NAME|FILE|none",
            help="The skin's threshold that the profile was fitted with, for the picture: as of `actuator fit`.",
            rich_help_panel=WRITING,
        ),
    ] = "none",
    rules: RulesOption = None,
    overwrite: Overwrite = False,
) -> None:
    """Print what is felt per unit of drive (H) and what the compensator does about it (C), over frequency.

    Example: `blastline actuator show crowson-t108sm --picture bode.png`
    """
    from .. import run

    if picture is None and (measured is not None or perception != "none"):
        raise typer.BadParameter("--measured and --perception are drawn: expected --picture FILE as well")
    profile, digest = run.usable_actuator(name, rules)
    if picture is not None:
        run.draw_bode(name, picture, measured=measured, perception=perception, rules=rules, overwrite=overwrite)
    say_profile(profile, digest, run.actuator_table(profile))


@group.command()
def identify(
    excitation: Excitation,
    response: Response,
    output: Output,
    excitation_channel: Channel = None,
    response_channel: Channel = None,
    csv: MeasuredTable = None,
    perception: PerceptionOption = "none",
    peak_db: PeakOption = None,
    largest_gain_db: GainOption = None,
    name: NameOption = None,
    rules: RulesOption = None,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
) -> None:
    """Measure an actuator from two recordings of one run, and write a profile of it.

    Example: `blastline actuator identify --excitation noise.wav --response seat.wav -o my-seat.toml --csv my-seat.csv`
    """
    from .. import run

    options = run.FitOptions(perception, peak_db, largest_gain_db, name, rules, overwrite)
    with shown_progress(quiet=quiet) as progress:
        made = run.identify_actuator(
            excitation,
            response,
            output=output,
            options=options,
            csv=csv,
            channels=(excitation_channel, response_channel),
            progress=progress,
        )
    for warning in made.warnings:
        typer.echo(f"warning: {warning}", err=True)
    if not quiet:
        say_measured(made)
        say_fitted(made)


@group.command()
def fit(
    measured: Annotated[
        Path,
        typer.Argument(
            metavar="MEASURED",
            help="A response (.csv) with the columns frequency_hz, gain_db and, where known, phase_deg, coherence.",
            show_default=False,
        ),
    ],
    output: Output,
    perception: PerceptionOption = "none",
    peak_db: PeakOption = None,
    largest_gain_db: GainOption = None,
    name: NameOption = None,
    rules: RulesOption = None,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
) -> None:
    """Fit a measured response with the skin's perception, and write a profile of it.

    Example: `blastline actuator fit my-seat.csv -o my-seat.toml --perception mpeg-psychohaptic`
    """
    from .. import run

    options = run.FitOptions(perception, peak_db, largest_gain_db, name, rules, overwrite)
    with shown_progress(quiet=quiet) as progress:
        made = run.fit_actuator(measured, output, options=options, progress=progress)
    for warning in made.warnings:
        typer.echo(f"warning: {warning}", err=True)
    if not quiet:
        say_fitted(made)

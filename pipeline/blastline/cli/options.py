"""Arguments and options that several commands share, with their help."""

from pathlib import Path
from typing import Annotated

import typer

from ..model import Background, DriveChoice, Phase, Quality
from ..timebase import rates_text
from .values import edited_by_name, film_file, result_by_name, results_folder, rules_folder

FINDING, DRIVING, TIMECODE = "Finding shots", "Making the drive", "The film's timecode"
WRITING, MESSAGES, RULES = "Results", "Messages", "Rules"


Film = Annotated[
    Path, typer.Argument(metavar="INPUT", parser=film_file, help="A film or a sound file.", show_default=False)
]
QualityOption = Annotated[
    Quality,
    typer.Option("--quality", help="How much time to spend on accuracy.", rich_help_panel=FINDING),
]
QualityOrBudget = Annotated[
    Quality | None,
    typer.Option(
        "--quality", help="How much time to spend on accuracy.", show_default="standard", rich_help_panel=FINDING
    ),
]
BudgetOption = Annotated[
    str | None,
    typer.Option(
        "--budget",
        metavar="TIME",
        help="CPU time to spend on the film, such as 90s, 2min or 1.5h: takes the most accurate quality that fits.",
        show_default=False,
        rich_help_panel=FINDING,
    ),
]
MaxCostOption = Annotated[
    float | None,
    typer.Option(
        "--max-cost",
        metavar="X",
        help="The same as CPU seconds per second of film.",
        show_default=False,
        rich_help_panel=FINDING,
    ),
]
RulesOption = Annotated[
    Path | None,
    typer.Option(
        "--rules",
        metavar="DIR",
        parser=rules_folder,
        help="A folder with rule files of your own; what they do not name stays as built in.",
        show_default="built-in rules",
        rich_help_panel=RULES,
    ),
]
Mix = Annotated[
    str,
    typer.Option(
        metavar="MIX",
        help="Which channels drive: mains (all but the LFE), lfe, center, all, or their numbers from 0: 0,1. "
        "The same are listened to; with lfe and all it is the mains.",
        rich_help_panel=FINDING,
    ),
]
Stream = Annotated[
    str | None,
    typer.Option(
        metavar="N[,N...]",
        help="Which sound stream of the film, from 0. Several of one channel each, such as 0-5, are joined as the "
        "channels of one sound, in the order L R C LFE Ls Rs.",
        show_default="the film's default stream",
        rich_help_panel=FINDING,
    ),
]
Formats = Annotated[
    str,
    typer.Option(
        "--format",
        metavar="F[,F...]",
        help="Timeline files to write: json, schema, csv, audacity, reaper, resolve, cmx3600, fcp7, otio, fcpxml, "
        "avid, webvtt, midi; from the drive: ahap, haptic, hjif. `blastline formats` tells what opens each.",
        rich_help_panel=WRITING,
    ),
]
ResultFolder = Annotated[
    Path,
    typer.Option(
        "-o",
        "--output",
        metavar="DIR",
        parser=results_folder,
        help="Folder for the results.",
        rich_help_panel=WRITING,
    ),
]
ActuatorOption = Annotated[
    str,
    typer.Option(
        metavar="NAME|FILE",
        help="The seat's actuator: a name of `blastline actuator list`, or a profile (.toml) of your own.",
        rich_help_panel=DRIVING,
    ),
]
DriveOption = Annotated[
    DriveChoice,
    typer.Option(
        help="How the sound becomes vibration. auto takes for each shot the cheapest that is good enough.",
        rich_help_panel=DRIVING,
    ),
]
PhaseOption = Annotated[
    Phase,
    typer.Option(
        help="causal follows what has sounded, and leads by 1 ms where the actuator's limit is met; zero keeps the "
        "waveform's shape, but may start before the bang.",
        rich_help_panel=DRIVING,
    ),
]
BackgroundOption = Annotated[
    Background,
    typer.Option(help="Between the shots: no motion, or the film's sound as it is.", rich_help_panel=DRIVING),
]
LevelOption = Annotated[
    float | None,
    typer.Option(
        "--level",
        metavar="DB",
        help="Raise the sound by so much before it becomes vibration: less is followed more faithfully, more is "
        "stronger until the actuator's limit levels it.",
        show_default="as the rules say, 0",
        rich_help_panel=DRIVING,
    ),
]
ReportOption = Annotated[
    bool, typer.Option("--report/--no-report", help="Write report.html with pictures.", rich_help_panel=WRITING)
]
Result = Annotated[
    Path,
    typer.Argument(
        metavar="DIR|TIMELINE",
        parser=result_by_name,
        help="A result's folder or its timeline.json.",
        show_default=False,
    ),
]
MadeFor = Annotated[
    str | None,
    typer.Option(
        metavar="NAME|FILE",
        help="The actuator that the drive was made for.",
        show_default="as the timeline says",
        rich_help_panel=DRIVING,
    ),
]
StartTimecode = Annotated[
    str | None,
    typer.Option(
        metavar="HH:MM:SS:FF",
        help="The timecode of the picture's first frame; HH:MM:SS;FF is drop-frame, HH:MM:SS.mmm a clock.",
        show_default="as the film says",
        rich_help_panel=TIMECODE,
    ),
]
FrameRate = Annotated[
    str | None,
    typer.Option(
        metavar="RATE",
        help=f"Frames a second: {rates_text()}. 29.97df and the like drop frame numbers, 29.97ndf do not, 29.97 counts "
        "as the start timecode does.",
        show_default="as the film says",
        rich_help_panel=TIMECODE,
    ),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace earlier results.", rich_help_panel=WRITING)]
EditedTimeline = Annotated[
    Path | None,
    typer.Option(
        "--timeline",
        metavar="DIR|FILE",
        parser=edited_by_name,
        help="Render the events of an edited timeline (JSON, CSV, Audacity labels, REAPER CSV) and detect none; of a "
        "result's folder it is the timeline.json.",
        show_default=False,
        rich_help_panel=FINDING,
    ),
]
OriginalTimeline = Annotated[
    Path | None,
    typer.Option(
        "--original",
        metavar="DIR|TIMELINE",
        parser=result_by_name,
        help="The result's folder or timeline.json that the edited one was exported from.",
        show_default="timeline.json beside the edited one",
        rich_help_panel=FINDING,
    ),
]
Quiet = Annotated[
    bool,
    typer.Option(
        "--quiet", "-q", help="No progress and no summary; errors and warnings still show.", rich_help_panel=MESSAGES
    ),
]

"""What a user may ask of `render`, the same once it is read and checked, and what was asked of a drive."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec

from ..errors import RuleError
from ..model import ActuatorRef, Background, Budget, DriveChoice, Phase, Quality, Timeline
from ..progress import Progress
from ..render import require_renderable
from ..report import asked_of
from ..ruleset import (
    DEFAULT_ACTUATOR,
    LARGEST_LEVEL_DB,
    ActuatorProfile,
    HapticRules,
    Rules,
    load_actuator,
    load_haptics,
    load_rules,
)
from ..streams import Streams
from ..timebase import AS_FILMED, Timebase
from . import names


@dataclass(frozen=True)
class RenderOptions:
    """What a user may ask of `render`, with what they get when they do not ask."""

    quality: Quality = "standard"
    actuator: str = DEFAULT_ACTUATOR
    rules: Path | None = None
    drive: DriveChoice = "auto"
    phase: Phase = "causal"
    background: Background = "mute"
    level_db: float | None = None
    mix: str = "mains"
    stream: Streams | None = None
    formats: tuple[str, ...] = ("json", "csv")
    timebase: Timebase = AS_FILMED
    report: bool = True
    overwrite: bool = False
    timeline: Path | None = None
    original: Path | None = None
    budget: Budget | None = None


USUAL = RenderOptions()
"""What a user gets who asks for nothing."""


@dataclass(frozen=True)
class Setup:
    """What a run was asked for, read and checked."""

    options: RenderOptions
    rules: Rules
    haptics: HapticRules
    profile: ActuatorProfile
    actuator: ActuatorRef
    progress: Progress = field(repr=False)


def require_seat(named: str, profile: ActuatorProfile, rate_hz: int) -> None:
    """Raise RuleError, which names the profile as the user did, where it cannot drive a film at this rate."""
    try:
        require_renderable(profile, rate_hz)
    except RuleError as error:
        raise (error if named == profile.name else RuleError(f"{named}: {error}")) from error


def with_files(options: RenderOptions) -> RenderOptions:
    """Return the options with each timeline that is given as its result's folder as the file that it stands for."""
    edited, original = options.timeline, options.original
    return replace(
        options,
        timeline=None if edited is None else names.timeline_of(edited),
        original=None if original is None else names.timeline_of(original),
    )


def set_up(options: RenderOptions, progress: Progress) -> Setup:
    """Return what was asked for with its rules and its actuator; RuleError where one of them cannot be used."""
    if options.original is not None and options.timeline is None:
        raise RuleError(f"--original {options.original}: there is no edited timeline; give one with --timeline")
    profile, digest = load_actuator(options.actuator, options.rules)
    rules = _levelled(load_rules(options.quality, options.rules), options.level_db)
    actuator = ActuatorRef(profile.name, digest)
    return Setup(options, rules, load_haptics(options.rules), profile, actuator, progress)


def _levelled(rules: Rules, level_db: float | None) -> Rules:
    """Return the rules with the level that was asked for, if one was; RuleError where it is out of range."""
    if level_db is None:
        return rules
    if not abs(level_db) <= LARGEST_LEVEL_DB:
        raise RuleError(f"--level: {level_db:g} dB: expected -{LARGEST_LEVEL_DB:g} to {LARGEST_LEVEL_DB:g}")
    tier = rules.tier
    louder = msgspec.structs.replace(tier, render=msgspec.structs.replace(tier.render, level_db=level_db))
    return replace(rules, tier=louder)


def told_options(timeline: Timeline) -> Iterator[str]:
    """Yield what was asked of a drive that is not as usual, in the report's words and every terminal's alphabet."""
    for asked in asked_of(timeline):
        yield asked.replace("\N{MINUS SIGN}", "-")

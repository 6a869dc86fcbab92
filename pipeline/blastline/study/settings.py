"""The settings that a study of the trade compares: the tiers, and what becomes of one when a single key is changed."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import msgspec

from ..errors import RuleError
from ..misfits import misfit
from ..model import Quality
from ..ruleset import QualityRules, load_rules

TIERS: tuple[Quality, ...] = get_args(Quality)
OFF = "off"

CHANGES: Mapping[Quality, tuple[str, ...]] = {
    "draft": (
        f"scan.band_jump_db={OFF}",
        "scan.band_jump_db=4.5",
        "scan.jump_db=9.0",
        "verify.networks=1",
        "verify.look_from=0.02",
        "verify.look_from=0.05",
        "verify.look_from=0.2",
        "verify.look_from=0.3",
        "render.solver_rate_hz=8000",
        "render.polish_iterations=4",
    ),
    "standard": (
        f"scan.band_jump_db={OFF}",
        "scan.band_jump_db=6.0",
        "scan.jump_db=3.5",
        "scan.difference_jump_db=3.5",
        "verify.networks=1",
        "verify.networks=2",
        "verify.speeds=[]",
        f"verify.gate_from={OFF}",
        f"verify.row_from={OFF}",
        "verify.look_from=0.004",
        "verify.look_from=0.02",
        "verify.look_from=0.05",
        "verify.look_from=0.1",
        "verify.look_from=0.3",
        "verify.company_threshold=0.2",
        "verify.burst_threshold=0.8",
        "verify.even_threshold=0.4",
        "verify.even_networks_threshold=0.7",
        "verify.round_threshold=0.3",
        f"segment.reflection_level_db={OFF}",
        "render.solver_rate_hz=8000",
        "render.solver_rate_hz=16000",
        "render.tolerance=1e-3",
        "render.iterations=5",
        "render.polish_iterations=0",
        "render.polish_iterations=30",
    ),
    "reference": (
        "verify.networks=1",
        "verify.speeds=[]",
        "verify.speeds=[1.1, 1.2]",
        f"scan.band_jump_db={OFF}",
        f"verify.gate_from={OFF}",
        "verify.look_from=0.008",
        "verify.look_from=0.02",
        "render.tolerance=1e-4",
    ),
}
"""Changes of each tier: detection hears most of them, those of [render] only the drive feels."""


@dataclass(frozen=True)
class Setting:
    """A tier, with one key changed or as it is."""

    quality: Quality
    change: str
    tier: QualityRules

    @property
    def name(self) -> str:
        """Return the tier's name and the change."""
        return f"{self.quality}, {self.change}" if self.change else self.quality


def settings(
    rules: Path | None = None, *, changes: Mapping[Quality, Sequence[str]] = CHANGES, felt: bool = False
) -> tuple[Setting, ...]:
    """Return the tiers as they are and the changed ones: those that detection hears, or those that the drive feels.

    A change that leaves its tier as it is is left out. Raises RuleError for a change that does not fit.
    """
    tiers = {quality: load_rules(quality, rules).tier for quality in TIERS}
    every = [Setting(quality, "", tier) for quality, tier in tiers.items()]
    for quality, tier in tiers.items():
        for change in changes.get(quality, ()):
            new = changed(tier, change)
            is_felt = change.strip().startswith("render.")
            if is_felt == felt and all(new != each.tier for each in every if each.quality == quality):
                every.append(Setting(quality, change, new))
    return tuple(every)


def changed(tier: QualityRules, change: str) -> QualityRules:
    """Return a tier with one key changed, as in `verify.networks=1`; `off` leaves an optional key out.

    Raises RuleError for a key that does not exist or a value that does not fit.
    """
    key, equals, text = change.partition("=")
    table, _, name = key.strip().partition(".")
    plain: dict[str, Any] = msgspec.to_builtins(tier)
    known = plain.get(table)
    if not equals or not isinstance(known, dict) or name not in known:
        raise RuleError(f"{change}: expected TABLE.KEY=VALUE with a key of rules/quality, such as verify.networks=1")
    known[name] = None if text.strip() == OFF else _value(change, text)
    try:
        return msgspec.convert(plain, QualityRules)
    except msgspec.ValidationError as error:
        raise RuleError(f"{change}: {misfit(plain, error, QualityRules, null=OFF)}") from error


def _value(change: str, text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError as error:
        raise RuleError(f"{change}: {text.strip()!r}: expected a number, or {OFF}") from error

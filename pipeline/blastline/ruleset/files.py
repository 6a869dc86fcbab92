"""Finding, merging and reading rule files.

built-in rules/  <-  the user's --rules DIR        (key by key; the user's value wins)
                 =   the rules of this run, hashed into the timeline's `rules_digest`
"""

import hashlib
import math
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.resources import files as package_files
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from ..errors import RuleError
from ..misfits import misfit
from ..model import Quality
from .aligning import AlignRules
from .conforming import ConformRules
from .folder import require_folder
from .haptics import HapticRules
from .measuring import MeasuringRules
from .profiles import ActuatorProfile, check_name, check_stable
from .table import Table
from .tables import QualityRules, SceneRules
from .text import read_utf_8

_T = TypeVar("_T", bound=Table)


@dataclass(frozen=True)
class Rules:
    """All rules of a run but the actuator's, with the digest of these and of the verifier's model."""

    quality: Quality
    tier: QualityRules
    scenes: SceneRules
    align: AlignRules
    digest: str
    overlay: Path | None = None


@cache
def builtin() -> Path:
    """Return the folder of the rules that come with the package: in the wheel, or at the top of a checkout."""
    packaged = Path(str(package_files("blastline"))) / "rules"
    return packaged if packaged.is_dir() else Path(__file__).parents[3] / "rules"


def rules_path(relative: str, overlay: Path | None = None) -> Path:
    """Return the file that holds a rule: the user's where there is one, else the built-in one."""
    own = overlay / relative if overlay else None
    return own if own is not None and own.is_file() else builtin() / relative


def verifier_path(tier: QualityRules, overlay: Path | None = None) -> Path:
    """Return the file of the model that a tier's verifier is, which may be missing."""
    return rules_path(f"verifier/{tier.verify.model}", overlay)


def load_rules(quality: Quality, overlay: Path | None = None) -> Rules:
    """Read the rules of a quality tier, with the user's folder laid over the built-in one.

    Raises RuleError for a folder that does not exist or a file that does not fit.
    """
    require_folder(overlay)
    tier = merged(f"quality/{quality}.toml", QualityRules, overlay)
    scenes = merged("scenes.toml", SceneRules, overlay)
    align = merged("align.toml", AlignRules, overlay)
    model = verifier_path(tier, overlay)
    if not model.is_file():
        where = rules_path(f"quality/{quality}.toml", overlay)
        folders = " or ".join(str(folder / "verifier") for folder in (overlay, builtin()) if folder)
        raise RuleError(f"{where}: verify.model = {tier.verify.model!r}: expected the name of a file in {folders}")
    digest = hashlib.sha256(msgspec.json.encode([tier, scenes, align]))
    digest.update(model.read_bytes())
    return Rules(quality, tier, scenes, align, digest.hexdigest(), overlay)


def load_haptics(overlay: Path | None = None) -> HapticRules:
    """Read the rules of the haptic formats, which change no timeline; RuleError as for `load_rules`."""
    require_folder(overlay)
    return merged("haptics.toml", HapticRules, overlay)


def load_conform(overlay: Path | None = None) -> ConformRules:
    """Read the rules of conforming; RuleError as for `load_rules`."""
    require_folder(overlay)
    return merged("conform.toml", ConformRules, overlay)


def load_measuring(overlay: Path | None = None) -> MeasuringRules:
    """Read the rules by which actuators are measured, with the user's folder laid over the built-in one.

    Raises RuleError for a folder that does not exist or a file that does not fit.
    """
    require_folder(overlay)
    return merged("measuring.toml", MeasuringRules, overlay)


def actuator_names(overlay: Path | None = None) -> list[str]:
    """Return the names of the actuator profiles that `load_actuator` knows."""
    require_folder(overlay)
    folders = [builtin()] + ([overlay] if overlay else [])
    return sorted({file.stem for folder in folders for file in folder.glob("actuators/*.toml")})


def load_actuator(name: str, overlay: Path | None = None) -> tuple[ActuatorProfile, str]:
    """Return a profile, by name or by the path of its file, and its digest.

    Raises RuleError where it does not exist, does not fit, has a name that is no line of text, or is unstable.
    """
    require_folder(overlay)
    path = Path(name) if name.lower().endswith(".toml") else rules_path(f"actuators/{name}.toml", overlay)
    if not path.is_file():
        known = ", ".join(actuator_names(overlay))
        raise RuleError(f"{name}: no such actuator profile; expected a .toml file or one of: {known}")
    profile = convert(read_toml(path), ActuatorProfile, path)
    check_name(profile.name, path)
    check_stable(profile, path)
    return profile, hashlib.sha256(msgspec.json.encode(profile)).hexdigest()


def read_toml(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file; RuleError names the file and the line that does not parse."""
    try:
        return tomllib.loads(read_utf_8(path, kind="a TOML file"))
    except tomllib.TOMLDecodeError as error:
        raise RuleError(f"{path}: not a TOML file: {error}") from error
    except RecursionError:
        raise RuleError(
            f"{path}: not a TOML file that can be read: its arrays or tables are nested too deeply"
        ) from None


def convert(plain: dict[str, Any], table: type[_T], path: Path) -> _T:
    """Return plain data as a table; RuleError names the file, the key, its value and what was expected."""
    if plain.get("schema", 1) != 1:
        raise RuleError(f"{path}: schema = {plain['schema']!r}: expected 1, the only layout that this version reads")
    try:
        table_read = msgspec.convert(plain, table)
    except msgspec.ValidationError as error:
        raise RuleError(f"{path}: {misfit(plain, error, table, null='')}") from error
    for key, value in _numbers(plain):
        if not math.isfinite(value):
            raise RuleError(f"{path}: {key} = {value}: expected a finite number")
    return table_read


def _numbers(plain: Any, key: str = "") -> Iterator[tuple[str, float]]:
    """Yield every floating-point number in plain data with the path of its key."""
    if isinstance(plain, dict):
        for name, value in plain.items():
            yield from _numbers(value, f"{key}.{name}" if key else name)
    elif isinstance(plain, list):
        for index, value in enumerate(plain):
            yield from _numbers(value, f"{key}[{index}]")
    elif isinstance(plain, float):
        yield key, plain


def merged(relative: str, table: type[_T], overlay: Path | None) -> _T:
    """Return a rule file with the user's keys laid over it; messages name the file that holds the user's key."""
    path = builtin() / relative
    plain = read_toml(path)
    own = overlay / relative if overlay else None
    if own is not None and own.is_file():
        path, plain = own, _overlay(plain, read_toml(own))
    return convert(plain, table, path)


def _overlay(under: dict[str, Any], over: dict[str, Any]) -> dict[str, Any]:
    """Return `under` with the keys of `over` in place of its own, table by table."""
    merged = dict(under)
    for key, value in over.items():
        below = under.get(key)
        merged[key] = _overlay(below, value) if isinstance(value, dict) and isinstance(below, dict) else value
    return merged

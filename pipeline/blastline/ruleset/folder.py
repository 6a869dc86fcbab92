"""The user's folder of rules: which names its files may have, and what is asked of it before one is read."""

from pathlib import Path
from typing import get_args

from ..errors import RuleError
from ..model import Quality

RULE_FILES = frozenset(
    {
        "scenes.toml",
        "align.toml",
        "conform.toml",
        "haptics.toml",
        "measuring.toml",
        *(f"quality/{quality}.toml" for quality in get_args(Quality)),
    }
)
_FURTHER = ("actuators/*.toml", "perception/*.toml", "perception/*.csv", "verifier/*.json")
_EXPECTED = ", ".join((*sorted(RULE_FILES), *_FURTHER))


def require_folder(overlay: Path | None) -> None:
    """Raise RuleError where the user's folder of rules is none, has no file in it that is ever read, or one that never
    is beside them: most likely its name is misspelt.
    """
    if overlay is None:
        return
    if not overlay.is_dir():
        raise RuleError(f"{overlay}: not a folder; expected one with rule files, laid out like the built-in rules")
    others = sorted(path for pattern in ("*.toml", "quality/*.toml") for path in overlay.glob(pattern))
    others = [path for path in others if path.relative_to(overlay).as_posix() not in RULE_FILES]
    if any((overlay / name).is_file() for name in RULE_FILES) or any(any(overlay.glob(each)) for each in _FURTHER):
        if others:
            raise not_a_rule_file(others[0])
        return
    none = f" ({others[0].relative_to(overlay).as_posix()} is none)" if others else ""
    raise RuleError(f"{overlay}: has no rule file that blastline reads{none}; expected some of: {_EXPECTED}")


def not_a_rule_file(path: Path) -> RuleError:
    """Return the error of a file among rule files that is none."""
    return RuleError(f"{path}: not a rule file that blastline reads; expected one of: {_EXPECTED}")

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
_FURTHER = ("actuators/*.toml", "perception/*.toml", "verifier/*.json")


def require_folder(overlay: Path | None) -> None:
    """Raise RuleError where the user's folder of rules is none, or has no file in it that is ever read."""
    if overlay is None:
        return
    if not overlay.is_dir():
        raise RuleError(f"{overlay}: not a folder; expected one with rule files, laid out like the built-in rules")
    if any((overlay / name).is_file() for name in RULE_FILES) or any(any(overlay.glob(each)) for each in _FURTHER):
        return
    others = sorted(path for pattern in ("*.toml", "quality/*.toml") for path in overlay.glob(pattern))
    none = f" ({others[0].relative_to(overlay).as_posix()} is none)" if others else ""
    expected = ", ".join((*sorted(RULE_FILES), *_FURTHER))
    raise RuleError(f"{overlay}: has no rule file that blastline reads{none}; expected some of: {expected}")

"""Reading a whole folder of the user's rules, to say whether it is sound."""

from collections.abc import Iterator
from pathlib import Path

from .files import load_actuator, load_conform, load_haptics, load_measuring, load_rules, merged
from .folder import RULE_FILES, not_a_rule_file
from .perceptions import own_curve, read_curve
from .tables import QualityRules


def check_rules(overlay: Path) -> Iterator[str]:
    """Read every rule of the user's folder and yield the name of each file that is sound.

    Raises RuleError at the first that is not, or where a file is none that blastline reads.
    """
    load_rules("standard", overlay)
    load_conform(overlay)
    load_haptics(overlay)
    load_measuring(overlay)
    tables = set(overlay.glob("perception/*.csv"))
    for file in sorted(p for p in {*overlay.rglob("*.toml"), *tables} if p.is_file()):
        relative = file.relative_to(overlay).as_posix()
        if relative.startswith("actuators/"):
            load_actuator(str(file))
        elif relative.startswith("perception/"):
            own_curve(file.stem, overlay)  # of two with one name neither could be asked for
            read_curve(file)
        elif relative.startswith("quality/") and relative in RULE_FILES:
            merged(relative, QualityRules, overlay)
        elif relative not in RULE_FILES:
            raise not_a_rule_file(file)
        yield relative

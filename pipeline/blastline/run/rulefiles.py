"""Whether a folder of rules is one that every command takes, with the verifiers that its qualities ask for."""

from collections.abc import Iterator
from pathlib import Path
from typing import get_args

from ..detect import read_model, verifier_of
from ..model import Quality
from ..ruleset import check_rules as check_tables
from ..ruleset import load_rules


def check_rules(overlay: Path) -> Iterator[str]:
    """Read every rule of the user's folder as the commands do, and yield the name of each file that is sound.

    Raises RuleError at the first that is not, or where a file is none that blastline reads.
    """
    for quality in get_args(Quality):  # first: a quality is not sound without the verifier that it asks for
        verifier_of(load_rules(quality, overlay).tier, overlay)
    yield from check_tables(overlay)
    for file in sorted(overlay.glob("verifier/*.json")):
        read_model(file)
        yield file.relative_to(overlay).as_posix()

"""With which options an edited timeline was made, beside those of the run that renders it again."""

from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from ..export.edits import MADE_WITH
from ..misfits import shown
from ..model import Timeline
from .options import Setup

_OPTIONS = {"phase": "--phase", "background": "--background", "level_db": "--level"}
_USUAL = {field.name: field.default for field in msgspec.structs.fields(Timeline)}


def settings_of(timeline: Timeline) -> Mapping[str, Any]:
    """Return what a timeline says of its making, as its file does."""
    return {name: msgspec.to_builtins(getattr(timeline, name)) for name in MADE_WITH}


def other_settings(there: Mapping[str, Any], setup: Setup) -> Iterator[str]:
    """Yield each option of a run that is another than a timeline was made with, and what it was there.

    What a timeline does not say is nothing else. One without an actuator has no drive yet: only what was asked of an
    earlier one tells. The rules of another quality are others anyway.
    """
    actuator = there.get("actuator")
    if isinstance(actuator, dict):
        yield from _other_actuator(actuator, setup)
    now = {
        "phase": setup.options.phase,
        "background": setup.options.background,
        "level_db": setup.rules.tier.render.level_db,
    }
    for name, value in now.items():
        was = there.get(name)
        if was not in (None, value) and (actuator is not None or was != _USUAL[name]):
            yield f"{_OPTIONS[name]} {_said(value)} (there {_said(was)})"
    quality, rules = there.get("quality"), there.get("rules_digest")
    if quality not in (None, setup.rules.quality):
        yield f"--quality {setup.rules.quality} (there {_said(quality)})"
    elif rules not in (None, setup.rules.digest):
        yield "--rules (there others)"


def _other_actuator(there: Mapping[str, Any], setup: Setup) -> Iterator[str]:
    name, digest = there.get("name"), there.get("digest")
    if digest in (None, setup.actuator.digest):
        return
    what = "another profile of that name" if name == setup.actuator.name else _said(name)
    yield f"--actuator {setup.actuator.name} (there {what})"


def _said(value: Any) -> str:
    if isinstance(value, str) and value.isprintable():
        return value
    return f"{value:g}" if isinstance(value, float) else shown(value)

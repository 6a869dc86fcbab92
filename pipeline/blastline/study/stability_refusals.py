"""Rows about what has no meaningful answer: each must end in one line that says what was expected."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ..model import Span
from ..render import drive_filters, plan_windows
from ..ruleset import DEFAULT_ACTUATOR, ActuatorProfile, load_actuator, load_rules
from ..soundtrack import open_soundtrack
from .bars import Bar, refused
from .sound_files import write_sound
from .stability_signals import RATE_HZ, shot_at

Changes = dict[str, dict[str, Any]]

_UNUSABLE: dict[str, Changes] = {
    "gain 0": {"response": {"gain": 0.0}},
    "gain infinite": {"response": {"gain": "inf"}},
    "gain NaN": {"response": {"gain": "nan"}},
    "a pole that grows": {"response": {"poles_rad_s": [[-1400.0, 0.0], [1.0, 0.0]]}},
    "a pole at 0": {"response": {"poles_rad_s": [[-1400.0, 0.0], [0.0, 0.0]]}},
    "a pole without its conjugate": {"response": {"poles_rad_s": [[-1400.0, 0.0], [-9.0, 90.0]]}},
    "a pole that rings for hours": {"response": {"poles_rad_s": [[-1400.0, 0.0], [-1e-9, 0.0]]}},
    "a zero that rings for hours": {"response": {"zeros_rad_s": [[-1e-300, 0.0]]}},
    "as many zeros as poles": {"response": {"poles_rad_s": [[-1400.0, 0.0]]}},
    "a low-pass too flat for the compensator": {"lowpass": {"order": 2}},
    "low-pass at 0 Hz": {"lowpass": {"corner_hz": 0.0}},
    "high-pass at 1e-300 Hz": {"highpass": {"corner_hz": 1e-300}},
    "high-pass above the low-pass": {"highpass": {"corner_hz": 1001.0}},
}
_UNUSABLE_HERE: dict[str, Changes] = {
    "gain 1e-300": {"response": {"gain": 1e-300}},
    "gain 1e300": {"response": {"gain": 1e300}},
    "low-pass at half the rate": {"lowpass": {"corner_hz": RATE_HZ / 2.0}},
    "a pole at 1e300 rad/s": {"response": {"poles_rad_s": [[-1400.0, 0.0]] * 3 + [[-1e300, 0.0]]}},
    "a low-pass too flat for the compensator": {"lowpass": {"order": 2}},
}


def refusal_rows(folder: Path) -> Iterator[Bar]:
    """Yield the rows about refusals; writes profiles and sound files into the folder."""
    profile, _ = load_actuator(DEFAULT_ACTUATOR)
    for number, (name, changes) in enumerate(_UNUSABLE.items()):
        path = folder / f"profile-{number}.toml"
        path.write_text(_toml(changes, profile), encoding="utf-8")
        yield refused(f"profile file: {name}", partial(load_actuator, str(path)))
    for name, changes in _UNUSABLE_HERE.items():
        yield refused(f"profile: {name}", partial(drive_filters, _changed(changes, profile), RATE_HZ, "causal"))
    for rate_hz in (-48_000, 0, 1, 400):
        yield refused(f"filters at {rate_hz} Hz", partial(drive_filters, profile, rate_hz, "zero"))
    for rate_hz in (1, 7_999, 384_001):
        yield refused(f"sound at {rate_hz} Hz", partial(open_soundtrack, _sound(folder, rate_hz, frames=100)))
    yield refused("sound of no frames", partial(_decode, _sound(folder, RATE_HZ, frames=0)))
    yield from _mistakes(_sound(folder, RATE_HZ, frames=100))


def _mistakes(path: Path) -> Iterator[Bar]:
    """Yield what no file or option can ask for: a mistake in a program is a ValueError that says so."""
    rules = load_rules("standard").tier.windows
    plan = partial(plan_windows, [shot_at(100, 10)], frames=100, rate_hz=RATE_HZ, rules=rules)
    yield refused("a shot beyond the film", plan, ValueError)
    yield refused("a span that runs backwards", partial(Span, 5, 4), ValueError)
    with open_soundtrack(path) as track:
        yield refused("blocks of no frames", lambda: list(track.blocks(0)), ValueError)
        list(track.blocks())
        yield refused("a cut past the end", partial(track.read, Span(50, 101)), ValueError)


def _changed(changes: Changes, profile: ActuatorProfile) -> ActuatorProfile:
    tables = {
        table: msgspec.structs.replace(getattr(profile, table), **_hashable(keys)) for table, keys in changes.items()
    }
    return msgspec.structs.replace(profile, **tables)


def _hashable(keys: dict[str, Any]) -> dict[str, Any]:
    return {
        key: tuple(tuple(root) for root in value) if isinstance(value, list) else value for key, value in keys.items()
    }


def _toml(changes: Changes, profile: ActuatorProfile) -> str:
    plain: dict[str, Any] = msgspec.to_builtins(profile)
    lines = []
    for key, value in plain.items():
        if not isinstance(value, dict):
            lines.append(f"{key} = {value!r}")
    for table in ("response", "lowpass", "highpass"):
        lines.append(f"[{table}]")
        for key, value in {**plain[table], **changes.get(table, {})}.items():
            shown = value if value in ("inf", "nan") else repr(value)
            lines.append(f"{key} = {shown}".replace("(", "[").replace(")", "]"))
    return "\n".join(lines)


def _sound(folder: Path, rate_hz: int, *, frames: int) -> Path:
    path = folder / f"{rate_hz}-{frames}.wav"
    write_sound(path, np.zeros(frames), rate_hz)
    return path


def _decode(path: Path) -> None:
    with open_soundtrack(path) as track:
        list(track.blocks())

"""Annotated recordings: folders with an `annotations.csv` and the sounds it lists.

The columns that are read: path, source, label (gunshot or negative), sub_label, duration_s, onsets_s (with
semicolons), notes.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import RuleError
from ..soundtrack import open_soundtrack

# Too like a gunshot to be a lesson in either direction: what an explosion is to a designer is not this model's to say.
AMBIGUOUS = frozenset({"explosion", "cannon", "fire_gun", "game_battle_sfx", "cave_boom"})
_COLUMNS = ("path", "source", "label", "sub_label", "duration_s", "onsets_s", "notes")


@dataclass(frozen=True)
class Recording:
    """One annotated sound; `onsets_s` is empty for a negative, `timed` says whether its onsets are sure to a few ms."""

    path: Path
    source: str
    gunshot: bool
    sub_label: str
    duration_s: float
    onsets_s: tuple[float, ...]
    timed: bool


def read_corpus(folders: Iterable[Path]) -> tuple[Recording, ...]:
    """Return the recordings of some folders, without the ambiguous ones.

    Raises RuleError where an `annotations.csv` is missing or lacks a column.
    """
    return tuple(recording for folder in folders for recording in _read_folder(folder))


@cache
def load_sound(recording: Recording, rate_hz: int) -> NDArray[np.float32]:
    """Return a recording as mono samples at the wanted rate; kept, since training asks for it again and again."""
    from scipy.signal import resample_poly

    with open_soundtrack(recording.path) as track:
        samples = np.concatenate([clip.heard for clip in track.blocks()])
        ratio = Fraction(rate_hz, track.rate_hz)
    if ratio != 1:
        samples = resample_poly(samples, ratio.numerator, ratio.denominator)
    return np.asarray(samples, np.float32)


def _read_folder(folder: Path) -> list[Recording]:
    import pandas as pd

    path = folder / "annotations.csv"
    if not path.is_file():
        raise RuleError(f"{path}: no such file; a corpus folder holds an annotations.csv")
    table = pd.read_csv(path, dtype=str, keep_default_na=False)
    missing = [column for column in _COLUMNS if column not in table.columns]
    if missing:
        raise RuleError(f"{path}: column {missing[0]!r} is missing; expected {', '.join(_COLUMNS)}")
    rows = table.to_dict("records")
    return [
        Recording(
            path=folder / row["path"],
            source=row["source"],
            gunshot=row["label"] == "gunshot",
            sub_label=row["sub_label"],
            duration_s=float(row["duration_s"]),
            onsets_s=tuple(float(onset) for onset in row["onsets_s"].split(";") if onset),
            timed="slow or two-stage" not in row["notes"],
        )
        for row in rows
        if row["sub_label"] not in AMBIGUOUS
    ]

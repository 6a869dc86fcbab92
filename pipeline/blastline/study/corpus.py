"""Annotated recordings: folders with an `annotations.csv` and the sounds it lists.

The columns that are read: path, source, label (gunshot or negative), sub_label, duration_s, onsets_s (ascending, with
semicolons; none of a negative), notes. Others may stand beside them.
"""

import csv
import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import RuleError
from ..plurals import counted
from ..soundtrack import open_soundtrack
from ..units import samples_from_ms

# Too like a gunshot to be a lesson in either direction: what an explosion is to a designer is not this model's to say.
AMBIGUOUS = frozenset({"explosion", "cannon", "fire_gun", "game_battle_sfx", "cave_boom"})
GUNSHOT, NEGATIVE = "gunshot", "negative"
HEARD_MS = 50.0
"""How soon after its onset something of a shot has to be heard."""

_COLUMNS = ("path", "source", "label", "sub_label", "duration_s", "onsets_s", "notes")


@dataclass(frozen=True)
class Recording:
    """One annotated sound; `onsets_s` is empty for a negative, `timed` says whether its onsets are sure to a few ms.

    `name` tells it from every other one: its source, and its path in the folder.
    """

    path: Path
    name: str
    source: str
    gunshot: bool
    sub_label: str
    duration_s: float
    onsets_s: tuple[float, ...]
    timed: bool


def read_corpus(folders: Iterable[Path]) -> tuple[Recording, ...]:
    """Return the recordings of some folders, without the ambiguous ones.

    Raises RuleError, which names the line, where an `annotations.csv` is missing or does not say what it should, and
    where a recording is there twice: it would weigh twice.
    """
    recordings = tuple(recording for folder in folders for recording in _read_folder(folder))
    known: dict[str, Recording] = {}
    for recording in recordings:
        keys = recording.name, str(recording.path.resolve())
        there = next((known[key] for key in keys if key in known), None)
        if there is not None:
            raise RuleError(
                f"{recording.path}: {there.source} has a {there.path} already; "
                "expected each recording once, under a path of its own"
            )
        known |= dict.fromkeys(keys, recording)
    return recordings


@cache
def load_sound(recording: Recording, rate_hz: int) -> NDArray[np.float32]:
    """Return a recording as mono samples at the wanted rate; kept, since training asks for it again and again."""
    from scipy.signal import resample_poly

    with open_soundtrack(recording.path) as track:
        samples = np.concatenate([clip.heard for clip in track.blocks()])
        ratio = Fraction(rate_hz, track.rate_hz)
    _require_sound(recording, samples, track.rate_hz)
    if ratio != 1:
        samples = resample_poly(samples, ratio.numerator, ratio.denominator)
    return np.asarray(samples, np.float32)


def _require_sound(recording: Recording, samples: NDArray[np.float32], rate_hz: int) -> None:
    """Raise RuleError where nothing is heard from an onset on: no detector could be asked for that shot."""
    for onset_s in recording.onsets_s:
        onset = round(onset_s * rate_hz)
        fault = f"{recording.path}: onsets_s = {onset_s:g} in its annotations.csv"
        if onset >= samples.size:
            raise RuleError(f"{fault}: expected seconds before the end of the sound, at {samples.size / rate_hz:g} s")
        if not np.any(samples[onset + 1 : onset + 1 + samples_from_ms(HEARD_MS, rate_hz)]):
            raise RuleError(f"{fault}: expected a shot; the {HEARD_MS:g} ms after it are silent or past the end")


def _read_folder(folder: Path) -> list[Recording]:
    path = folder / "annotations.csv"
    if not path.is_file():
        raise RuleError(f"{path}: no such file; a corpus folder holds an annotations.csv")
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            table = csv.reader(file, strict=True)
            names = [name.strip() for name in next(table, [])]
            missing = [column for column in _COLUMNS if column not in names]
            if missing:
                raise RuleError(f"{path}: column {missing[0]!r} is missing; expected {', '.join(_COLUMNS)}")
            twice = [column for column in _COLUMNS if names.count(column) > 1]
            if twice:
                raise RuleError(f"{path}: line 1: column {twice[0]!r} is there twice; expected each once")
            rows = [_Row(path, table.line_num, names, cells).recording() for cells in table if cells]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise RuleError(f"{path}: not a table of annotations, CSV in UTF-8: {error}") from error
    return [row for row in rows if row.sub_label not in AMBIGUOUS]


@dataclass(frozen=True)
class _Row:
    """A line of a table: which one, what its columns are called and what they hold."""

    path: Path
    line: int
    names: list[str]
    cells: list[str]

    def recording(self) -> Recording:
        """Return what the line says; RuleError where a cell does not say what it should."""
        if len(self.cells) != len(self.names):
            raise RuleError(
                f"{self.path}: line {self.line}: {counted(len(self.cells), 'cell')}; "
                f"expected {len(self.names)}, as the first line names"
            )
        cells = {name: cell.strip() for name, cell in zip(self.names, self.cells, strict=True)}
        for name in ("path", "source"):
            if not cells[name]:
                raise self._fault(name, "expected a name")
        if cells["label"] not in (GUNSHOT, NEGATIVE):
            raise self._fault("label", f"expected {GUNSHOT} or {NEGATIVE}")
        duration_s = self._seconds("duration_s", cells["duration_s"])
        onsets_s = tuple(self._seconds("onsets_s", each) for each in cells["onsets_s"].split(";") if each.strip())
        if bool(onsets_s) != (cells["label"] == GUNSHOT):
            wanted = "expected the onset of each shot" if cells["label"] == GUNSHOT else "expected none"
            raise self._fault("onsets_s", f"{wanted}, as it is a {cells['label']}")
        if any(after <= before for before, after in pairwise(onsets_s)):
            raise self._fault("onsets_s", "expected each later than the one before")
        if onsets_s and onsets_s[-1] >= duration_s:
            raise self._fault("onsets_s", f"expected seconds before the end, at {duration_s:g} s")
        return Recording(
            path=self.path.parent / cells["path"],
            name=f"{cells['source']}/{cells['path']}",
            source=cells["source"],
            gunshot=cells["label"] == GUNSHOT,
            sub_label=cells["sub_label"],
            duration_s=duration_s,
            onsets_s=onsets_s,
            timed="slow or two-stage" not in cells["notes"],
        )

    def _seconds(self, name: str, text: str) -> float:
        try:
            seconds = float(text)
        except ValueError:
            seconds = math.nan
        if not 0.0 <= seconds < math.inf:
            more = ", with a semicolon between two" if name == "onsets_s" else ""
            raise self._fault(name, f"expected seconds from 0 on{more}")
        return seconds

    def _fault(self, name: str, wanted: str) -> RuleError:
        found = self.cells[self.names.index(name)].strip()
        return RuleError(f"{self.path}: line {self.line}: {name} = {found[:60]!r}: {wanted}")

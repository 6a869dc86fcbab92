"""Which formats there are, and writing a timeline in some of them."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from ..errors import RuleError
from ..model import Timeline
from .audacity import write_labels
from .haptics import HAPTIC_FORMATS, HapticFormat, HapticTrack, Rounding
from .table import write_csv
from .timeline import write_json


@dataclass(frozen=True)
class Format:
    """A file format: its name on the command line, the end of its file's name, the tool that opens it, its writer."""

    name: str
    suffix: str
    tool: str
    write: Callable[[Timeline, Path], None]

    @property
    def file_name(self) -> str:
        """Return the name of the file that the format is written to."""
        return f"timeline{self.suffix}"

    @property
    def files(self) -> tuple[str, ...]:
        """Return the names of all files of the format, which is one."""
        return (self.file_name,)

    @property
    def sets(self) -> tuple[str, ...]:
        """Return the patterns of further files, of which there are none."""
        return ()


_ALL = (
    Format("json", ".json", "blastline itself and scripts: everything that is known", write_json),
    Format("csv", ".csv", "spreadsheets and pandas: one row per event", write_csv),
    Format("audacity", ".audacity.txt", "Audacity: File > Import > Labels", write_labels),
)

FORMATS: Mapping[str, Format] = MappingProxyType({known.name: known for known in _ALL})


def known_formats(names: Iterable[str]) -> tuple[Format | HapticFormat, ...]:
    """Return the formats of the given names, each once and in order; RuleError for a name that is none."""
    unique = tuple(dict.fromkeys(names))
    every: dict[str, Format | HapticFormat] = {**FORMATS, **HAPTIC_FORMATS}
    for name in unique:
        if name not in every:
            raise RuleError(f"--format {name!r}: no such format; expected some of: {', '.join(every)}")
    return tuple(every[name] for name in unique)


def needs_drive(names: Iterable[str]) -> bool:
    """Return whether any of these formats is made from the drive."""
    return any(name in HAPTIC_FORMATS for name in names)


def export_timeline(
    timeline: Timeline,
    folder: Path,
    *,
    formats: Iterable[str],
    track: HapticTrack | None = None,
    rounding: Callable[[str, Rounding], None] | None = None,
) -> list[Path]:
    """Write the timeline into an existing folder and return the files; those of one format follow one on another.

    A file of the same name is replaced. The haptic formats are written from `track`, and `rounding` is told what each
    could not hold exactly. Raises RuleError for an unknown format before anything is written.
    """
    written: list[Path] = []
    for each in known_formats(formats):
        if isinstance(each, Format):
            each.write(timeline, folder / each.file_name)
        else:
            if track is None:
                raise ValueError(f"the format {each.name} is made from a haptic track")
            errors = each.write(track, folder)
            if rounding is not None:
                rounding(each.name, errors)
        written += [folder / name for name in each.files]
        written += [file for pattern in each.sets for file in sorted(folder.glob(pattern))]
    return written

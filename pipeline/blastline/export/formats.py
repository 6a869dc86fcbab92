"""Which formats there are, and writing a timeline in some of them."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from ..errors import RuleError
from ..model import Timeline
from .audacity import write_labels
from .avid import write_avid
from .cmx3600 import write_cmx3600
from .editorial import write_fcp7, write_otio
from .fcpxml import write_fcpxml
from .haptics import HAPTIC_FORMATS, HapticFormat, HapticTrack, Rounding
from .midi import write_midi
from .reaper import write_reaper
from .resolve import write_resolve
from .schema import write_schema
from .table import write_csv
from .timeline import write_json
from .webvtt import write_webvtt


@dataclass(frozen=True)
class Format:
    """A file format: its name on the command line, the end of its file's name, the tool that opens it, its writer.

    `exactness` is how exactly it holds the time of an event, in words.
    """

    name: str
    suffix: str
    tool: str
    write: Callable[[Timeline, Path], None]
    exactness: str

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


_FRAME, _NANOSECOND = "nearest frame, with the sub-frame offset as text", "1 ns: the sample"

_ALL = (
    Format("json", ".json", "blastline itself and scripts: everything that is known", write_json, "sample"),
    Format(
        "schema",
        ".schema.json",
        "validators and code generators: what timeline.json may hold",
        write_schema,
        "no times",
    ),
    Format("csv", ".csv", "spreadsheets and pandas: one row per event", write_csv, "sample"),
    Format(
        "audacity",
        ".audacity.txt",
        "Audacity: File > Import > Labels, over the film's sound",
        write_labels,
        _NANOSECOND,
    ),
    Format(
        "reaper",
        ".reaper.csv",
        "REAPER: ruler on Minutes:Seconds; View > Region/Marker Manager, right-click > Import regions/markers",
        write_reaper,
        _NANOSECOND,
    ),
    Format(
        "resolve",
        ".resolve.edl",
        "DaVinci Resolve: right-click the timeline > Timelines > Import > Timeline Markers from EDL",
        write_resolve,
        _FRAME,
    ),
    Format(
        "cmx3600",
        ".cmx3600.edl",
        "Avid, conform tools: import the EDL; each shot is a locator of its one edit",
        write_cmx3600,
        _FRAME,
    ),
    Format(
        "fcp7",
        ".fcp7.xml",
        "Adobe Premiere Pro: File > Import; a sequence with the film and its markers, link the film when asked",
        write_fcp7,
        _FRAME,
    ),
    Format(
        "otio",
        ".otio",
        "DaVinci Resolve, OpenTimelineIO tools: File > Import > Timeline; link the film when asked",
        write_otio,
        _FRAME,
    ),
    Format(
        "fcpxml",
        ".fcpxml",
        "Final Cut Pro: File > Import > XML; a project with the film and its markers, relink the film",
        write_fcpxml,
        _FRAME,
    ),
    Format(
        "avid",
        ".avid.txt",
        "Avid Media Composer: Tools > Markers, right-click > Import Markers, onto the timecode track",
        write_avid,
        _FRAME,
    ),
    Format(
        "webvtt",
        ".vtt",
        "VLC, mpv, browsers: load as subtitles beside the film",
        write_webvtt,
        "0.5 ms: whole milliseconds",
    ),
    Format(
        "midi",
        ".mid",
        "any sequencer, Pro Tools: import with its tempo map and markers; a note per shot, velocity from its level",
        write_midi,
        "sample, at every usual rate",
    ),
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

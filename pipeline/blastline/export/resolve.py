"""DaVinci Resolve: the EDL with which it imports timeline markers.

Resolve holds one marker a frame, so events on the same frame share one. The note is what stands before the first `|`.
"""

from itertools import groupby
from pathlib import Path

from ..model import Timeline
from .frames import Marker, frame_markers
from .words import label, note, offset_text, one_line


def write_resolve(timeline: Timeline, path: Path) -> None:
    """Write a marker for each frame with an event: its name, note, colour (red: single, blue: burst), and length.

    Raises RuleError where the film has no frame rate.
    """
    film = frame_markers(timeline, format_name="resolve")
    count = "DROP FRAME" if film.scale.drop_frame else "NON-DROP FRAME"
    lines = [f"TITLE: {one_line(timeline.source.name)}", f"FCM: {count}", ""]
    for number, (frame, group) in enumerate(groupby(film.markers, key=lambda marker: marker.frame), start=1):
        here = list(group)
        span = f"{film.scale.label(frame)} {film.scale.label(frame + 1)}"
        colour = "Red" if here[0].event.burst is None else "Blue"
        name = " + ".join(_plain(label(marker.event)) for marker in here)
        length = max(marker.frames for marker in here)
        lines += [
            f"{number:03}  001      V     C        {span} {span}  ",
            f"{_note(here)} |C:ResolveColor{colour} |M:{name} |D:{length}",
            "",
        ]
    path.write_text("\n".join(lines), encoding="utf-8", newline="\n")


def _note(markers: list[Marker]) -> str:
    if len(markers) == 1:
        return _plain(note(markers[0].event, markers[0].offset_s))
    return "; ".join(_plain(f"{one_line(m.event.id)} {offset_text(m.offset_s)}") for m in markers)


def _plain(text: str) -> str:
    """Return the text without the mark that ends a field."""
    return text.replace("|", "/")

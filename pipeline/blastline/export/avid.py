"""Avid Media Composer: the text that its Markers window imports, a line of tab-separated fields per marker."""

from itertools import groupby
from pathlib import Path

from ..model import Timeline
from .frames import frame_markers
from .words import framed_label


def write_avid(timeline: Timeline, path: Path) -> None:
    """Write user, timecode, track, colour, comment and 1 for each frame with an event; a frame holds one marker.

    The track is the timecode track, which every sequence has. Raises RuleError where the film has no frame rate.
    """
    film = frame_markers(timeline, format_name="avid")
    lines = []
    for frame, group in groupby(film.markers, key=lambda marker: marker.frame):
        here = list(group)
        colour = "red" if here[0].event.burst is None else "blue"
        comment = " + ".join(framed_label(marker.event, marker.at) for marker in here)
        lines.append("\t".join(["blastline", film.scale.label(frame), "TC1", colour, comment, "1"]) + "\n")
    path.write_text("".join(lines), encoding="utf-8", newline="\n")

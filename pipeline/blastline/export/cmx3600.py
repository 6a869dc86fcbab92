"""CMX 3600: an EDL of one edit, the whole film, with a locator for each event.

Avid's EDL Manager and conform tools read the locators. Source and record timecode are the film's own.
"""

import re
from pathlib import Path

from ..model import Timeline
from .frames import frame_markers
from .words import framed_label, one_line


def write_cmx3600(timeline: Timeline, path: Path) -> None:
    """Write the film as one edit and each event as `* LOC:`, red for single shots and blue for bursts.

    Raises RuleError where the film has no frame rate.
    """
    film, name = frame_markers(timeline, format_name="cmx3600"), one_line(timeline.source.name)
    scale = film.scale
    span = f"{scale.label(film.start)} {scale.label(film.stop)}"
    track = "V" if timeline.source.has_picture else "A"
    lines = [
        f"TITLE: {name}",
        f"FCM: {'DROP FRAME' if scale.drop_frame else 'NON-DROP FRAME'}",
        "",
        f"001  {_reel(name):8} {track:5} C        {span} {span}",
        f"* FROM CLIP NAME: {name}",
    ]
    for marker in film.markers:
        colour = "RED" if marker.event.burst is None else "BLUE"
        lines.append(f"* LOC: {scale.label(marker.frame)} {colour:7} {framed_label(marker.event, marker.at)}")
    path.write_text("\n".join([*lines, ""]), encoding="utf-8", newline="\n")


def _reel(name: str) -> str:
    """Return a reel's name: at most eight capital letters and digits."""
    return re.sub(r"[^A-Z0-9]", "", name.rpartition(".")[0].upper() or name.upper())[:8] or "AX"

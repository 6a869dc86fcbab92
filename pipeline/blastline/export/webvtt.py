"""WebVTT: subtitles, to see the events over the film in any player or browser."""

from fractions import Fraction
from pathlib import Path

from ..model import Timeline
from ..timecode import clock_text, picture_time
from ..units import nearest
from .order import with_ends
from .words import label, one_line

STEP_S = Fraction(1, 1000)

_OTHER_BLOCKS = ("WEBVTT", "NOTE", "STYLE", "REGION")
"""What begins a header, a comment, a style sheet or a region: FFmpeg skips the whole block, so mpv shows no cue."""


def write_webvtt(timeline: Timeline, path: Path) -> None:
    """Write a cue per event, named by its id, from its onset to the next one's or to the end of its window.

    Times are of the picture, in milliseconds; an event before the picture's first frame is shown at 0.
    """
    source = timeline.source
    parts = ["WEBVTT\n"]
    for event, end in with_ends(timeline):
        start, stop = (_step(picture_time(source, sample)) for sample in (event.onset_sample, end))
        times = f"{_clock(start)} --> {_clock(max(start + 1, stop))}"
        parts.append(f"{_name(event.id)}\n{times}\n{_text(label(event))}\n")
    path.write_text("\n".join(parts), encoding="utf-8", newline="\n")


def _step(time_s: Fraction) -> int:
    """Return the nearest step from 0."""
    return max(0, nearest(time_s / STEP_S))


def _clock(step: int) -> str:
    return clock_text(step * STEP_S, 3)


def _name(identity: str) -> str:
    """Return the identifier of a cue: read as it stands, but an arrow would make it the times of the cue.

    One that begins like a block of another kind gets a space before it, so that it begins like none.
    """
    name = one_line(identity).replace("-->", "-- >")
    return f" {name}" if name.startswith(_OTHER_BLOCKS) else name


def _text(text: str) -> str:
    """Return the text as it may stand in a cue."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")

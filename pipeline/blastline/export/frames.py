"""Events as markers on the film's frames, for formats that count frames."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from fractions import Fraction

import msgspec

from ..errors import RuleError
from ..model import Event, Source, Timeline
from ..plurals import counted
from ..timebase import rate_text
from ..timecode import FrameScale, FrameTime, clock, frame_scale, frame_time, frames_per_day
from .order import with_ends

FRAME_FORMATS = frozenset({"resolve", "cmx3600", "avid", "fcp7", "otio", "fcpxml"})
"""Formats that count frames: without a frame rate they cannot be written."""

CLIP_FORMATS = frozenset({"fcp7", "otio", "fcpxml"})
"""Formats that hold the film itself as a clip, which begins on a frame even where the film's start is between two."""

_FCP7_MOST_FRAMES = 60

_LEAD_IN_S = 1
"""What begins less before 00:00:00:00 may be a codec's lead-in: only a shot in it is refused."""

_BEGINS_THERE = "this format begins there: choose others, or give a later --start-timecode"


@dataclass(frozen=True)
class Marker:
    """An event on the frame that starts nearest to it; `frames` is how long it lasts, at most to the next one."""

    event: Event
    frame: int
    offset_s: Fraction
    frames: int

    @property
    def at(self) -> FrameTime:
        """Return the frame and the sub-frame offset."""
        return FrameTime(self.frame, self.offset_s)


@dataclass(frozen=True)
class FrameMarkers:
    """A film's events on its frames: how frames are counted, the frames that the film covers, the markers in order.

    Frames count from 00:00:00:00. `start` is the picture's first frame, or an earlier one where an event comes before
    the picture; `stop` lies behind the film's last frame and behind every event.
    """

    scale: FrameScale
    start: int
    stop: int
    markers: tuple[Marker, ...]


def frame_markers(timeline: Timeline, *, format_name: str) -> FrameMarkers:
    """Return a timeline's events on the film's frames.

    Raises RuleError where the film has no frame rate, or the format cannot hold an event so early.
    """
    require_frame_rate([format_name], timeline.source)
    as_held = counted_in(format_name, timeline.source)
    assert as_held is not None
    source, scale = as_held
    markers = []
    for event, stop in with_ends(timeline):
        place = marker_time(source, event.onset_sample, scale)
        frames = frame_time(source, stop, scale).frame - place.frame
        markers.append(Marker(event, place.frame, place.offset_s, max(1, frames)))
    start = min([scale.first_frame, *(marker.frame for marker in markers)])
    if format_name in CLIP_FORMATS and start < 0:
        early = next((marker.event for marker in markers if marker.frame == start), None)  # sound alone may have none
        who = "its sound begins" if early is None else f"{early.id} is"
        where = f"{who} {counted(-start, 'frame')} before 00:00:00:00"
        raise RuleError(f"--format {format_name}: {source.name}: {where}; {_BEGINS_THERE}")
    stop = max([start + 1, _end(source, scale), *(marker.frame + marker.frames for marker in markers)])
    return FrameMarkers(scale, start, stop, tuple(markers))


def marker_time(source: Source, sample: int, scale: FrameScale) -> FrameTime:
    """Return the frame of an event's marker and what remains: the nearest frame, but none behind the film's last."""
    nearest = frame_time(source, sample, scale)
    last = last_frame(source, scale)
    if source.frames == 0 or nearest.frame <= last:  # the end of a film of 0 frames is unknown
        return nearest
    return FrameTime(last, nearest.offset_s + (nearest.frame - last) / scale.rate)


def last_frame(source: Source, scale: FrameScale) -> int:
    """Return a film's last frame."""
    return _end(source, scale) - 1


def _end(source: Source, scale: FrameScale) -> int:
    """Return the frame behind a film's last: as many whole frames as come nearest to its length, at least one."""
    return max(frame_time(source, source.frames, scale).frame, frame_time(source, 0, scale).frame + 1)


def counted_in(format_name: str, source: Source) -> tuple[Source, FrameScale] | None:
    """Return a film as a format holds it, and how its frames count there; None as for `frame_scale`.

    In a clip that is sound alone the first sample is where the clip begins, though its start lies between two frames.
    """
    scale = frame_scale(source)
    if scale is None or format_name not in CLIP_FORMATS:
        return None if scale is None else (source, scale)
    if source.has_picture:
        return source, replace(scale, start=Fraction(scale.first_frame))
    begins = frame_time(source, 0, scale).frame
    return msgspec.structs.replace(source, start_offset_s=0.0), replace(scale, start=Fraction(begins))


def require_late_enough(formats: Iterable[str], source: Source) -> None:
    """Raise RuleError where a film begins long before 00:00:00:00, and one of the formats there."""
    for name in formats:
        as_held = counted_in(name, source) if name in CLIP_FORMATS else None
        if as_held is not None:
            film, scale = as_held
            early_s = -frame_time(film, 0, scale).frame / scale.rate
            if early_s >= _LEAD_IN_S:
                where = f"its sound begins {float(early_s):.3f} s before 00:00:00:00"
                raise RuleError(f"--format {name}: {source.name}: {where}; {_BEGINS_THERE}")


def require_frame_rate(formats: Iterable[str], source: Source) -> None:
    """Raise RuleError where one of the formats counts frames and cannot count the source's."""
    scale = frame_scale(source)
    for name in formats:
        if name in FRAME_FORMATS and scale is None:
            rate = source.frame_rate
            found = f"{rate} frames a second, which no timecode counts" if rate else "no frame rate"
            raise RuleError(f"--format {name}: {source.name} has {found}; give the film's, such as --frame-rate 24")
        if name == "fcp7" and scale is not None and scale.nominal > _FCP7_MOST_FRAMES:
            found = f"{rate_text(scale.rate)} frames a second"
            raise RuleError(f"--format {name}: {source.name} has {found}; this format holds up to {_FCP7_MOST_FRAMES}")
        if name == "cmx3600" and scale is not None and days(source, scale) >= 1:
            found = f"lasts {clock(source.frames, source.sample_rate_hz, decimals=3)}"
            raise RuleError(
                f"--format {name}: {source.name} {found}; an edit of this format is shorter than the 24 hours of "
                "timecode; otio and fcpxml hold it"
            )


def days(source: Source, scale: FrameScale) -> Fraction:
    """Return how often timecode goes round within a film; where it is 1, the film ends at the timecode of its start."""
    start = min(scale.first_frame, frame_time(source, 0, scale).frame)
    return Fraction(_end(source, scale) - start, frames_per_day(scale.nominal, drop_frame=scale.drop_frame))

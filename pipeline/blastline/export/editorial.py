"""OpenTimelineIO (.otio) and Final Cut Pro 7 XML, which Premiere Pro imports: the film as a clip, events as markers.

The same markers stand on the sequence, where an editor sees them, and on the clip, with which they travel when it is
copied to a sequence of the editor's own. The film is an external reference by its name: the tool asks where it is.
"""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from ..model import Timeline
from ..timecode import FrameScale
from .frames import FrameMarkers, Marker, frame_markers
from .words import label, note, one_line

if TYPE_CHECKING:
    import opentimelineio as otio

_FCP7 = "fcp_xml"
_PACKAGE = "blastline"

_TIMECODE = re.compile(r"<string>[^<]*(</string>\s*<frame>(\d+)</frame>)")
"""A timecode of FCP 7 XML: the label that a frame has, and the frame."""


def write_otio(timeline: Timeline, path: Path) -> None:
    """Write the timeline for tools that read OpenTimelineIO. Raises RuleError where the film has no frame rate.

    Each marker's metadata holds the event's exact sample.
    """
    from opentimelineio import adapters

    film = frame_markers(timeline, format_name="otio")
    text = adapters.write_to_string(_sequence(timeline, film, film.scale.first_frame), "otio_json")
    path.write_text(f"{text}\n", encoding="utf-8", newline="\n")


def write_fcp7(timeline: Timeline, path: Path) -> None:
    """Write the timeline as FCP 7 XML. Raises RuleError where the film has no frame rate.

    In this format a clip's markers count from the first frame of its media, not from its timecode.
    """
    from opentimelineio import adapters

    film = frame_markers(timeline, format_name="fcp7")
    text = adapters.write_to_string(_sequence(timeline, film, 0), _FCP7)
    # opentimelineio starts again after 24 hours of real time: at 29.97 non-drop that is 23:58:33:21
    text = _TIMECODE.sub(lambda found: f"<string>{film.scale.label(int(found[2]))}{found[1]}", text)
    path.write_text(text, encoding="utf-8", newline="\n")


def _sequence(timeline: Timeline, film: FrameMarkers, media_start: int) -> "otio.schema.Timeline":
    """Return the film as a sequence; its clip's markers count from `media_start` on the picture's first frame."""
    from opentimelineio import schema

    name = one_line(timeline.source.name)
    displayed = {"timecode": {"displayformat": "DF" if film.scale.drop_frame else "NDF"}}
    sequence = schema.Timeline(name=name, global_start_time=_time(film.start, film.scale), metadata={_FCP7: displayed})
    kinds = [*([schema.TrackKind.Video] if timeline.source.has_picture else []), schema.TrackKind.Audio]
    for kind in kinds:
        track = schema.Track(name=kind, kind=kind)
        before = film.scale.first_frame - film.start
        if before:
            track.append(schema.Gap(duration=_time(before, film.scale)))
        track.append(_clip(timeline, film, displayed, media_start if kind == kinds[0] else None))
        sequence.tracks.append(track)
    sequence.tracks.markers.extend(_marker(m, timeline, film.scale, -film.start) for m in film.markers)
    return sequence


def _clip(
    timeline: Timeline, film: FrameMarkers, displayed: dict[str, Any], media_start: int | None
) -> "otio.schema.Clip":
    """Return the film's clip, without markers where `media_start` is None: sound that goes with a picture."""
    from opentimelineio import opentime, schema

    source, scale = timeline.source, film.scale
    first = scale.first_frame
    whole = opentime.TimeRange(_time(first, scale), _time(film.stop - first, scale))
    media = schema.ExternalReference(target_url=quote(source.name), available_range=whole, metadata={_FCP7: displayed})
    media.name = one_line(source.name)
    clip = schema.Clip(name=media.name, media_reference=media, source_range=whole)
    if media_start is not None:
        inside = (marker for marker in film.markers if marker.frame >= first)
        clip.markers.extend(_marker(marker, timeline, scale, media_start - first) for marker in inside)
    return clip


def _marker(marker: Marker, timeline: Timeline, scale: FrameScale, shift: int) -> "otio.schema.Marker":
    from opentimelineio import opentime, schema

    event, said = marker.event, note(marker.event, marker.offset_s)
    facts = {
        "id": event.id,
        "onset_sample": event.onset_sample,
        "sample_rate_hz": timeline.source.sample_rate_hz,
        "sub_frame_offset_ms": float(1000 * marker.offset_s),
        "confidence": event.confidence,
        "burst": event.burst,
        "shot_in_burst": event.shot_in_burst,
        "peak_dbfs": event.peak_dbfs,
        "azimuth_deg": event.azimuth_deg,
        "drive_model": event.drive.model if event.drive else None,
    }
    return schema.Marker(
        name=label(event),
        marked_range=opentime.TimeRange(_time(marker.frame + shift, scale), _time(marker.frames, scale)),
        color=schema.MarkerColor.RED if event.burst is None else schema.MarkerColor.BLUE,
        comment=said,
        metadata={_PACKAGE: facts, _FCP7: {"comment": said}},
    )


def _time(frames: int, scale: FrameScale) -> "otio.opentime.RationalTime":
    from opentimelineio.opentime import RationalTime

    return RationalTime(frames, float(scale.rate))

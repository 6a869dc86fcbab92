"""FCPXML 1.9, for Final Cut Pro and DaVinci Resolve: the film as a clip with a marker per event, in exact fractions."""

from pathlib import Path
from urllib.parse import quote
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from ..model import Source, Timeline
from ..timecode import FrameScale
from .frames import FrameMarkers, frame_markers
from .words import label, note, one_line

VERSION = "1.9"
_FORMAT, _FILM = "r1", "r2"


def write_fcpxml(timeline: Timeline, path: Path) -> None:
    """Write a project with the film as its only clip and the events as its markers.

    Every time is a whole number of frames, as a fraction such as 1001/24000s. The picture's size is not known, so the
    project is 1920 x 1080. Raises RuleError where the film has no frame rate.
    """
    film, source = frame_markers(timeline, format_name="fcpxml"), timeline.source
    scale, name = film.scale, one_line(source.name)
    root = Element("fcpxml", version=VERSION)
    _resources(SubElement(root, "resources"), source, film)
    project = SubElement(SubElement(root, "event", name="blastline"), "project", name=name)
    sequence = SubElement(
        project,
        "sequence",
        format=_FORMAT,
        duration=_time(film.stop - film.start, scale),
        tcStart=_time(film.start, scale),
        tcFormat=_counting(scale),
    )
    spine = SubElement(sequence, "spine")
    first = scale.first_frame
    if film.start < first:  # an event before the picture: the markers of the gap count from its own start
        gap = SubElement(spine, "gap", name="Gap", offset=_time(film.start, scale), start=_time(0, scale))
        gap.set("duration", _time(first - film.start, scale))
        _markers(gap, film, start=film.start, stop=first, shift=-film.start)
    clip = SubElement(
        spine,
        "asset-clip",
        ref=_FILM,
        name=name,
        offset=_time(first, scale),
        start=_time(first, scale),
        duration=_time(film.stop - first, scale),
        format=_FORMAT,
        tcFormat=_counting(scale),
    )
    _markers(clip, film, start=first, stop=film.stop, shift=0)
    ElementTree.indent(root, " ")
    text = ElementTree.tostring(root, encoding="unicode")
    path.write_text(f'<?xml version="1.0" encoding="UTF-8"?>\n<!DOCTYPE fcpxml>\n{text}\n', "utf-8", newline="\n")


def _resources(resources: Element, source: Source, film: FrameMarkers) -> None:
    scale, first = film.scale, film.scale.first_frame
    SubElement(resources, "format", id=_FORMAT, frameDuration=_time(1, scale), width="1920", height="1080")
    asset = SubElement(
        resources,
        "asset",
        id=_FILM,
        name=one_line(source.name),
        start=_time(first, scale),
        duration=_time(film.stop - first, scale),
        hasAudio="1",
        audioSources="1",
        audioChannels=str(source.channels),
        audioRate=str(source.sample_rate_hz),
    )
    if source.has_picture:
        asset.set("hasVideo", "1")
        asset.set("format", _FORMAT)
    SubElement(asset, "media-rep", kind="original-media", src=quote(source.name))


def _markers(parent: Element, film: FrameMarkers, *, start: int, stop: int, shift: int) -> None:
    """Put the markers of the frames from `start` to `stop` on a clip; its time is a frame plus `shift`."""
    for marker in film.markers:
        if start <= marker.frame < stop:
            SubElement(
                parent,
                "marker",
                start=_time(marker.frame + shift, film.scale),
                duration=_time(min(marker.frames, stop - marker.frame), film.scale),
                value=label(marker.event),
                note=note(marker.event, marker.offset_s),
            )


def _time(frames: int, scale: FrameScale) -> str:
    """Return so many frames as a fraction of seconds over the frame rate's own denominator."""
    numerator, denominator = frames * scale.rate.denominator, scale.rate.numerator
    return f"{numerator // denominator}s" if numerator % denominator == 0 else f"{numerator}/{denominator}s"


def _counting(scale: FrameScale) -> str:
    return "DF" if scale.drop_frame else "NDF"

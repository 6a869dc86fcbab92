"""Markers of formats that count frames, near the end of a film: none makes it longer, or is before its frame."""

import math
from fractions import Fraction
from pathlib import Path

import msgspec
import pytest

from blastline.export.frames import FRAME_FORMATS, frame_markers
from blastline.export.rounding import rounding
from blastline.model import Window
from films import COUNTINGS, film


def test_a_shot_in_the_last_half_frame_is_within_the_film_and_lasts_a_frame() -> None:
    timeline = film(COUNTINGS[1], onsets=[47_000, 47_001])  # 24 frames of 2000 samples
    events = [msgspec.structs.replace(each, window=Window(46_900, 47_100, 0, 0)) for each in timeline.events]
    source = msgspec.structs.replace(timeline.source, frames=47_100)
    timeline = msgspec.structs.replace(timeline, source=source, events=tuple(events))
    found = frame_markers(timeline, format_name="otio")
    assert [(marker.frame - found.start, marker.frames) for marker in found.markers] == [(23, 1), (23, 1)]
    assert found.stop == found.start + 24


@pytest.mark.parametrize("name", sorted(FRAME_FORMATS))
@pytest.mark.parametrize("has_picture", [False, True])
@pytest.mark.parametrize("frames", [48_000, 48_100, 48_999, 49_001, 49_900, 700, 1])
def test_no_marker_makes_a_film_longer(tmp_path: Path, name: str, has_picture: bool, frames: int) -> None:
    """A program that relinks a clip of more frames than its film has refuses it, or shows black."""
    onsets = sorted({frames // 2, max(0, frames - 900), frames - 1})
    timeline = film(COUNTINGS[1], onsets=onsets, has_picture=has_picture)  # 24 frames of 2000 samples
    events = [
        msgspec.structs.replace(each, window=Window(0, frames, 0, 0), onset_s=each.onset_sample / 48_000)
        for each in timeline.events
    ]
    source = msgspec.structs.replace(timeline.source, frames=frames)
    timeline = msgspec.structs.replace(timeline, source=source, events=tuple(events))
    found = frame_markers(timeline, format_name=name)
    assert found.stop - found.start == max(1, math.floor(Fraction(frames, 2000) + Fraction(1, 2)))
    for marker in found.markers:
        assert found.start <= marker.frame < marker.frame + marker.frames <= found.stop
        exact_s = Fraction(marker.event.onset_sample, 48_000)
        assert (marker.frame - found.start) / Fraction(24) + marker.offset_s == exact_s, "it says where the bang is"
        within = Fraction(1, 2) if marker.frame < found.stop - 1 else Fraction(3, 2)
        assert abs(marker.offset_s) * 24 <= within
    [line] = rounding(timeline, [name])
    farthest_ms = max((-1000 * marker.offset_s for marker in found.markers), key=abs)
    said = f"by {float(farthest_ms):+z.3f} ms"
    assert line.endswith("; no event moves" if said == "by +0.000 ms" else said)
    late = any(marker.offset_s >= Fraction(1, 48) for marker in found.markers)
    assert ("from the middle of the film's last frame on" in line) == late


@pytest.mark.parametrize("name", sorted(FRAME_FORMATS))
def test_in_a_film_of_unknown_length_the_markers_are_where_they_are_in_a_long_one(name: str) -> None:
    known = film(COUNTINGS[1])
    unknown = msgspec.structs.replace(known, source=msgspec.structs.replace(known.source, frames=0))
    found, wanted = (
        [(marker.frame, marker.at, marker.offset_s) for marker in frame_markers(each, format_name=name).markers]
        for each in (unknown, known)
    )
    assert found == wanted

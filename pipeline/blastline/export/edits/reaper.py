"""Edited markers and regions, as REAPER's Region/Marker Manager exports them.

#,Name,Start,End,Length            times are in the unit of the project's ruler: h:mm:ss.fff, m:ss.fff, seconds or
M1,shot-0001 0.97,0:01.000,,       samples are read; a frame of timecode or a beat says too little of an onset
R1,shot-0002 0.88,0:02.000,0:02.400,0:00.400
"""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from ...errors import TimelineError
from .row import Cell, Edit, EditedFile, Point
from .text import Grid

_NEEDED = ("#", "name", "start", "end")
_KIND = re.compile(r"([MR]?)\d+")
_CLOCK = re.compile(r"(?:(\d+):)?(\d+):(\d+(?:[.,]\d+)?)")
_FRAMES = re.compile(r"\d+:\d+:\d+[:;.]\d+[:;]?\d*")
_BEATS = re.compile(r"-?\d+\.\d+\.\d+")
_OTHER_RULER = "a time to the millisecond or the sample; set the ruler to seconds or samples and export again"


def is_reaper(header: Sequence[str]) -> bool:
    """Return whether a table's header is that of REAPER's markers and regions."""
    names = {name.lower() for name in header}
    return "#" in names and "start" in names


def read_reaper(grid: Grid, path: Path) -> EditedFile:
    """Return the events of markers and regions: each begins where its marker or region does.

    A region's end is its window's. A marker and a region of one name are one event: the marker is its onset, the region
    its window.
    """
    header, *rows = grid.rows
    names = [name.lower() for name in header.cells]
    for needed in _NEEDED:
        if needed not in names:
            raise TimelineError(
                f"{path}: line {header.line}: no column {needed.capitalize()}; "
                f"expected #,Name,Start,End,Length, found: {', '.join(header.cells)}"
            )
    tables = []
    for row in rows:
        cells = dict(zip(names, row.cells, strict=False))
        tables.append({n: Cell(path, f"line {row.line}", n.capitalize(), cells.get(n, "")) for n in _NEEDED})
    times = [t[name].text for t in tables for name in ("start", "end") if t[name].text]
    in_samples = all(text.isdecimal() for text in times)
    markers: list[Edit] = []
    regions: list[Edit] = []
    for table in tables:
        edit = _edit(table, in_samples=in_samples)
        (regions if edit.window_stop else markers).append(edit)
    return EditedFile(path, tuple(_paired(markers, regions)), shows_ends=True)


def _edit(cells: Mapping[str, Cell], *, in_samples: bool) -> Edit:
    kind = _KIND.fullmatch(cells["#"].text)
    if kind is None:
        raise cells["#"].refused("M and a number for a marker, R and a number for a region")
    if not cells["start"].text:
        raise cells["start"].refused("a time")
    onset = _time(cells["start"], in_samples=in_samples)
    stop = _time(cells["end"], in_samples=in_samples) if cells["end"].text and kind[1] != "M" else None
    if kind[1] == "R" and stop is None:
        raise cells["end"].refused("a time, where the region ends")
    if stop is not None and _order(stop) < _order(onset):
        raise cells["end"].refused(f"a time from {cells['start'].text}, where the region starts")
    return Edit(cells["#"].place, onset, text=cells["name"].text, window_stop=stop)


def _paired(markers: Sequence[Edit], regions: Sequence[Edit]) -> list[Edit]:
    """Return the events, with a marker and a region of one name, if there is one of each and they meet, as one."""
    named = Counter(marker.text for marker in markers)
    of_name: dict[str, list[Edit]] = {}
    for region in regions:
        of_name.setdefault(region.text, []).append(region)
    edits = []
    for marker in markers:
        own = of_name.get(marker.text, []) if marker.text else []
        if len(own) == 1 and named[marker.text] == 1 and _holds(own[0], marker):
            region = own[0]
            earlier = region.onset if _order(region.onset) < _order(marker.onset) else None
            edits.append(replace(marker, window_start=earlier, window_stop=region.window_stop))
        else:
            edits.append(marker)
    taken = {edit.text for edit in edits if edit.window_stop}
    return edits + [region for region in regions if region.text not in taken]


def _holds(region: Edit, marker: Edit) -> bool:
    assert region.window_stop is not None
    return _order(region.onset) <= _order(marker.onset) < _order(region.window_stop)


def _order(point: Point) -> Fraction:
    """Return what times of one file are ordered by: all are samples, or all are seconds."""
    if point.seconds is not None:
        return point.seconds
    assert point.sample is not None
    return Fraction(point.sample)


def _time(cell: Cell, *, in_samples: bool) -> Point:
    if in_samples:
        return Point(cell.sample(), said=(cell.said,))
    text = cell.text
    if text.startswith("-"):
        raise cell.refused("a time from 0, the first frame of the track")
    clock = _CLOCK.fullmatch(text)
    if clock is not None:
        hours, minutes, seconds = clock.groups()
        part = Cell(cell.path, cell.place, cell.name, seconds).seconds(decimal_comma=True)
        assert part.seconds is not None
        whole_s = 3600 * int(hours or 0) + 60 * int(minutes)
        return Point(seconds=whole_s + part.seconds, step_s=part.step_s, said=(cell.said,))
    if _FRAMES.fullmatch(text) or _BEATS.fullmatch(text):
        raise cell.refused(_OTHER_RULER)
    return cell.seconds(decimal_comma=True)

"""The whole film at a glance: its level over time, every shot on it, and the bursts below."""

import math
from collections.abc import Collection, Iterable, Iterator
from fractions import Fraction

import numpy as np

from ..model import Event, Source, Timeline
from ..plurals import counted
from ..timecode import (
    FrameScale,
    clock_text,
    exact_offset,
    frame_of,
    frame_scale,
    frame_time,
    frames_per_day,
)
from ..units import levels_db
from .overview import Overview
from .words import duration, figure, link, safe

_WIDTH, _LEFT, _RIGHT = 1120, 34, 12
_TOP, _MIDDLE, _BOTTOM = 12, 150, 196
_FLOOR_DB = -60.0
_COLUMNS = 1000
_DAY_S = 86_400
_TICKS_S = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400)


def film_track(timeline: Timeline, overview: Overview, *, failed: Collection[str], linked: Collection[str]) -> str:
    """Return the overview as an SVG element; each shot links to its picture (`linked`) or to its row in the table."""
    source, shots = timeline.source, counted(len(timeline.events), "shot")
    parts = [
        f'<svg class="track" viewBox="0 0 {_WIDTH} {_BOTTOM + 8}" role="group" '
        f'aria-label="The film from start to end: its level, and {shots}">',
        _axes(source),
        _level(overview, source.frames),
        *(_shot(event, source, failed=event.id in failed, linked=event.id in linked) for event in timeline.events),
        *_bursts(timeline.events, source),
        "</svg>",
    ]
    return "".join(parts)


def _x(sample: float, frames: int) -> float:
    return _LEFT + (_WIDTH - _LEFT - _RIGHT) * sample / max(1, frames)


def _y(level_db: float) -> float:
    return _TOP + (_MIDDLE - _TOP) * min(1.0, max(0.0, level_db / _FLOOR_DB))


def _level(overview: Overview, frames: int) -> str:
    columns = overview.columns(_COLUMNS)
    if not len(columns):
        return ""
    width = (_x(frames, frames) - _x(0, frames)) / len(columns)
    tops = [_y(float(level)) for level in levels_db(np.asarray(columns, np.float64))]
    path = "".join(
        f"L{_LEFT + index * width:.1f} {top:.1f}H{_LEFT + (index + 1) * width:.1f}" for index, top in enumerate(tops)
    )
    return f'<path d="M{_LEFT} {_MIDDLE}{path}V{_MIDDLE}Z" fill="var(--audio)" opacity=".75"/>'


def _shot(event: Event, source: Source, *, failed: bool, linked: bool) -> str:
    x, y = _x(event.onset_sample, source.frames), _y(event.peak_dbfs)
    colour = "var(--limit)" if failed else "var(--felt)"
    target = f"shot-{event.id}" if linked else f"row-{event.id}"
    name = (
        f"{event.id} at {event.timecode}: {figure(event.peak_dbfs, 1)} dBFS, confidence {figure(event.confidence)}"
        + (", a check failed" if failed else "")
    )
    mark = (
        f'<path d="M{x - 5:.1f} {y - 5:.1f}l10 10m0 -10l-10 10" stroke="{colour}" stroke-width="2.2"/>'
        if failed
        else f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.6" fill="{colour}" fill-opacity="{_weight(event):.2f}"'
        f' stroke="{colour}"/>'
    )
    return (
        f'<a href="{link(target)}" tabindex="-1"><title>{safe(name)}</title>'
        f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{y + 4:.1f}" y2="{_MIDDLE}" stroke="{colour}"/>{mark}</a>'
    )


def _weight(event: Event) -> float:
    """Return how full a marker is: hollow where detection was in two minds, full where it was certain."""
    return min(1.0, max(0.0, 2.0 * event.confidence - 1.0))


def _bursts(events: Iterable[Event], source: Source) -> Iterable[str]:
    bursts: dict[int, list[Event]] = {}
    for event in events:
        if event.burst is not None:
            bursts.setdefault(event.burst, []).append(event)
    for number, shots in bursts.items():
        left, right = (_x(event.onset_sample, source.frames) for event in (shots[0], shots[-1]))
        left, right = left - 3, max(right, left + 6) + 3
        yield (
            f"<g><title>Burst {number}: {counted(len(shots), 'shot')}</title>"
            f'<path d="M{left:.1f} {_MIDDLE + 4}v5H{right:.1f}v-5" '
            'fill="none" stroke="var(--drive)" stroke-width="1.6"/></g>'
        )


def _axes(source: Source) -> str:
    lines = []
    for level_db in (0, -20, -40, -60):
        y = _y(level_db)
        lines.append(f'<line x1="{_LEFT}" x2="{_WIDTH - _RIGHT}" y1="{y:.1f}" y2="{y:.1f}" stroke="var(--ink-grid)"/>')
        lines.append(_label(_LEFT - 6, y + 4, "0 dB" if level_db == 0 else f"−{-level_db}", "end"))
    length_s = source.frames / source.sample_rate_hz
    step_s = next((tick for tick in _TICKS_S if length_s / tick <= 10), _TICKS_S[-1])
    for sample, said in _round_times(source, step_s):
        x = _x(sample, source.frames)
        lines.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{_MIDDLE}" y2="{_BOTTOM - 16}" stroke="var(--ink-grid)"/>')
        if x < _WIDTH - 50:
            lines.append(_label(x, _BOTTOM, said, "start" if x == _LEFT else "middle"))
    return "".join(lines)


def _label(x: float, y: float, text: str, anchor: str) -> str:
    place = f'x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"'
    return f'<text {place} font-size="11.5" fill="var(--ink-soft)">{safe(text)}</text>'


def _round_times(source: Source, step_s: float) -> Iterator[tuple[float, str]]:
    """Yield the samples at which the film's timecode is a multiple of a step, and its hours, minutes and seconds there;
    the time from the start where the film has no timecode, or the step is less than a second.
    """
    scale = frame_scale(source)
    if step_s < 1.0 or source.start_timecode is None or scale is None:
        for index in range(math.floor(source.frames / source.sample_rate_hz / step_s) + 1):
            elapsed_s = index * step_s
            said = duration(elapsed_s) if elapsed_s >= 60.0 else f"{figure(elapsed_s)} s"
            yield elapsed_s * source.sample_rate_hz, said
        return
    step = int(step_s)
    first, last = (frame_time(source, sample, scale).frame for sample in (0, source.frames))
    for second in range(first // (scale.nominal * step) * step, int(last / scale.rate) + 2, step):
        frame = _first_frame(second, scale)
        if first <= frame <= last:  # it may start half a frame before the sound
            sample = ((frame - scale.start) / scale.rate - exact_offset(source)) * source.sample_rate_hz
            yield min(max(0.0, float(sample)), source.frames), scale.label(frame)[: len("HH:MM:SS")]


def _first_frame(second: int, scale: FrameScale) -> int:
    """Return the first frame of a second of timecode; drop-frame leaves out the first numbers of most minutes."""
    day, second = divmod(second, _DAY_S)
    number = scale.nominal // 15 if scale.drop_frame and second % 60 == 0 and second % 600 else 0
    frame = frame_of(f"{clock_text(Fraction(second), 0)}:{number:02}", scale.nominal, drop_frame=scale.drop_frame)
    return day * frames_per_day(scale.nominal, drop_frame=scale.drop_frame) + frame

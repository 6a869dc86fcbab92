"""How exactly each format holds a time, and how far it moves the events of a film."""

from collections.abc import Callable, Iterable
from fractions import Fraction

from ..model import Timeline
from ..timebase import rate_text
from ..timecode import FrameScale, frame_scale, frame_time, frames_per_day, picture_time
from ..units import nearest
from .frames import CLIP_FORMATS, FRAME_FORMATS, counted_in, days, last_frame, marker_time
from .midi import beat_of
from .webvtt import STEP_S
from .words import one_line

Shift = Callable[[int], Fraction]

_EDLS = frozenset({"resolve", "cmx3600"})
_FINAL_CUTS = frozenset({24, 25, 30, 50, 60})
"""How many numbers a second of timecode has in Final Cut Pro's projects."""


def rounding(timeline: Timeline, formats: Iterable[str]) -> tuple[str, ...]:
    """Return a line for each way in which some of the formats round the times of this timeline's events.

    Formats that hold every event at its sample have no line. A shift is positive where the format has the event later
    than it is.
    """
    ways: dict[str, tuple[list[str], Shift]] = {}
    for name in dict.fromkeys(formats):
        found = _way(name, timeline)
        if found is not None:
            ways.setdefault(found[0], ([], found[1]))[0].append(name)
    return tuple(_line(timeline, names, way, shift) for way, (names, shift) in ways.items())


def _line(timeline: Timeline, names: Iterable[str], way: str, shift: Shift) -> str:
    shifts = [(shift(event.onset_sample), event.id) for event in timeline.events]
    if not shifts:
        return f"{', '.join(names)}: {way}; there are no events"
    largest, event = max(shifts, key=lambda each: abs(each[0]))
    farthest = f"{float(1000 * largest):+z.3f}"
    moved = "no event moves" if float(farthest) == 0.0 else f"{one_line(event)} moves farthest, by {farthest} ms"
    return f"{', '.join(names)}: {way}; {moved}"


def _way(name: str, timeline: Timeline) -> tuple[str, Shift] | None:
    """Return how a format rounds, in words, and the function from an onset to how much later the format has it."""
    source = timeline.source
    counted = counted_in(name, source)
    if name in FRAME_FORMATS and counted is not None:
        film, scale = counted
        half_ms = float(500 / scale.rate)
        counting = " drop-frame" if scale.drop_frame else ""
        words = f"times are whole frames, {rate_text(scale.rate)} a second{counting}, at most {half_ms:.2f} ms off"
        if counted != (source, frame_scale(source)):
            words += " in the clip, which begins on the nearest frame"
        if name == "fcpxml" and scale.nominal not in _FINAL_CUTS:
            words += "; Final Cut Pro may not open the file: it has no projects of that rate"
        if name not in CLIP_FORMATS and days(source, scale) > 1:
            words += "; the film is longer than the 24 hours of timecode: one timecode may stand for two moments"
        elif name in _EDLS:
            words += _at_midnight(name, timeline, scale)
        onsets = (event.onset_sample for event in timeline.events)
        if any(marker_time(film, onset, scale) != frame_time(film, onset, scale) for onset in onsets):
            words += "; but what comes from the middle of the film's last frame on is on that"
        return words, lambda sample: -marker_time(film, sample, scale).offset_s
    if name == "webvtt":
        return "times are whole milliseconds", lambda sample: _stepped(picture_time(source, sample), STEP_S)
    beat = beat_of(source.sample_rate_hz)
    tick_s = Fraction(beat.tempo_us, 1_000_000 * beat.ticks_per_beat)
    if name == "midi" and tick_s * source.sample_rate_hz != 1:
        return f"a tick is {float(10**6 * tick_s):.2f} us", lambda sample: _stepped(
            Fraction(sample, source.sample_rate_hz), tick_s
        )
    return None


def _at_midnight(name: str, timeline: Timeline, scale: FrameScale) -> str:
    """Return what to tell of an EDL in which timecode starts again at 00:00:00:00, nothing where it does not.

    That may be within the film, between it and a shot before it, or behind an edit, which is written to where it ends.
    """
    source, day = timeline.source, frames_per_day(scale.nominal, drop_frame=scale.drop_frame)
    marked = {marker_time(source, event.onset_sample, scale).frame for event in timeline.events}
    covered = {scale.first_frame, last_frame(source, scale), *marked}
    if len({frame // day for frame in covered}) > 1:
        return "; the film passes midnight, across which many programs do not read an EDL"
    edits = covered if name == "cmx3600" else marked
    if any((frame + 1) % day == 0 for frame in edits):
        return "; an edit ends at midnight, written 00:00:00:00, which many programs do not read in an EDL"
    return ""


def _stepped(time_s: Fraction, step_s: Fraction) -> Fraction:
    """Return how much later the nearest step from 0 is."""
    return max(0, nearest(time_s / step_s)) * step_s - time_s

"""What the types of a timeline cannot refuse: times that contradict each other, or the film.

0 ──────|window ── onset ──── window|────── frames        each event's onset in its window, that in the film
"""

from collections.abc import Iterator
from fractions import Fraction

from ..model import Event, Reflection, Source
from ..timecode import CLOCK, SHAPE

FROM_GAIN_DB, TO_GAIN_DB = -60, 24
"""How much softer or stronger than usual somebody may want an event."""

_FARTHEST_S = 1e9
_HALF_A_SAMPLE = Fraction(1, 2)
_FLOAT_ROUNDING = Fraction(1, 10**12)  # of the time itself: several steps of a 64-bit float


def source_complaints(source: Source) -> Iterator[str]:
    """Yield what makes no sense of a film's timecode, or of where its sound begins."""
    start, rate = source.start_timecode, source.frame_rate
    if start is not None and not (SHAPE.fullmatch(start) or CLOCK.fullmatch(start)):
        yield f"source.start_timecode = {start!r}: expected HH:MM:SS:FF, HH:MM:SS;FF, HH:MM:SS.mmm or null"
    if rate is not None and not _is_rate(rate):
        yield f"source.frame_rate = {rate!r}: expected frames a second, such as 25 or 24000/1001, or null"
    if abs(source.start_offset_s) > _FARTHEST_S:
        yield f"source.start_offset_s = {source.start_offset_s}: expected {-_FARTHEST_S:g} to {_FARTHEST_S:g} s"


def event_complaints(event: Event, place: str, source: Source) -> Iterator[str]:
    """Yield what contradicts itself in an event, or the film that it is of; a film of 0 frames has an unknown end."""
    yield from _negative(event, place)
    if source.frames and event.onset_sample >= source.frames:
        yield f"{place}.onset_sample = {event.onset_sample}: expected a sample of the film, which has {_length(source)}"
    at = Fraction(event.onset_s) * source.sample_rate_hz
    if abs(at - event.onset_sample) > _HALF_A_SAMPLE + abs(at) * _FLOAT_ROUNDING:
        expected = f"{event.onset_sample / source.sample_rate_hz!r}, where onset_sample = {event.onset_sample} plays"
        yield f"{place}.onset_s = {event.onset_s}: expected {expected}"
    yield from _window_complaints(event, f"{place}.window", source)
    if not FROM_GAIN_DB <= event.gain_db <= TO_GAIN_DB:
        yield f"{place}.gain_db = {event.gain_db}: expected {FROM_GAIN_DB} to {TO_GAIN_DB} dB"
    yield from reflection_complaints(event.reflections, place)


def reflection_complaints(reflections: tuple[Reflection, ...], place: str) -> Iterator[str]:
    """Yield which of an event's reflections run backwards."""
    for index, each in enumerate(reflections):
        if each.stop < each.start:
            yield (
                f"{place}.reflections[{index}].stop_sample = {each.stop}: "
                f"expected at least start_sample = {each.start}; a span must not run backwards"
            )


def _negative(event: Event, place: str) -> Iterator[str]:
    """Yield each time that its type lets be negative; ranges do not run backwards, so starts are enough."""
    times = [("onset_s", event.onset_s), ("blast.start_sample", event.blast.start)]
    times += [(f"reflections[{index}].delay_ms", each.delay_ms) for index, each in enumerate(event.reflections)]
    for key, value in times:
        if value < 0:
            yield f"{place}.{key} = {value}: expected a time from 0, the first frame of the track"
    for key, number in (("burst", event.burst), ("shot_in_burst", event.shot_in_burst)):
        if number is not None and number < 1:
            yield f"{place}.{key} = {number}: expected a number from 1, the first, or null"


def _window_complaints(event: Event, place: str, source: Source) -> Iterator[str]:
    window, onset = event.window, event.onset_sample
    if window.start > onset:
        yield f"{place}.start_sample = {window.start}: expected at most {onset}, the onset"
    if window.stop <= onset:
        yield f"{place}.stop_sample = {window.stop}: expected more than {onset}, the onset"
    if source.frames and window.stop > source.frames:
        yield f"{place}.stop_sample = {window.stop}: expected an end in the film, which has {_length(source)}"
    if not window.fits_fades:
        fades = f"fade_in_samples = {window.fade_in_samples} and fade_out_samples = {window.fade_out_samples}"
        yield f"{place}: {fades}: expected fades that its {window.stop - window.start} samples have room for"


def _length(source: Source) -> str:
    return f"{source.frames} frames, {source.frames / source.sample_rate_hz:.6g} s"


def _is_rate(text: str) -> bool:
    try:
        return Fraction(text) > 0
    except (ValueError, ZeroDivisionError):
        return False

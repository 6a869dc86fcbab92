"""MIDI: one note per shot, and a marker with its name, to trigger and to see shots in any sequencer.

The tempo makes a tick one sample, so that times are exact: at 48 kHz 24,000 ticks a beat and 120 beats a minute.
Where no tempo does (rates such as 44,101 Hz), a tick is 20.83 us and a note at most half of that off.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from ..model import Event, Source, Timeline
from ..timecode import exact_offset, frame_scale
from ..timecode import label as timecode
from ..units import nearest
from .order import with_ends
from .words import label, one_line

if TYPE_CHECKING:
    from mido import MetaMessage, MidiTrack
    from mido.messages import BaseMessage

NOTE = 60  # middle C
_MICROSECONDS = 1_000_000
_MOST_TICKS_PER_BEAT = 0x7FFF
_MOST_TICKS_BETWEEN = 0x0FFFFFFF
"""The longest step that a file can hold, in ticks: 93 minutes at 48 kHz. A longer one is made of several."""

_SMPTE_RATES = {Fraction(24): 24, Fraction(25): 25, Fraction(30_000, 1001): 29.97, Fraction(30): 30}


class Beat(NamedTuple):
    """How a file counts time: the ticks in a beat (MIDI's division), and how long a beat lasts (its tempo)."""

    ticks_per_beat: int
    tempo_us: int

    def ticks(self, samples: int, rate_hz: int) -> int:
        """Return the tick nearest to a sample."""
        return nearest(Fraction(samples * self.ticks_per_beat * _MICROSECONDS, rate_hz * self.tempo_us))


def beat_of(rate_hz: int) -> Beat:
    """Return the beat whose tick is one sample, nearest to 120 beats a minute; 24,000 ticks a beat where none is.

    >>> beat_of(48_000), beat_of(96_000)
    (Beat(ticks_per_beat=24000, tempo_us=500000), Beat(ticks_per_beat=24000, tempo_us=250000))
    """
    smallest = _MICROSECONDS // math.gcd(_MICROSECONDS, rate_hz)
    tempos = [
        tempo
        for tempo in range(smallest, 2 * _MICROSECONDS + 1, smallest)
        if tempo * rate_hz // _MICROSECONDS <= _MOST_TICKS_PER_BEAT and _MICROSECONDS % tempo == 0
    ]
    if not tempos:
        return Beat(24_000, 500_000)
    tempo = min(tempos, key=lambda each: (abs(math.log(each / 500_000)), each))
    return Beat(tempo * rate_hz // _MICROSECONDS, tempo)


def velocity(peak_dbfs: float) -> int:
    """Return the velocity whose level is the peak's, on the curve that MIDI instruments follow: 40 log10(v / 127) dB.

    >>> velocity(0.0), velocity(-12.0), velocity(-200.0)
    (127, 64, 1)
    """
    return min(127, max(1, math.floor(127 * 10 ** (min(peak_dbfs, 0.0) / 40) + 0.5)))


def write_midi(timeline: Timeline, path: Path) -> None:
    """Write a note per event, from its onset to the next one's or to the end of its window; tick 0 is sample 0.

    The file has the film's start as SMPTE offset where MIDI has its frame rate: 24, 25, 29.97 drop-frame and 30, and
    48, 50, 59.94 drop-frame and 60 by halves.
    """
    import mido

    source, events = timeline.source, tuple(with_ends(timeline))
    beat = beat_of(source.sample_rate_hz)
    onsets = [beat.ticks(event.onset_sample, source.sample_rate_hz) for event, _ in events]
    tempo = mido.MetaMessage("set_tempo", tempo=beat.tempo_us)
    name = mido.MetaMessage("track_name", name=one_line(source.name))
    head = [(0, message) for message in (name, *_smpte_offset(source), tempo)]
    named = [mido.MetaMessage("marker", text=label(event)) for event, _ in events]
    shots = (0, mido.MetaMessage("track_name", name="shots"))
    file = mido.MidiFile(type=1, ticks_per_beat=beat.ticks_per_beat, charset="utf-8")
    file.tracks.append(_track([*head, *zip(onsets, named, strict=True)]))
    file.tracks.append(_track([shots, *_notes(events, beat, source.sample_rate_hz)]))
    file.save(path)


def _notes(events: Iterable[tuple[Event, int]], beat: Beat, rate_hz: int) -> Iterator[tuple[int, "BaseMessage"]]:
    """Yield the notes' starts and ends in order of time; a note ends before the next one starts."""
    import mido

    for event, stop in events:
        level = velocity(event.peak_dbfs)
        yield beat.ticks(event.onset_sample, rate_hz), mido.Message("note_on", note=NOTE, velocity=level)
        yield beat.ticks(stop, rate_hz), mido.Message("note_off", note=NOTE)


def _track(timed: Sequence[tuple[int, "BaseMessage"]]) -> "MidiTrack":
    """Return a track of messages at ticks that do not decrease."""
    import mido

    track, now = mido.MidiTrack(), 0
    for tick, message in timed:
        while tick - now > _MOST_TICKS_BETWEEN:
            track.append(mido.MetaMessage("text", text="", time=_MOST_TICKS_BETWEEN))
            now += _MOST_TICKS_BETWEEN
        track.append(message.copy(time=tick - now))
        now = tick
    return track


def _smpte_offset(source: Source) -> Iterator["MetaMessage"]:
    """Yield where sample 0 stands in timecode, to a hundredth of a frame, where MIDI has the rate."""
    import mido

    scale = frame_scale(source)
    if scale is None or source.start_timecode is None:
        return
    halves = scale.nominal > 30
    rate = _SMPTE_RATES.get(scale.rate / 2 if halves else scale.rate)
    if rate is None or (rate == 29.97) != scale.drop_frame:
        return
    position = scale.start + exact_offset(source) * scale.rate
    hundredths = math.floor(position * (50 if halves else 100) + Fraction(1, 2))
    frame, sub_frames = divmod(hundredths, 100)
    text = timecode(frame, scale.nominal // (2 if halves else 1), drop_frame=scale.drop_frame)
    hours, minutes, seconds, frames = (int(part) for part in text.replace(";", ":").split(":"))
    yield mido.MetaMessage(
        "smpte_offset",
        frame_rate=rate,
        hours=hours,
        minutes=minutes,
        seconds=seconds,
        frames=frames,
        sub_frames=sub_frames,
    )

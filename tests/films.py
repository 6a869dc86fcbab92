"""Timelines of films for export tests: any frame rate and start, names that break careless writers."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import msgspec

from blastline.model import Event, Span, Timeline, Window
from timelines import BURST_SHOT, SHOT, timeline

HOSTILE = 'réel 1 | "cut" <b> & 日本 \t% é\u2028\n--> \x07.mkv'
"""A film's name with everything that some format gives a meaning to."""


@dataclass(frozen=True)
class Counting:
    """A way of counting frames: the rate, and the timecode of the first one."""

    rate: str
    start: str

    @property
    def fraction(self) -> Fraction:
        return Fraction(self.rate)

    @property
    def drop_frame(self) -> bool:
        return ";" in self.start


COUNTINGS = [
    Counting("24000/1001", "01:00:00:00"),
    Counting("24", "00:00:00:00"),
    Counting("25", "10:00:00:00"),
    Counting("30000/1001", "00:59:58;02"),
    Counting("30000/1001", "00:59:58:02"),
    Counting("30", "01:00:00:00"),
    Counting("48", "01:00:00:00"),
    Counting("50", "09:59:59:49"),
    Counting("60000/1001", "00:08:58;04"),
    Counting("60000/1001", "01:00:00:00"),
    Counting("60", "01:00:00:00"),
]

ONSETS = (0, 999, 48_000, 48_800, 49_601, 95_999, 96_000, 3_000_017, 60 * 48_000, 345_600_001)
"""Samples at 48 kHz of shots: at the very start, three within a frame or two, and one after two hours."""


def shot(number: int, onset: int, *, burst: int | None = None) -> Event:
    """Return an event at a sample, with a window of half a second; every other one has a drive."""
    return msgspec.structs.replace(
        SHOT if number % 2 else BURST_SHOT,
        id=f"shot-{number:04}",
        onset_sample=onset,
        onset_s=onset / 48_000,
        burst=burst,
        shot_in_burst=None if burst is None else number,
        blast=Span(onset, onset + 240),
        window=Window(max(0, onset - 288), onset + 24_000, 240, 1920),
        reflections=(),
    )


def film(
    counting: Counting = COUNTINGS[1],
    *,
    onsets: Sequence[int] = ONSETS,
    name: str = "film.mkv",
    offset_s: float = 0.0,
    rate_hz: int = 48_000,
    has_picture: bool = True,
) -> Timeline:
    """Return the timeline of a film with a shot at each onset."""
    events = [shot(number, onset, burst=1 if number in (3, 4, 5) else None) for number, onset in enumerate(onsets, 1)]
    events = [msgspec.structs.replace(event, onset_s=event.onset_sample / rate_hz) for event in events]
    whole = timeline(*events)
    source = msgspec.structs.replace(
        whole.source,
        name=name,
        frames=max(onsets, default=0) + 60_000,
        sample_rate_hz=rate_hz,
        start_timecode=counting.start,
        frame_rate=counting.rate,
        start_offset_s=offset_s,
        has_picture=has_picture,
    )
    return msgspec.structs.replace(whole, source=source, events=tuple(events) if onsets else ())

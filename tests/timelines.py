"""Timelines for tests: one written out, and any that the types allow."""

import msgspec
from hypothesis import strategies as st

from blastline.model import (
    SCHEMA,
    ActuatorRef,
    Check,
    Decision,
    DriveInfo,
    Event,
    Reflection,
    Rejection,
    Source,
    Span,
    Timeline,
    Window,
)
from blastline.ruleset import load_actuator

RATE_HZ = 48_000

SHOT = Event(
    id="shot-0001",
    onset_sample=48_001,
    onset_s=48_001 / RATE_HZ,
    timecode="01:00:01:00",
    confidence=0.96875,
    burst=None,
    shot_in_burst=None,
    peak_dbfs=-3.1,
    snr_db=31.7,
    blast=Span(48_001, 48_240),
    reflections=(Reflection(49_001, 49_200, 1000 / 48, -6.5), Reflection(52_001, 52_300, 4000 / 48, -12.0)),
    window=Window(47_713, 72_000, 240, 1920),
    drive=DriveInfo("filter", "peak 0.7 within the limit", 0.7071067811865476, 11.3, 0.97),
    azimuth_deg=-29.7,
    azimuth_focus=0.993,
)
BURST_SHOT = Event(
    id="shot-0002",
    onset_sample=96_000,
    onset_s=2.0,
    timecode="01:00:02:00",
    confidence=0.5,
    burst=1,
    shot_in_burst=3,
    peak_dbfs=-9.0,
    snr_db=12.0,
    blast=Span(96_000, 96_100),
    reflections=(),
    window=Window(95_712, 100_000, 240, 1920),
)


def timeline(*events: Event) -> Timeline:
    """Return a timeline of two seconds and a half with these events; with two different ones where none are given."""
    return Timeline(
        schema=SCHEMA,
        version="0.1.0",
        quality="standard",
        rules_digest="ab" * 32,
        source=Source("film.mkv", "cd" * 32, RATE_HZ, 120_000, 6, "01:00:00:00", "24"),
        actuator=ActuatorRef("crowson-t108sm", load_actuator("crowson-t108sm")[1]),
        events=events or (SHOT, BURST_SHOT),
        rejections=(Rejection(30_000, "below the threshold", {"probability": 0.2}),),
        checks=(Check("onset", "shot-0001", True, 0.1, 1.0, "ms"), Check("frames", None, True, None, None, "")),
    )


_INDEX = st.integers(0, 2**40)
_LENGTH = st.integers(0, 2**20)
_NUMBER = st.floats(-1e6, 1e6)
_RATIO = st.floats(0.0, 1.0)
_TEXT = st.text(st.characters(exclude_categories=["Cs", "Cc"]), min_size=1, max_size=20)
_EVIDENCE = st.sampled_from([{}, {"probability": 0.25}, {"level": -3.0, "a b": 1e-9}])


@st.composite
def any_event(draw: st.DrawFn, identity: str) -> Event:
    """Draw an event whose fields are of every shape that their types allow; its onset is in its window."""
    onset = draw(_INDEX)
    start, stop = max(0, onset - draw(_LENGTH)), onset + 1 + draw(_LENGTH)
    fade_in = draw(st.integers(0, stop - start))
    reflections = draw(st.lists(st.builds(_reflection, _INDEX, _LENGTH, st.floats(0.0, 1e4), _NUMBER), max_size=3))
    return Event(
        id=identity,
        onset_sample=onset,
        onset_s=onset / RATE_HZ,
        timecode=draw(_TEXT),
        confidence=draw(_RATIO),
        burst=draw(st.none() | st.integers(1, 10**6)),
        shot_in_burst=draw(st.none() | st.integers(1, 10**6)),
        peak_dbfs=draw(_NUMBER),
        snr_db=draw(_NUMBER),
        blast=Span(onset, onset + draw(_LENGTH)),
        reflections=tuple(reflections),
        window=Window(start, stop, fade_in, draw(st.integers(0, stop - start - fade_in))),
        drive=draw(st.none() | st.builds(DriveInfo, _models(), _TEXT, _NUMBER, _NUMBER, _NUMBER, evidence=_EVIDENCE)),
        heard_in=draw(st.sampled_from(["mains", "sides"])),
        azimuth_deg=draw(st.sampled_from([None, -179.9, 0.0, 29.7, 180.0])),
        azimuth_focus=draw(st.sampled_from([None, 0.413, 1.0])),
        decisions=draw(st.sampled_from([(), (Decision("window", "ü", "<b>", {"decay_ms": 80.0}),)])),
    )


@st.composite
def any_timeline(draw: st.DrawFn) -> Timeline:
    """Draw a timeline with up to four events, of a film that ends with the last window or later."""
    drawn = timeline(*[draw(any_event(f"shot-{index}")) for index in range(draw(st.integers(1, 4)))])
    frames = max(event.window.stop for event in drawn.events) + draw(st.sampled_from([0, 1, 10**6]))
    return msgspec.structs.replace(drawn, source=msgspec.structs.replace(drawn.source, frames=frames))


def _reflection(start: int, length: int, delay_ms: float, level_db: float) -> Reflection:
    return Reflection(start, start + length, delay_ms, level_db)


def _models() -> st.SearchStrategy[str]:
    return st.sampled_from(["direct", "filter", "constrained"])

"""From a film to what was found in it: decode once, find the shots, plan their windows, name them in a timeline."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import msgspec

from .. import __version__, scene
from ..detect import LATENCY_S, Detection, find_shots, verifier_of
from ..model import SCHEMA, ActuatorRef, Decision, DriveInfo, Event, Origin, Source, Timeline
from ..progress import Progress, no_progress, report_progress
from ..render import PlannedWindow, plan_windows
from ..report import OverviewMeter
from ..ruleset import Rules, load_rules
from ..soundtrack import Soundtrack, open_soundtrack
from ..timecode import timecode_at
from .options import USUAL, RenderOptions

BLOCK = 65_536
"""Frames that are read at a time; nothing in a result depends on it."""

_LEAST_RATE_HZ = 32_000
"""At this rate 690 of 694 shots are found that 48 kHz shows, at 22.05 kHz 647."""


@dataclass(frozen=True)
class Mark:
    """A shot's id, origin and gain, and what was decided for it where that is known already."""

    id: str
    origin: Origin = "found"
    gain_db: float = 0.0
    decisions: tuple[Decision, ...] = ()


@dataclass(frozen=True, eq=False)
class HeardFilm:
    """A film that has been heard: its track, ready to be read again, and what was found in it.

    `marks` say of each shot what no ear hears: its name, where its onset comes from, how strong it is wanted.
    """

    track: Soundtrack
    source: Source
    found: Detection
    windows: tuple[PlannedWindow, ...]
    marks: tuple[Mark, ...]


def detect(film: Path, options: RenderOptions = USUAL, progress: Progress = no_progress) -> Timeline:
    """Find the shots of a film and return them as a timeline without a drive; of the options, those of finding count.

    Raises BlastlineError for input, rules or a time base that cannot be used.
    """
    read = load_rules(options.quality, options.rules)
    stream, mix, timebase = options.stream, options.mix, options.timebase
    with open_soundtrack(film, stream=stream, mix=mix, rereadable=False, timebase=timebase) as track:
        found = assemble(listen(track, read, progress), read, {}, None)
    return msgspec.structs.replace(found, budget=options.budget)


def listen(track: Soundtrack, rules: Rules, progress: Progress, meter: OverviewMeter | None = None) -> HeardFilm:
    """Decode the film once and return its shots and their windows; `meter` watches as it goes by."""
    verifier = verifier_of(rules.tier, rules.overlay)
    decoded = track.blocks(BLOCK, sides=rules.tier.channels.sides, remembered_s=LATENCY_S)
    blocks = report_progress(decoded, progress, track.expected_frames)
    heard = meter.watch(blocks) if meter else blocks
    found = find_shots(
        heard, rate_hz=track.rate_hz, tier=rules.tier, verifier=verifier, channels=track.channels_in_space
    )
    track.release_recent()
    source = _with_warning_of_rate(track.source())
    windows = plan_windows(found.shots, frames=source.frames, rate_hz=source.sample_rate_hz, rules=rules.tier.windows)
    return HeardFilm(track, source, found, windows, tuple(Mark(event_id(index)) for index in range(len(found.shots))))


def _with_warning_of_rate(source: Source) -> Source:
    """Return a source that was listened to, with a warning where its rate leaves out what a shot is told by."""
    if source.sample_rate_hz >= _LEAST_RATE_HZ:
        return source
    warning = (
        f"sampled at {source.sample_rate_hz} Hz, which holds nothing above {source.sample_rate_hz / 2000.0:g} kHz: "
        f"fewer shots are found than at {_LEAST_RATE_HZ} Hz and more"
    )
    return msgspec.structs.replace(source, warnings=(*source.warnings, warning))


def assemble(heard: HeardFilm, rules: Rules, drives: Mapping[int, DriveInfo], actuator: ActuatorRef | None) -> Timeline:
    """Return the timeline of what was found, without checks; `drives` and `actuator` where there is a drive."""
    source = heard.source
    window_of = {index: planned.window for planned in heard.windows for index in planned.shots}
    events = tuple(
        Event(
            id=mark.id,
            onset_sample=shot.onset,
            onset_s=shot.onset / source.sample_rate_hz,
            timecode=timecode_at(source, shot.onset),
            confidence=shot.confidence,
            burst=shot.burst,
            shot_in_burst=shot.shot_in_burst,
            peak_dbfs=shot.peak_dbfs,
            snr_db=shot.snr_db,
            blast=shot.blast,
            reflections=shot.reflections,
            window=window_of[index],
            drive=drives.get(index),
            origin=mark.origin,
            gain_db=mark.gain_db,
            heard_in=shot.heard_in,
            azimuth_deg=shot.azimuth_deg,
            azimuth_focus=shot.azimuth_focus,
            decisions=mark.decisions or scene.decisions(shot, rules.tier, rate_hz=source.sample_rate_hz),
        )
        for index, (shot, mark) in enumerate(zip(heard.found.shots, heard.marks, strict=True))
    )
    return Timeline(
        schema=SCHEMA,
        version=__version__,
        quality=rules.quality,
        rules_digest=rules.digest,
        source=source,
        actuator=actuator,
        events=events,
        rejections=heard.found.rejections,
        checks=(),
    )


def event_id(index: int) -> str:
    """Return the name of the film's shot number `index`, counted from 0."""
    return f"shot-{index + 1:04d}"

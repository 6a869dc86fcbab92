"""Films for the tests of haptic formats: events, a drive that vibrates in their windows, and both as files."""

from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from blastline.export import HAPTIC_FORMATS, HapticTrack, Rounding, haptic_track
from blastline.model import Event, Reflection, Source, Span, Timeline, Window
from blastline.ruleset import load_actuator, load_haptics
from haptic_rules import Played, ahap_played, haptic_played, hjif_played
from timelines import BURST_SHOT, timeline

RATE_HZ = 48_000
RULES = load_haptics()
PROFILE, _ = load_actuator("crowson-t108sm")

Samples = NDArray[np.float64]


def event(
    onset: int,
    *,
    window: tuple[int, int] | None = None,
    echoes: Sequence[int] = (),
    name: str = "",
    burst: int | None = None,
    rate_hz: int = RATE_HZ,
) -> Event:
    """Return a shot with a window from 6 ms before its onset to 200 ms after it, and echoes at the given samples."""
    start, stop = window or (max(0, onset - 6 * rate_hz // 1000), onset + rate_hz // 5)
    return msgspec.structs.replace(
        BURST_SHOT,
        id=name or f"shot-{onset}",
        onset_sample=onset,
        onset_s=onset / rate_hz,
        burst=burst,
        shot_in_burst=None if burst is None else 1,
        blast=Span(onset, onset + 100),
        reflections=tuple(
            Reflection(echo, echo + 100, (echo - onset) * 1000.0 / rate_hz, -6.0) for echo in sorted(echoes)
        ),
        window=Window(start, stop, 0, 0),
    )


def film(events: Sequence[Event], frames: int, rate_hz: int = RATE_HZ) -> Timeline:
    source = Source("film.mkv", "cd" * 32, rate_hz, frames, 6, "01:00:00:00", "24")
    return msgspec.structs.replace(timeline(), events=tuple(events), source=source, checks=(), rejections=())


def bang(length: int, *, peak: float = 0.9, decay_ms: float = 40.0, tone_hz: float = 80.0, seed: int = 1) -> Samples:
    """Return a tone with some noise that begins with its peak and dies away."""
    random = np.random.default_rng(seed)
    time_s = np.arange(length) / RATE_HZ
    sound = np.cos(2.0 * np.pi * tone_hz * time_s) + 0.2 * random.normal(size=length)
    sound *= np.exp(-time_s * 1000.0 / decay_ms)
    return np.asarray(peak * sound / np.max(np.abs(sound), initial=1e-300), dtype=np.float64)


def drive_of(whole: Timeline, *, peak: float = 0.9, tone_hz: float = 80.0) -> Samples:
    """Return the drive of a film: a bang at each onset to the end of its window, a weaker one at each echo."""
    drive = np.zeros(whole.source.frames)
    for index, each in enumerate(whole.events):
        for start, strength in [(each.onset_sample, peak), *((echo.start, 0.4 * peak) for echo in each.reflections)]:
            stop = min(each.window.stop, len(drive))
            if start < stop:
                drive[start:stop] += bang(stop - start, peak=strength, tone_hz=tone_hz, seed=index)
    return np.asarray(np.clip(drive, -1.0, 1.0), dtype=np.float64)


def track_of(whole: Timeline, drive: Samples) -> HapticTrack:
    return haptic_track(whole, lambda span: drive[span.start : span.stop], profile=PROFILE, rules=RULES)


def write(track: HapticTrack, folder: Path, name: str) -> Rounding:
    folder.mkdir(parents=True, exist_ok=True)
    return HAPTIC_FORMATS[name].write(track, folder)


def played(track: HapticTrack, folder: Path, name: str) -> Played:
    """Write a film of one reel in a format and play what was written."""
    write(track, folder, name)
    if name == "ahap":
        return ahap_played(folder / "timeline.continuous.ahap", folder / "timeline.transients.ahap")
    if name == "haptic":
        [reel] = folder.glob("timeline.reel-*.haptic")
        return haptic_played(reel)
    backrest, seat_pan = hjif_played(folder / "timeline.hjif")
    assert backrest == seat_pan
    return backrest

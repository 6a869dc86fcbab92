"""A shot felt four ways: converted directly, compensated and clipped or scaled, solved within the limit."""

import time
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..correlate import match_template
from ..model import Clip, DriveModel, Phase, Shot, Span
from ..render import DriveFilters, PlannedWindow, drive_filters, hear_window, needed_audio, render_window
from ..render.filters import compensated, felt, in_band, settled_compensated
from ..ruleset import ActuatorProfile, RenderRules
from ..units import samples_from_ms
from .truth import TrueScene

Samples = NDArray[np.float64]
Drive = Literal["direct", "clipped", "scaled", "constrained"]

DRIVES: tuple[Drive, ...] = ("direct", "clipped", "scaled", "constrained")
_MODELS: dict[Drive, DriveModel] = {"direct": "direct", "scaled": "filter", "constrained": "constrained"}
_SEARCH_MS = 5.0  # how far a lag is looked for
_SHORTEST_MS = 5.0  # a shot that has less to itself is not judged


class FeltShot(msgspec.Struct, frozen=True):
    """What a drive makes of one shot: its peak, and of what is felt the rms against that of the sound in the band (the
    target), the correlation with it, and how late it comes against the sound without any delay.
    """

    peak: float
    ratio: float
    correlation: float
    lag_ms: float


class ShotRow(msgspec.Struct, frozen=True):
    """A shot with all its drives.

    `needed` is the compensator's peak in its window, `before_lead` the constrained drive's largest sample before the
    lead of the window's first shot, `steps` what its solver took.
    """

    scene: str
    rate_hz: int
    onset_s: float
    needed: float
    before_lead: float
    steps: int
    felt: dict[Drive, FeltShot]

    @property
    def weak(self) -> bool:
        """Return whether direct conversion is felt at less than half, and the compensator cannot be played."""
        return self.felt["direct"].ratio < 0.5 and self.needed > 1.0


@dataclass(frozen=True, eq=False)
class WindowRow:
    """The shots of a window, how long it is, and the CPU time of each of its drives."""

    shots: tuple[ShotRow, ...]
    window_s: float
    cpu_s: dict[Drive, float]


@dataclass(frozen=True, eq=False)
class RenderSetup:
    """How windows are rendered; `undelayed` are the filters of phase zero, `filters` those of the phase in question."""

    filters: DriveFilters
    undelayed: DriveFilters
    rules: RenderRules


def render_setup(profile: ActuatorProfile, rate_hz: int, phase: Phase, rules: RenderRules) -> RenderSetup:
    """Return how windows of a film at this rate are rendered for an actuator."""
    undelayed = drive_filters(profile, rate_hz, "zero")
    return RenderSetup(undelayed if phase == "zero" else drive_filters(profile, rate_hz, phase), undelayed, rules)


@dataclass(frozen=True, eq=False)
class Window:
    """A window with the sound in the band and its drives, all over exactly its span, shape (frames,), with CPU times.

    `target` has the delay of the phase in question, `heard` none. `needed` is the compensator's peak, `steps` are the
    solver's for each shot, `cpu_s` seconds for each drive.
    """

    planned: PlannedWindow
    shots: tuple[Shot, ...]
    target: Samples
    heard: Samples
    needed: float
    drives: dict[Drive, Samples]
    steps: tuple[int, ...]
    cpu_s: dict[Drive, float]


def windows_of(scene: TrueScene, setup: RenderSetup, wanted: Collection[Drive] = DRIVES) -> Iterator[Window]:
    """Yield each window of a scene with those drives that are wanted."""
    for planned in scene.windows:
        span = needed_audio(planned, frames=scene.frames, filters=setup.undelayed, rules=setup.rules)
        yield rendered(scene.track.read(span), planned, scene.shots, setup, wanted)


def rendered(
    audio: Clip,
    planned: PlannedWindow,
    shots: tuple[Shot, ...],
    setup: RenderSetup,
    wanted: Collection[Drive] = DRIVES,
) -> Window:
    """Return a window with its drives; `audio` covers what phase zero needs, `shots` are all of the film."""
    filters, window = setup.filters, planned.window
    inside = slice(window.start - audio.start, window.stop - audio.start)
    sound = np.asarray(audio.driving, dtype=np.float64)
    began = time.process_time()
    free = compensated(sound, filters)[inside]
    drives: dict[Drive, Samples] = {"clipped": np.clip(free, -1.0, 1.0)}
    spent: dict[Drive, float] = {"clipped": time.process_time() - began}
    steps: tuple[int, ...] = ()
    began = time.process_time()
    window_heard = hear_window(audio, planned, filters=filters, rules=setup.rules)
    hearing = time.process_time() - began
    for name, model in _MODELS.items():
        if name not in wanted:
            continue
        began = time.process_time()
        done = render_window(window_heard, shots, model=model, reason="study", background="mute")
        spent[name] = hearing + time.process_time() - began
        drives[name] = np.asarray(done.clip.driving, dtype=np.float64)
        if name == "constrained":
            steps = tuple(info.solver_steps or 0 for info in done.drives)
    return Window(
        planned,
        tuple(shots[index] for index in planned.shots),
        target=in_band(sound, filters)[inside],
        heard=in_band(sound, setup.undelayed)[inside],
        needed=float(np.max(np.abs(free))),
        drives=drives,
        steps=steps,
        cpu_s=spent,
    )


def judged(window: Window, scene: str, setup: RenderSetup) -> WindowRow:
    """Return what is felt of each shot of a window, from its onset to the lead of the next or the fade-out.

    Shots that a film's end or the next shot leaves less than 5 ms are left out.
    """
    rate_hz, start = setup.filters.rate_hz, window.planned.window.start
    lead = samples_from_ms(setup.rules.lead_ms, rate_hz)
    onsets = [shot.onset - start for shot in window.shots]
    ends = [*(onset - lead for onset in onsets[1:]), window.planned.core.stop - start]
    vibrations = {name: felt(drive, setup.filters) for name, drive in window.drives.items()}
    before = window.drives["constrained"][: max(0, onsets[0] - lead)]
    rows = []
    for onset, end, steps in zip(onsets, ends, window.steps, strict=True):
        part = slice(onset, end)
        if end - onset < samples_from_ms(_SHORTEST_MS, rate_hz) or not np.any(window.target[part]):
            continue
        rows.append(
            ShotRow(
                scene=scene,
                rate_hz=rate_hz,
                onset_s=(start + onset) / rate_hz,
                needed=window.needed,
                before_lead=float(np.max(np.abs(before), initial=0.0)),
                steps=steps,
                felt={name: _felt_shot(window, name, vibrations[name], part, rate_hz) for name in window.drives},
            )
        )
    return WindowRow(tuple(rows), len(window.target) / rate_hz, window.cpu_s)


def _felt_shot(window: Window, name: Drive, vibration: Samples, part: slice, rate_hz: int) -> FeltShot:
    """Return the figures of one drive over one shot."""
    found, wanted = vibration[part], window.target[part]
    level, against = float(np.sqrt(np.sum(found**2))), float(np.sqrt(np.sum(wanted**2)))
    search = samples_from_ms(_SEARCH_MS, rate_hz)
    padded = np.pad(vibration, search)[part.start : part.stop + 2 * search]
    return FeltShot(
        peak=float(np.max(np.abs(window.drives[name][part]))),
        ratio=level / against,
        correlation=float(np.sum(found * wanted)) / (level * against) if level > 0.0 else 0.0,
        lag_ms=match_template(window.heard[part], padded).lag * 1000.0 / rate_hz,
    )


def windowed_error(scene: TrueScene, setup: RenderSetup, *, preroll_ms: float | None = None) -> float:
    """Return how far the compensator, run window by window, is from the same run over the whole track: the largest
    difference in any window, against the peak there.
    """
    rules = setup.rules if preroll_ms is None else msgspec.structs.replace(setup.rules, preroll_ms=preroll_ms)
    track = np.asarray(scene.track.read(Span(0, scene.frames)).driving, dtype=np.float64)
    whole = compensated(track, setup.filters)
    errors = [0.0]
    for planned in scene.windows:
        span = needed_audio(planned, frames=scene.frames, filters=setup.filters, rules=rules)
        inside = slice(planned.window.start - span.start, planned.window.stop - span.start)
        alone = settled_compensated(track[span.start : span.stop], inside, setup.filters, rules)
        along = whole[planned.window.start : planned.window.stop]
        peak = float(np.max(np.abs(along)))
        errors.append(float(np.max(np.abs(alone - along))) / peak if peak > 0.0 else 0.0)
    return max(errors)

"""How faithful a drive within the limit is, and what it costs: every true shot of scenes, four ways, against bars."""

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import numpy as np

from ..model import Phase, Quality
from ..progress import Progress, no_progress
from ..render import needed_audio
from ..render.filters import settled_compensated
from ..ruleset import DEFAULT_ACTUATOR, load_actuator, load_rules
from ..units import SILENCE_DB, db_from_gain, samples_from_ms
from .bars import Bar
from .drives import Drive, RenderSetup, ShotRow, Window, WindowRow, judged, render_setup, windowed_error, windows_of
from .optimum import Optimum, against_optimum
from .truth import TrueScene, scenes_with_shots, true_scenes

PHASES: tuple[Phase, ...] = ("causal", "zero")
_OPTIMA = 3  # shots, each of another scene, that are held against the optimum
_OPTIMUM_S, _OPTIMUM_HZ = 0.08, 5000  # over so long, with corners so dense: it takes dense matrices


class Means(msgspec.Struct, frozen=True):
    """The means of some shots under one drive."""

    peak: float
    ratio: float
    correlation: float
    lag_ms: float


class RenderingScore(msgspec.Struct, frozen=True):
    """The figures of a tier with an actuator; `shots` are the weak ones, by phase."""

    quality: Quality
    actuator: str
    all_shots: int
    shots: dict[Phase, tuple[ShotRow, ...]]
    optima: tuple[Optimum, ...]
    bars: tuple[Bar, ...]

    def means(self, phase: Phase, drive: Drive, scene: str | None = None) -> Means:
        """Return the means over the weak shots, of one scene or of all."""
        felt = [row.felt[drive] for row in self.shots[phase] if scene in (None, row.scene)]
        return Means(
            *(_mean([getattr(each, name) for each in felt]) for name in ("peak", "ratio", "correlation", "lag_ms"))
        )


@dataclass(frozen=True)
class _FilterCost:
    """The CPU time of the compensator, settled, in all windows of a scene, and of soundfile reading them."""

    filtering_s: float
    reading_s: float


@dataclass
class _Tally:
    """What grows from scene to scene, of one phase."""

    windows: list[WindowRow] = field(default_factory=list)
    window_error: float = 0.0
    full_error: float = 0.0


def score(
    fixtures: Path,
    *,
    quality: Quality = "standard",
    actuator: str = DEFAULT_ACTUATOR,
    rules: Path | None = None,
    progress: Progress = no_progress,
) -> RenderingScore:
    """Render every shot of a folder's scenes, with both phases, and return its figures and the bars.

    Raises RuleError for rules, an actuator or scenes that cannot be used.
    """
    profile, _ = load_actuator(actuator, rules)
    tier = load_rules(quality, rules).tier
    tallies = {phase: _Tally() for phase in PHASES}
    costs: list[_FilterCost] = []
    optima: list[Optimum] = []
    total = len(scenes_with_shots(fixtures))
    progress("rendering", 0, total)
    for number, scene in enumerate(true_scenes(fixtures, tier), start=1):
        setups = {phase: render_setup(profile, scene.track.rate_hz, phase, tier.render) for phase in PHASES}
        for phase, tally in tallies.items():
            setup = setups[phase]
            for window in windows_of(scene, setup):
                row = judged(window, scene.name, setup)
                tally.windows.append(row)
                if phase == "causal" and len(optima) < _OPTIMA and _suits(row, window, optima):
                    optima.append(_optimum(window, row.shots[0], setup))
            tally.window_error = max(tally.window_error, windowed_error(scene, setup))
            whole_ms = 1000.0 * scene.frames / scene.track.rate_hz
            tally.full_error = max(tally.full_error, windowed_error(scene, setup, preroll_ms=whole_ms))
        costs.append(_filter_and_read(scene, setups["causal"]))
        progress("rendering", number, total)
    weak = {
        phase: tuple(shot for row in tally.windows for shot in row.shots if shot.weak)
        for phase, tally in tallies.items()
    }
    return RenderingScore(
        quality,
        profile.name,
        all_shots=sum(len(row.shots) for row in tallies["causal"].windows),
        shots=weak,
        optima=tuple(optima),
        bars=(
            *_fidelity_bars(weak),
            *_lag_bars(weak),
            *_window_bars(tallies),
            *_cost_bars(tallies, costs),
            *_optimum_bars(optima),
        ),
    )


def _fidelity_bars(weak: dict[Phase, tuple[ShotRow, ...]]) -> list[Bar]:
    bars = []
    for phase, shots in weak.items():
        felt = [shot.felt["constrained"] for shot in shots]
        ratio, correlation = ([getattr(each, name) for each in felt] for name in ("ratio", "correlation"))
        early = max((shot.before_lead for shot in shots), default=math.nan)
        bars += [
            Bar(f"constrained, {phase}: mean ratio", _mean(ratio), 0.83, better="above"),
            Bar(f"constrained, {phase}: mean correlation", _mean(correlation), 0.95, better="above"),
            Bar(f"constrained, {phase}: peak", max((each.peak for each in felt), default=math.nan), 1.0),
            Bar(f"constrained, {phase}: drive before the lead", early, 0.0),
        ]
    return bars


def _lag_bars(weak: dict[Phase, tuple[ShotRow, ...]]) -> list[Bar]:
    """Return the largest lag of any shot, of the filter, whose shape is the sound's, and of the constrained drive.

    In ms of a causal drive, in samples of its film of one without delay.
    """
    bars = []
    drives: tuple[tuple[Drive, str], ...] = (("scaled", "filter"), ("constrained", "constrained"))
    for phase, shots in weak.items():
        limit, unit = (0.5, "ms") if phase == "causal" else (1.0, "samples")
        for drive, name in drives:
            lags = [
                abs(shot.felt[drive].lag_ms) * (1.0 if phase == "causal" else shot.rate_hz / 1000.0) for shot in shots
            ]
            bars.append(Bar(f"{name}, {phase}: largest lag", max(lags, default=math.nan), limit, unit))
    return bars


def _window_bars(tallies: dict[Phase, _Tally]) -> list[Bar]:
    bars = []
    for phase, tally in tallies.items():
        error_db = max(SILENCE_DB, db_from_gain(tally.window_error))
        bars.append(Bar(f"filter by windows against the whole track, {phase}", error_db, -80.0, "dB"))
        bars.append(Bar(f"the same with all of the film as pre-roll, {phase}", tally.full_error, 0.0))
    return bars


def _cost_bars(tallies: dict[Phase, _Tally], costs: Sequence[_FilterCost]) -> list[Bar]:
    rows = [row for tally in tallies.values() for row in tally.windows if any(shot.needed > 1.0 for shot in row.shots)]
    spent, seconds = sum(row.cpu_s["constrained"] for row in rows), sum(row.window_s for row in rows)
    filtering_s, reading_s = sum(each.filtering_s for each in costs), sum(each.reading_s for each in costs)
    return [
        Bar("constrained rendering: CPU per second of window", spent / seconds if seconds else math.nan, 0.1, "s"),
        Bar("filter: CPU against soundfile reading the windows", filtering_s / reading_s, 2.0, "times"),
    ]


def _optimum_bars(optima: Iterable[Optimum]) -> list[Bar]:
    return [
        Bar(f"solver against scipy, {each.scene} at {each.onset_s:.2f} s", 100.0 * each.excess, 0.1, "%")
        for each in optima
    ]


def _filter_and_read(scene: TrueScene, setup: RenderSetup) -> _FilterCost:
    """Return what filtering and reading all windows of a scene takes.

    Each window is filtered as in a run: just cut from the film, and with what is worked out once for a film at hand.
    """
    import soundfile

    filters, rules, filtering_s = setup.filters, setup.rules, 0.0
    settled_compensated(np.zeros(1), slice(0, 1), filters, rules)
    for planned in scene.windows:
        span = needed_audio(planned, frames=scene.frames, filters=filters, rules=rules)
        inside = slice(planned.window.start - span.start, planned.window.stop - span.start)
        sound = np.asarray(scene.track.read(span).driving, dtype=np.float64)
        began = time.process_time()
        settled_compensated(sound, inside, filters, rules)
        filtering_s += time.process_time() - began
    began = time.process_time()
    with soundfile.SoundFile(scene.path) as file:
        for planned in scene.windows:
            file.seek(planned.window.start)
            file.read(len(planned.window.span), dtype="float32")
    return _FilterCost(filtering_s, time.process_time() - began)


def _mean(values: Sequence[float]) -> float:
    """Return the mean; NaN, which meets no bar, of nothing."""
    return float(np.mean(values)) if values else math.nan


def _suits(row: WindowRow, window: Window, optima: Sequence[Optimum]) -> bool:
    """Return whether a window is one to hold against the optimum: a single weak shot, of a scene not yet among them."""
    single = len(window.shots) == 1 and len(row.shots) == 1 and row.shots[0].weak
    return single and row.shots[0].scene not in {each.scene for each in optima}


def _optimum(window: Window, shot: ShotRow, setup: RenderSetup) -> Optimum:
    """Return how near the solver comes to the optimum over the first 80 ms of a shot."""
    filters, rules = setup.filters, setup.rules
    first = max(
        0, window.shots[0].onset - samples_from_ms(rules.lead_ms, filters.rate_hz) - window.planned.window.start
    )
    part = slice(first, first + samples_from_ms(1000.0 * _OPTIMUM_S, filters.rate_hz))
    return against_optimum(
        window.target[part],
        window.drives["clipped"][part],
        scene=shot.scene,
        onset_s=shot.onset_s,
        filters=filters,
        rules=rules,
        stride=max(1, filters.rate_hz // _OPTIMUM_HZ),
    )

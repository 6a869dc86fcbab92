"""What rendering costs and how much of a shot it makes felt, setting by setting, over the same true shots."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import islice

import msgspec
import numpy as np

from ..progress import Progress, no_progress
from ..ruleset import ActuatorProfile, QualityRules
from .cases import Case
from .cost import read_cpu_s
from .drives import DRIVES, Drive, FeltShot, RenderSetup, WindowRow, judged, render_setup, windows_of
from .settings import Setting
from .tally import Cost
from .truth import TrueScene, true_scene
from .workers import each_of

BEST = "the best there is"
_BEST_RENDER = {"solver_rate_hz": 48_000, "iterations": 60, "polish_iterations": 2, "tolerance": 1e-6}


class RenderingPoint(msgspec.Struct, frozen=True):
    """A setting or a conversion: means over the weak shots of what is felt against what is to be felt.

    `lost` is the energy of their difference as a part of that of the target, `above_best` what of it the best drive
    within the limit would not lose. The cost is that of all windows.
    """

    name: str
    ratio: float
    correlation: float
    lost: float
    above_best: float
    cpu_s_per_window_s: float
    cost: Cost


class RenderingSweep(msgspec.Struct, frozen=True):
    """All settings over the same weak shots: those felt at less than half in direct conversion, whose compensator
    needs more than the actuator's limit.
    """

    shots: int
    weak: int
    window_s: float
    points: tuple[RenderingPoint, ...]


Key = tuple[str, float]
"""A shot: its film, and the second in it."""


@dataclass
class _Tally:
    """What the shots of a film, or of several, are like in one setting, and the processor time of that."""

    felt: dict[Key, FeltShot] = field(default_factory=dict)
    cpu_s: float = 0.0


@dataclass
class _Rendered:
    """What rendering some films came to, setting by setting."""

    tallies: dict[str, _Tally]
    weak: list[Key] = field(default_factory=list)
    shots: int = 0
    window_s: float = 0.0
    film_s: float = 0.0
    read_s: float = 0.0

    def add(self, other: "_Rendered") -> None:
        """Add what further films came to."""
        for name, tally in other.tallies.items():
            self.tallies[name].felt |= tally.felt
            self.tallies[name].cpu_s += tally.cpu_s
        self.weak += other.weak
        self.shots += other.shots
        self.window_s += other.window_s
        self.film_s += other.film_s
        self.read_s += other.read_s


def sweep_rendering(
    cases: Sequence[Case],
    settings: Sequence[Setting],
    profile: ActuatorProfile,
    *,
    repeats: int = 1,
    jobs: int = 1,
    progress: Progress = no_progress,
) -> RenderingSweep | None:
    """Render the true shots of films with every setting, and in the other ways there are with the first.

    The processor time of a window is the least of so many repeats, after one that does not count; so many films are
    rendered at once as there are jobs. None where no shot is weak, and so nothing tells the drives apart.
    """
    fired = [case for case in cases if case.true_ms.size]
    rendering = _Rendering(settings, profile, repeats)
    every = rendering.nothing()
    progress("rendering", 0, len(fired))
    for number, (_, done) in enumerate(each_of(rendering, fired, jobs=jobs)):
        every.add(done)
        progress("rendering", number + 1, len(fired))
    weak = every.weak
    if not weak:
        return None
    lost = {name: float(np.mean([_lost(tally.felt[key]) for key in weak])) for name, tally in every.tallies.items()}
    points = tuple(
        RenderingPoint(
            name=name,
            ratio=float(np.mean([tally.felt[key].ratio for key in weak])),
            correlation=float(np.mean([tally.felt[key].correlation for key in weak])),
            lost=lost[name],
            above_best=lost[name] - lost[BEST],
            cpu_s_per_window_s=tally.cpu_s / every.window_s,
            cost=Cost(tally.cpu_s / every.read_s, 3600.0 * tally.cpu_s / every.film_s),
        )
        for name, tally in every.tallies.items()
    )
    return RenderingSweep(every.shots, len(weak), every.window_s, points)


@dataclass(frozen=True, eq=False)
class _Rendering:
    """Renders the true shots of a film with each setting and the best there is, and in other ways with the first."""

    settings: Sequence[Setting]
    profile: ActuatorProfile
    repeats: int

    def nothing(self) -> _Rendered:
        """Return what no film comes to."""
        others = [drive for drive in DRIVES if drive != "constrained"]
        return _Rendered({name: _Tally() for name in (*others, *(each.name for each in self.settings), BEST)})

    def __call__(self, case: Case) -> _Rendered:
        """Render a film's shots."""
        done, first = self.nothing(), self.settings[0]
        tiers = [*((each.name, each.tier) for each in self.settings), (BEST, _best(first.tier))]
        with true_scene(case.name, case.path, (case.true_ms / 1000.0).tolist(), first.tier) as scene:
            done.film_s = scene.frames / scene.track.rate_hz
            done.read_s = read_cpu_s(case.path)
            for name, tier in tiers:
                wanted: Sequence[Drive] = DRIVES if name == first.name else ("constrained",)
                setup = render_setup(self.profile, scene.track.rate_hz, "causal", tier.render)
                rows = _rows(scene, setup, wanted, self.repeats)
                for row in rows:
                    for drive in wanted:
                        tally = done.tallies[drive if drive != "constrained" else name]
                        tally.cpu_s += row.cpu_s[drive]
                        tally.felt |= {(shot.scene, shot.onset_s): shot.felt[drive] for shot in row.shots}
                if name == first.name:
                    done.shots = sum(len(row.shots) for row in rows)
                    done.window_s = sum(row.window_s for row in rows)
                    done.weak = [(shot.scene, shot.onset_s) for row in rows for shot in row.shots if shot.weak]
        return done


def _rows(scene: TrueScene, setup: RenderSetup, wanted: Sequence[Drive], repeats: int) -> list[WindowRow]:
    """Return the windows of a scene, each with the least processor time of some repeats for each drive."""
    for _ in islice(windows_of(scene, setup, wanted), 1):
        pass  # what is worked out once for a setup is not counted
    rows = [judged(window, scene.name, setup) for window in windows_of(scene, setup, wanted)]
    for _ in range(repeats - 1):
        again = [window.cpu_s for window in windows_of(scene, setup, wanted)]
        rows = [
            replace(row, cpu_s={drive: min(spent, other[drive]) for drive, spent in row.cpu_s.items()})
            for row, other in zip(rows, again, strict=True)
        ]
    return rows


def _best(tier: QualityRules) -> QualityRules:
    render = msgspec.structs.replace(tier.render, **_BEST_RENDER)
    return msgspec.structs.replace(tier, render=render)


def _lost(felt: FeltShot) -> float:
    """Return |felt - wanted|^2 / |wanted|^2, from the ratio of their levels and their correlation."""
    return 1.0 + felt.ratio**2 - 2.0 * felt.ratio * felt.correlation

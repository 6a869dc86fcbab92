"""The trade between cost and accuracy: every tier, tiers with one key changed, and the peers, over the same films."""

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import msgspec

from ..model import Quality
from ..progress import Progress, no_progress
from ..ruleset import DEFAULT_ACTUATOR, load_actuator
from .bars import Bar
from .bootstrap import f1_gain
from .cases import Case
from .cost import peak_memory_mb
from .detection import Listener, Sweep, listener, sweep
from .front import on_front, shortfall
from .peer_scores import PeerScore
from .peers import installed
from .rendering_sweep import BEST, RenderingSweep, sweep_rendering
from .settings import CHANGES, TIERS, settings
from .sources import StudySource
from .tally import DetectionScore

CLEAR_F1 = 0.001
"""What a tier's F1 has to gain over that of the tier before it, at the lower end of what is likely."""
APART = 2.0
"""How many times as much as the tier before it a tier should cost, or else there would be no need for both."""


class ParetoStudy(msgspec.Struct, frozen=True):
    """The figures of all settings and peers; `on_front` are the names of those that nothing else beats.

    `peak_memory_mb` is that of the tiers, on the longest film. `rendering` is None where it was not asked for, and
    where no shot of the films is weak.
    """

    protocol: str
    detection: tuple[DetectionScore, ...]
    peers: tuple[PeerScore, ...]
    absent: tuple[str, ...]
    peak_memory_mb: dict[str, float | None]
    on_front: tuple[str, ...]
    rendering: RenderingSweep | None
    rendering_asked: bool
    rendering_on_front: tuple[str, ...]
    bars: tuple[Bar, ...]


def study_pareto(
    source: StudySource,
    *,
    rules: Path | None = None,
    actuator: str = DEFAULT_ACTUATOR,
    own: Sequence[str] = (),
    changes: Mapping[Quality, Sequence[str]] = CHANGES,
    with_peers: bool = False,
    with_rendering: bool = True,
    repeats: int = 1,
    jobs: int = 1,
    progress: Progress = no_progress,
) -> ParetoStudy:
    """Measure every tier and every change of one over films that are made once and kept while it lasts.

    So many films are measured at once as there are jobs. `own` are further changes to the standard tier. Raises
    RuleError for rules, changes or films that cannot be used.
    """
    profile, _ = load_actuator(actuator, rules)
    wanted = {**changes, "standard": (*changes.get("standard", ()), *own)}
    listeners = [listener(each.name, each.tier, rules) for each in settings(rules, changes=wanted)]
    drives = settings(rules, changes=wanted, felt=True)
    peers, absent = installed() if with_peers else ((), ())
    with tempfile.TemporaryDirectory(prefix="blastline-") as made:
        cases = tuple(_made(source, Path(made), jobs, progress))
        done = sweep(cases, listeners, peers, repeats=repeats, jobs=jobs, progress=progress)
        memory_mb = {each.name: peak_memory_mb(done.longest, each.tier, each.model) for each in listeners[: len(TIERS)]}
        rendering = (
            sweep_rendering(cases, drives, profile, repeats=repeats, jobs=jobs, progress=progress)
            if with_rendering
            else None
        )
    scores = tuple(tally.score(each.name) for each, tally in zip(listeners, done.tallies, strict=True))
    return ParetoStudy(
        protocol=source.protocol,
        detection=scores,
        peers=done.peers,
        absent=absent,
        peak_memory_mb=memory_mb,
        on_front=_found_front((*scores, *done.peers)),
        rendering=rendering,
        rendering_asked=with_rendering,
        rendering_on_front=_felt_front(rendering) if rendering else (),
        bars=(*_detection_bars(listeners, done, scores), *(_rendering_bars(rendering) if rendering else ())),
    )


def _found_front(every: Sequence[DetectionScore | PeerScore]) -> tuple[str, ...]:
    """Return the names of the settings and peers that nothing else beats in both cost and F1."""
    which = on_front([each.cost.times_read for each in every], [each.f1 for each in every])
    return tuple(each.name for each, there in zip(every, which, strict=True) if there)


def _felt_front(rendering: RenderingSweep) -> tuple[str, ...]:
    """Return the names of the drives that nothing else beats in both cost and energy lost."""
    points = [point for point in rendering.points if point.name != BEST]
    which = on_front([p.cost.times_read for p in points], [-p.lost for p in points])
    return tuple(point.name for point, there in zip(points, which, strict=True) if there)


def _made(source: StudySource, into: Path, jobs: int, progress: Progress) -> Iterator[Case]:
    """Yield the films as they are made."""
    for number, case in enumerate(source.cases(into, jobs=jobs)):
        progress("making films", number + 1, None)
        yield case


def _detection_bars(listeners: Sequence[Listener], done: Sweep, scores: Sequence[DetectionScore]) -> list[Bar]:
    """Return whether the tiers lie on the front, in order, and apart in cost and in F1 at 10 ms."""
    every: tuple[DetectionScore | PeerScore, ...] = (*scores, *done.peers)
    costs, f1 = [each.cost.times_read for each in every], [each.f1 for each in every]
    bars = [
        Bar(f"detection, {each.name}: F1 that as little or less buys above its own", shortfall(number, costs, f1), 0.0)
        for number, each in enumerate(listeners[: len(TIERS)])
    ]
    for number in range(1, len(TIERS)):
        above, below = listeners[number].name, listeners[number - 1].name
        gain = f1_gain(done.tallies[number].films, done.tallies[number - 1].films)
        times = costs[number] / costs[number - 1]
        bars.append(Bar(f"detection, {above} over {below}: cost", times, APART, "times", "above"))
        bars.append(Bar(f"detection, {above} over {below}: F1, lower end of 95 %", gain.low, CLEAR_F1, better="above"))
    return bars


def _rendering_bars(rendering: RenderingSweep) -> list[Bar]:
    """Return whether the tiers lie on the front and are in order; what is lost is a part of the energy to be felt."""
    points = [point for point in rendering.points if point.name != BEST]
    costs, kept = [point.cost.times_read for point in points], [1.0 - point.lost for point in points]
    places = [next(n for n, point in enumerate(points) if point.name == tier) for tier in TIERS]
    bars = [
        Bar(f"rendering, {tier}: energy that as little or less saves", shortfall(place, costs, kept), 0.0)
        for tier, place in zip(TIERS, places, strict=True)
    ]
    for above, below, place, before in zip(TIERS[1:], TIERS, places[1:], places, strict=False):
        times = costs[place] / costs[before]
        bars.append(Bar(f"rendering, {above} over {below}: cost", times, APART, "times", "above"))
        bars.append(
            Bar(f"rendering, {above} over {below}: energy saved", kept[place] - kept[before], 0.0, better="above")
        )
    return bars

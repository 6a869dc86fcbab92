"""How well shots are found, and at what cost: settings and peers over films with a known truth, all in one run."""

from collections.abc import Callable, Iterable, Sequence, Sized
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import msgspec
import numpy as np

from ..detect import Verifier, load_verifier
from ..errors import RuleError
from ..model import Quality
from ..ruleset import QualityRules, load_rules, rules_path
from .cases import Case
from .cost import Heard, listened, peak_memory_mb, read_cpu_s
from .events import ScoredEvent, scored_events
from .peer_scores import PeerScore, PeerTally, opened
from .peers import Peer, installed
from .sources import Source
from .tally import DetectionScore, Spent, Tally


@dataclass(frozen=True, eq=False)
class Listener:
    """A setting of detection: its rules, and the verifier with the file that it was read from."""

    name: str
    tier: QualityRules
    verifier: Verifier
    model: Path


class CaseScore(msgspec.Struct, frozen=True):
    """What was found in one film, at 10 ms, and what went wrong, one by one."""

    name: str
    minutes: float
    hits: int
    false: int
    missed: int
    events: tuple[ScoredEvent, ...]


class DetectionStudy(msgspec.Struct, frozen=True):
    """The figures of one tier, film by film and in all, those of the peers, and the peers that are not installed."""

    quality: Quality
    protocol: str
    score: DetectionScore
    peak_memory_mb: float | None
    peers: tuple[PeerScore, ...]
    absent: tuple[str, ...]
    cases: tuple[CaseScore, ...]


@dataclass(frozen=True, eq=False)
class Sweep:
    """What several listeners and peers found in the same films: their tallies, and the longest film."""

    tallies: tuple[Tally, ...]
    peers: tuple[PeerScore, ...]
    longest: Path


Watcher = Callable[[Case, Heard], None]
Progress = Callable[[str, int, int | None], None]
"""Is told a stage's name, what is done and, where it is known, how much there is to do."""


def unwatched(stage: str, done: int, total: int | None) -> None:
    """Tell nobody."""


def listener(name: str, tier: QualityRules, rules: Path | None = None) -> Listener:
    """Return a setting of detection, ready to listen."""
    model = rules_path(f"verifier/{tier.verify.model}", rules)
    return Listener(name, tier, _verifier(model, tier.verify.networks), model)


@cache
def _verifier(model: Path, networks: int) -> Verifier:
    """Return a verifier; kept, since many settings share one."""
    return load_verifier(model, networks=networks)


def study_detection(
    source: Source,
    into: Path,
    quality: Quality,
    rules: Path | None = None,
    *,
    with_peers: bool = False,
    progress: Progress = unwatched,
) -> tuple[DetectionStudy, tuple[Path, ...]]:
    """Run a tier over films, with those peers that are installed; return the figures, and the file of each film.

    Films that have to be made are made in a folder, and stay there. Raises RuleError where there is none.
    """
    peers, absent = installed() if with_peers else ((), ())
    scored: list[CaseScore] = []
    paths: list[Path] = []
    tier = listener(quality, load_rules(quality, rules).tier, rules)

    def note(case: Case, heard: Heard) -> None:
        events = scored_events(case, heard)
        false, missed = (sum(event.kind == kind for event in events) for kind in ("false", "missed"))
        minutes = heard.frames / heard.rate_hz / 60.0
        scored.append(CaseScore(case.name, minutes, len(case.true_ms) - missed, false, missed, events))
        paths.append(case.path)

    done = sweep(source.cases(into), (tier,), peers, watch=note, progress=progress)
    study = DetectionStudy(
        quality=quality,
        protocol=source.protocol,
        score=done.tallies[0].score(quality),
        peak_memory_mb=peak_memory_mb(done.longest, tier.tier, tier.model),
        peers=done.peers,
        absent=absent,
        cases=tuple(scored),
    )
    return study, tuple(paths)


def sweep(
    cases: Iterable[Case],
    listeners: Sequence[Listener],
    peers: Sequence[Peer] = (),
    *,
    repeats: int = 1,
    watch: Watcher | None = None,
    progress: Progress = unwatched,
) -> Sweep:
    """Listen to each film with every listener and peer in turn, so that all have the same machine at the same time.

    The processor time of a film is the least of so many repeats, after one that does not count. `watch` is told what
    the first listener heard in each film. Raises RuleError where there is no film.
    """
    tallies = tuple(Tally() for _ in listeners)
    others = tuple(PeerTally(peer) for peer in peers)
    longest: tuple[float, Path] | None = None
    total = len(cases) if isinstance(cases, Sized) else None
    for index, case in enumerate(cases):
        progress("listening", index, total)
        if longest is None:
            for each in listeners:
                listened(case.path, each.tier, each.verifier)
            for other in others:
                other.warm()
        read_s = min(read_cpu_s(case.path) for _ in range(repeats))
        for number, (each, tally) in enumerate(zip(listeners, tallies, strict=True)):
            runs = [listened(case.path, each.tier, each.verifier) for _ in range(repeats)]
            heard = runs[0]
            minutes = heard.frames / heard.rate_hz / 60.0
            found_ms = np.array([shot.onset for shot in heard.detection.shots], np.float64) * 1000.0 / heard.rate_hz
            tally.add(case, found_ms, minutes=minutes, spent=Spent(min(run.cpu_s for run in runs), read_s))
            if number == 0 and watch is not None:
                watch(case, heard)
        longest = max(longest or (0.0, case.path), (minutes, case.path))
        if others:
            samples, rate_hz, opening_s = opened(case)
            for other in others:
                other.add(case, samples, rate_hz, opening_s)
    if longest is None:
        raise RuleError("study: no film to listen to")
    read_s, minutes = tallies[0].read_s, tallies[0].minutes
    scores = tuple(other.score(read_s=read_s, minutes=minutes) for other in others)
    return Sweep(tallies, scores, longest[1])

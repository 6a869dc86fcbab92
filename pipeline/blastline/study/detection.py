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
from ..progress import Progress, no_progress
from ..ruleset import QualityRules, load_rules, verifier_path
from .cases import Case
from .cost import Heard, listened, peak_memory_mb, read_cpu_s
from .events import ScoredEvent, scored_events
from .peer_scores import PeerHeard, PeerScore, PeerTally, heard_by, opened, warm
from .peers import Peer, installed
from .sources import StudySource
from .tally import DetectionScore, Spent, Tally
from .workers import each_of


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


def _require_inside(case: Case, heard: Heard) -> None:
    """Raise RuleError where a shot is said to be beyond the end of the sound."""
    end_ms = heard.frames * 1000.0 / heard.rate_hz
    if case.true_ms.size and case.true_ms[-1] >= end_ms:
        raise RuleError(
            f"{case.path}: a shot is said to be at {case.true_ms[-1] / 1000.0:g} s: "
            f"expected seconds before the end of the sound, at {end_ms / 1000.0:g} s"
        )


def listener(name: str, tier: QualityRules, rules: Path | None = None) -> Listener:
    """Return a setting of detection, ready to listen."""
    model = verifier_path(tier, rules)
    return Listener(name, tier, _verifier(model, tier.verify.networks), model)


@cache
def _verifier(model: Path, networks: int) -> Verifier:
    """Return a verifier; kept, since many settings share one."""
    return load_verifier(model, networks=networks)


def study_detection(
    source: StudySource,
    into: Path,
    quality: Quality,
    rules: Path | None = None,
    *,
    with_peers: bool = False,
    jobs: int = 1,
    progress: Progress = no_progress,
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

    done = sweep(source.cases(into, jobs=jobs), (tier,), peers, jobs=jobs, watch=note, progress=progress)
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


@dataclass(frozen=True, eq=False)
class _FilmHeard:
    """What each listener and each peer found in a film, and the processor times of reading it and of each listener."""

    heard: tuple[Heard, ...]
    peers: tuple[PeerHeard, ...]
    read_s: float
    cpu_s: tuple[float, ...]

    @property
    def minutes(self) -> float:
        """Return how long the film is."""
        return self.heard[0].frames / self.heard[0].rate_hz / 60.0


class _Audience:
    """All who listen to each film, one after the other, so that all have the same machine at the same time."""

    def __init__(self, listeners: Sequence[Listener], peers: Sequence[Peer], repeats: int) -> None:
        """Take who listens, and how often."""
        self._listeners, self._peers, self._repeats = listeners, peers, repeats
        self._is_warm = False

    def __call__(self, case: Case) -> _FilmHeard:
        """Listen to a film; what is done once in a process is done before and not counted."""
        if not self._is_warm:
            for each in self._listeners:
                listened(case.path, each.tier, each.verifier)
            for peer in self._peers:
                warm(peer)
            self._is_warm = True
        read_s = min(read_cpu_s(case.path) for _ in range(self._repeats))
        runs = [
            [listened(case.path, each.tier, each.verifier) for _ in range(self._repeats)] for each in self._listeners
        ]
        cpu_s = tuple(min(run.cpu_s for run in of_one) for of_one in runs)
        by_peers: tuple[PeerHeard, ...] = ()
        if self._peers:
            sound = opened(case)
            by_peers = tuple(heard_by(peer, *sound) for peer in self._peers)
        return _FilmHeard(tuple(of_one[0] for of_one in runs), by_peers, read_s, cpu_s)


def sweep(
    cases: Iterable[Case],
    listeners: Sequence[Listener],
    peers: Sequence[Peer] = (),
    *,
    repeats: int = 1,
    jobs: int = 1,
    watch: Watcher | None = None,
    progress: Progress = no_progress,
) -> Sweep:
    """Listen to each film with every listener and peer in turn, to so many films at once as there are jobs.

    The processor time of a film is the least of so many repeats, after one that does not count. `watch` is told what
    the first listener heard in each film. Raises RuleError where there is no film.
    """
    tallies = tuple(Tally() for _ in listeners)
    others = tuple(PeerTally(peer) for peer in peers)
    longest: tuple[float, Path] | None = None
    total = len(cases) if isinstance(cases, Sized) else None
    progress("listening", 0, total)
    audience = _Audience(listeners, peers, repeats)
    for number, (case, done) in enumerate(each_of(audience, cases, jobs=jobs)):
        _require_inside(case, done.heard[0])
        for tally, heard, cpu_s in zip(tallies, done.heard, done.cpu_s, strict=True):
            found_ms = np.array([shot.onset for shot in heard.detection.shots], np.float64) * 1000.0 / heard.rate_hz
            tally.add(case, found_ms, minutes=done.minutes, spent=Spent(cpu_s, done.read_s))
        for other, by_peer in zip(others, done.peers, strict=True):
            other.add(case, by_peer)
        if watch is not None:
            watch(case, done.heard[0])
        longest = max(longest or (0.0, case.path), (done.minutes, case.path))
        progress("listening", number + 1, total)
    if longest is None:
        raise RuleError("study: no film to listen to")
    read_s, minutes = tallies[0].read_s, tallies[0].minutes
    scores = tuple(other.score(read_s=read_s, minutes=minutes) for other in others)
    return Sweep(tallies, scores, longest[1])

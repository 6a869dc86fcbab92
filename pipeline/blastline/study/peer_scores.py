"""A peer's counts at every threshold, and its scores at the best of them."""

import time
import warnings
from dataclasses import dataclass, field, replace

import msgspec
import numpy as np

from ..soundtrack import open_soundtrack
from .bootstrap import Interval, intervals
from .cases import Case
from .matching import Counts, Times
from .peers import Peer, Samples
from .tally import SCORED_MS, WINDOWS_MS, Cost, counted

_WARMING_S = 2


class PeerScore(msgspec.Struct, frozen=True):
    """The figures of a peer, each window's at the threshold that is best for that window.

    Precision, recall and the interval of F1 are those at 10 ms.
    """

    name: str
    thresholds_by_window_ms: dict[str, float]
    f1_by_window_ms: dict[str, float]
    precision: float
    recall: float
    f1_interval: Interval
    cost: Cost

    @property
    def f1(self) -> float:
        """Return F1 at 10 ms."""
        return self.f1_by_window_ms[f"{SCORED_MS:g}"]


@dataclass(frozen=True, eq=False)
class PeerHeard:
    """What a peer found in a film at each of its thresholds, ascending, and the processor time of one of them."""

    found_ms: tuple[Times, ...]
    cpu_s: float


def heard_by(peer: Peer, samples: Samples, rate_hz: int, opening_s: float) -> PeerHeard:
    """Let a peer listen to a film at each threshold; `opening_s` is the processor time that reading it took.

    What a library warns of is not the user's concern.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        began = time.process_time()
        prepared = peer.prepare(samples, rate_hz)
        prepared_s = time.process_time() - began
        began = time.process_time()
        found_ms = tuple(np.sort(peer.pick(prepared, rate_hz, threshold)) for threshold in peer.thresholds)
        picked_s = (time.process_time() - began) / len(peer.thresholds)
    return PeerHeard(found_ms, opening_s + prepared_s + picked_s)


def warm(peer: Peer) -> None:
    """Let a peer listen to a little noise, so that what a library does once is not counted."""
    noise = (1e-2 * np.random.default_rng(0).standard_normal(_WARMING_S * 48_000)).astype(np.float32)
    heard_by(replace(peer, thresholds=peer.thresholds[:1]), noise, 48_000, 0.0)


@dataclass
class PeerTally:
    """What grows from film to film, for each threshold and window."""

    peer: Peer
    films: dict[tuple[float, float], list[Counts]] = field(default_factory=dict)
    cpu_s: float = 0.0

    def add(self, case: Case, heard: PeerHeard) -> None:
        """Count what was found in one film."""
        self.cpu_s += heard.cpu_s
        for threshold, found_ms in zip(self.peer.thresholds, heard.found_ms, strict=True):
            for window_ms in WINDOWS_MS:
                self.films.setdefault((threshold, window_ms), []).append(counted(case, found_ms, window_ms))

    def score(self, *, read_s: float, minutes: float) -> PeerScore:
        """Return the scores; `read_s` and `minutes` are those of all films."""
        best = {window_ms: self._best(window_ms) for window_ms in WINDOWS_MS}
        scored = sum(self.films[best[SCORED_MS], SCORED_MS], Counts(0, 0, 0))
        return PeerScore(
            name=self.peer.name,
            thresholds_by_window_ms={f"{window_ms:g}": threshold for window_ms, threshold in best.items()},
            f1_by_window_ms={
                f"{window_ms:g}": sum(self.films[threshold, window_ms], Counts(0, 0, 0)).f1
                for window_ms, threshold in best.items()
            },
            precision=scored.precision,
            recall=scored.recall,
            f1_interval=intervals(self.films[best[SCORED_MS], SCORED_MS]).f1,
            cost=Cost(self.cpu_s / read_s, 60.0 * self.cpu_s / minutes),
        )

    def _best(self, window_ms: float) -> float:
        return max(self.peer.thresholds, key=lambda t: sum(self.films[t, window_ms], Counts(0, 0, 0)).f1)


def opened(case: Case) -> tuple[Samples, int, float]:
    """Return a film as detection hears it, its rate, and the processor time of reading it."""
    began = time.process_time()
    with open_soundtrack(case.path) as track:
        samples = np.concatenate([np.asarray(clip.heard, np.float32) for clip in track.blocks()])
        return samples, track.rate_hz, time.process_time() - began

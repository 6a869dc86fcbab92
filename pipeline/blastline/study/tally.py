"""Counts that grow from film to film, and the figures of a detector that follow from them."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import msgspec
import numpy as np

from .bootstrap import Intervals, intervals
from .cases import Case
from .matching import Counts, Times, count, match

WINDOWS_MS = (2.0, 10.0, 50.0, 500.0)
SCORED_MS, TIMED_MS = 10.0, 50.0
CLEAR_SNR_DB = 22.0
LEVELS_DB = {
    "<0": (-np.inf, 0.0),
    "0-6": (0.0, 6.0),
    "6-12": (6.0, 12.0),
    "12-22": (12.0, CLEAR_SNR_DB),
    ">=22": (CLEAR_SNR_DB, np.inf),
}
_BURST_TAIL_MS = 50.0


class Timing(msgspec.Struct, frozen=True):
    """How far found onsets are from the true ones: median and 95th percentile of the distance, and the median of the
    signed error, positive where the found one is late.
    """

    shots: int
    median_ms: float
    p95_ms: float
    bias_ms: float


class BurstScore(msgspec.Struct, frozen=True):
    """Of automatic fire: the share of its shots that is found, of bursts whose number of shots is exact, and the mean
    of found less true numbers, signed and not.
    """

    bursts: int
    shots: int
    recall: float
    exact: float
    mean_error: float
    mean_absolute_error: float


class Cost(msgspec.Struct, frozen=True):
    """Processor time of listening, as a multiple of soundfile reading the same files, and by the hour of film."""

    times_read: float
    cpu_s_per_hour: float


class DetectionScore(msgspec.Struct, frozen=True):
    """The figures of a detector; precision, recall, levels and intervals at 10 ms, window by window otherwise.

    What does not occur in the films is None.
    """

    name: str
    shots: int
    minutes: float
    precision: float
    recall: float
    f1_by_window_ms: dict[str, float]
    error_rate_by_window_ms: dict[str, float | None]
    intervals: Intervals
    recall_by_snr_db: dict[str, float]
    timing: Timing | None
    clear_timing: Timing | None
    bursts: BurstScore | None
    gun_free_minutes: float
    gun_free_false: int
    false_per_gun_free_hour: float | None
    cost: Cost

    @property
    def f1(self) -> float:
        """Return F1 at 10 ms."""
        return self.f1_by_window_ms[f"{SCORED_MS:g}"]


@dataclass(frozen=True)
class Spent:
    """The processor time of listening to a film and of reading it."""

    cpu_s: float
    read_s: float


@dataclass
class Tally:
    """The counts of one detector; `films` are its counts at 10 ms, film by film."""

    films: list[Counts] = field(default_factory=list)
    counts: dict[float, Counts] = field(default_factory=lambda: dict.fromkeys(WINDOWS_MS, Counts(0, 0, 0)))
    errors_ms: list[float] = field(default_factory=list)
    clear_errors_ms: list[float] = field(default_factory=list)
    levels: list[tuple[float, bool]] = field(default_factory=list)
    burst_shots: list[bool] = field(default_factory=list)
    burst_errors: list[int] = field(default_factory=list)
    minutes: float = 0.0
    free_minutes: float = 0.0
    free_false: int = 0
    cpu_s: float = 0.0
    read_s: float = 0.0

    def add(self, case: Case, found_ms: Times, *, minutes: float, spent: Spent) -> None:
        """Count what was found in one film; `found_ms` ascend."""
        for window_ms in WINDOWS_MS:
            self.counts[window_ms] += counted(case, found_ms, window_ms)
        self.films.append(counted(case, found_ms, SCORED_MS))
        hit = self._levels(case, found_ms)
        self._errors(case, found_ms)
        self._bursts(case, found_ms, hit)
        self.minutes += minutes
        self.cpu_s += spent.cpu_s
        self.read_s += spent.read_s
        if not case.true_ms.size:
            self.free_minutes += minutes
            self.free_false += self.films[-1].false

    def _levels(self, case: Case, found_ms: Times) -> set[int]:
        """Note which shots were found at 10 ms, by level, and return their indices."""
        hit = {shot for _, shot in matched(case, found_ms, SCORED_MS)}
        self.levels += [(float(level), index in hit) for index, level in enumerate(case.snr_db)]
        return hit

    def _errors(self, case: Case, found_ms: Times) -> None:
        for found, shot in matched(case, found_ms, TIMED_MS):
            if case.timed[shot]:
                places_ms = (float(case.true_ms[shot]), *_places(case, shot))
                error_ms = min((float(found_ms[found]) - at_ms for at_ms in places_ms), key=abs)
                self.errors_ms.append(error_ms)
                if not case.snr_db[shot] < CLEAR_SNR_DB and abs(error_ms) <= SCORED_MS:
                    self.clear_errors_ms.append(error_ms)

    def _bursts(self, case: Case, found_ms: Times, hit: set[int]) -> None:
        """Count the found onsets, and the true ones, from a burst's first shot to just after its last."""
        for burst in case.bursts:
            self.burst_shots += [index in hit for index in burst]
            first = min((*_places(case, burst[0]), case.true_ms[burst[0]])) - SCORED_MS
            last = float(case.true_ms[burst[-1]]) + _BURST_TAIL_MS
            found, true = (int(((ms >= first) & (ms <= last)).sum()) for ms in (found_ms, case.true_ms))
            self.burst_errors.append(found - true)

    def score(self, name: str) -> DetectionScore:
        """Return the figures of everything that was added."""
        scored = self.counts[SCORED_MS]
        return DetectionScore(
            name=name,
            shots=scored.hits + scored.missed,
            minutes=self.minutes,
            precision=scored.precision,
            recall=scored.recall,
            f1_by_window_ms={f"{window_ms:g}": c.f1 for window_ms, c in self.counts.items()},
            error_rate_by_window_ms={f"{window_ms:g}": c.error_rate for window_ms, c in self.counts.items()},
            intervals=intervals(self.films),
            recall_by_snr_db=_recall_by_level(self.levels),
            timing=_timing(self.errors_ms),
            clear_timing=_timing(self.clear_errors_ms),
            bursts=self._burst_score(),
            gun_free_minutes=self.free_minutes,
            gun_free_false=self.free_false,
            false_per_gun_free_hour=60.0 * self.free_false / self.free_minutes if self.free_minutes else None,
            cost=Cost(self.cpu_s / self.read_s, 60.0 * self.cpu_s / self.minutes),
        )

    def _burst_score(self) -> BurstScore | None:
        if not self.burst_errors:
            return None
        errors = np.array(self.burst_errors)
        return BurstScore(
            bursts=errors.size,
            shots=len(self.burst_shots),
            recall=float(np.mean(self.burst_shots)),
            exact=float(np.mean(errors == 0)),
            mean_error=float(np.mean(errors)),
            mean_absolute_error=float(np.mean(np.abs(errors))),
        )


def counted(case: Case, found_ms: Times, window_ms: float) -> Counts:
    """Return the counts of a film within a window."""
    return count(found_ms, case.true_ms, window_ms, alternatives_ms=case.alternatives_ms, forgiven_ms=case.forgiven_ms)


def matched(case: Case, found_ms: Times, window_ms: float) -> list[tuple[int, int]]:
    """Return which found onset is which shot of a film, wherever that may be said to begin, within a window."""
    return match(found_ms, case.true_ms, window_ms, case.alternatives_ms)


def _places(case: Case, shot: int) -> tuple[float, ...]:
    return case.alternatives_ms[shot] if case.alternatives_ms else ()


def _timing(errors_ms: Sequence[float]) -> Timing | None:
    if not errors_ms:
        return None
    distance_ms = np.abs(errors_ms)
    return Timing(
        len(errors_ms),
        float(np.median(distance_ms)),
        float(np.percentile(distance_ms, 95)),
        float(np.median(errors_ms)),
    )


def _recall_by_level(levels: Sequence[tuple[float, bool]]) -> dict[str, float]:
    shares: dict[str, float] = {}
    for name, (low, high) in LEVELS_DB.items():
        hits = [hit for level, hit in levels if low <= level < high]
        if hits:
            shares[name] = sum(hits) / len(hits)
    return shares

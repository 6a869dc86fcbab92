"""How well shots are found: a quality tier over scenes and recordings with a known truth."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..detect import find_shots, load_verifier
from ..errors import RuleError
from ..model import Clip, Quality
from ..ruleset import load_rules, rules_path
from ..soundtrack import open_soundtrack
from .corpus import load_sound, read_corpus
from .matching import Counts, Times, count, match, settled
from .truth import synthesised

WINDOWS_MS = (2.0, 10.0, 50.0)
CLEAR_SNR_DB = 22.0
_CORPUS_RATE_HZ = 48_000


@dataclass(frozen=True, eq=False)
class Case:
    """A film with a known truth: shots, their levels, and where else each may be said to begin.

    At `forgiven_ms` a detection is neither right nor wrong.
    """

    name: str
    path: Path | None
    clip: Clip | None
    true_ms: Times
    snr_db: Times
    alternatives_ms: tuple[tuple[float, ...], ...] = ()
    forgiven_ms: tuple[float, ...] = ()


class CaseScore(msgspec.Struct, frozen=True):
    """What was found in one film, at 10 ms."""

    name: str
    minutes: float
    hits: int
    false: int
    missed: int
    false_at_s: tuple[float, ...]
    missed_at_s: tuple[float, ...]


class DetectionScore(msgspec.Struct, frozen=True):
    """The scores of a tier: F1 by window, recall by level, onset errors of clear shots, false alarms without guns."""

    quality: Quality
    shots: int
    minutes: float
    precision: float
    recall: float
    f1_by_window_ms: dict[str, float]
    recall_by_snr_db: dict[str, float]
    clear_error_median_ms: float | None
    clear_error_p95_ms: float | None
    gun_free_minutes: float
    gun_free_false: int
    cases: tuple[CaseScore, ...]


def scenes(folder: Path) -> Iterator[Case]:
    """Synthesise each scene of a folder into a temporary one and yield it; RuleError where there is none."""
    files = sorted(folder.glob("*.toml"))
    if not files:
        raise RuleError(f"{folder}: no scene (*.toml) in it")
    for name, path, truth in synthesised(files):
        yield Case(
            name=name,
            path=path,
            clip=None,
            true_ms=np.array([shot.onset_s * 1000.0 for shot in truth.shots]),
            snr_db=np.array([shot.snr_db for shot in truth.shots]),
            alternatives_ms=tuple(
                tuple(at * 1000.0 / truth.rate_hz for at in shot.accept_samples) for shot in truth.shots
            ),
            forgiven_ms=tuple(each.at_s * 1000.0 for each in truth.negatives if each.kind == "explosion"),
        )


def recordings(folders: Sequence[Path]) -> Iterator[Case]:
    """Yield each recording of some corpora as a film of its own; levels are unknown (NaN)."""
    for recording in read_corpus(folders):
        samples = load_sound(recording, _CORPUS_RATE_HZ)
        onsets_ms = np.array(recording.onsets_s) * 1000.0
        yield Case(
            name=f"{recording.source}/{recording.path.stem}",
            path=None,
            clip=Clip(samples[:, None], _CORPUS_RATE_HZ),
            true_ms=onsets_ms,
            snr_db=np.full(onsets_ms.size, np.nan),
        )


def score(cases: Iterator[Case], quality: Quality, rules: Path | None = None) -> DetectionScore:
    """Run the detector over each case and return its scores."""
    read = load_rules(quality, rules)
    asked = read.tier.verify
    verifier = load_verifier(rules_path(f"verifier/{asked.model}", rules), networks=asked.networks)
    tally = _Tally()
    for case in cases:
        if case.clip is not None:
            found = find_shots([case.clip], rate_hz=case.clip.rate_hz, tier=read.tier, verifier=verifier)
            tally.add(case, [shot.onset for shot in found.shots], case.clip.rate_hz, case.clip.samples.shape[0])
        elif case.path is not None:
            with open_soundtrack(case.path) as track:
                found = find_shots(track.blocks(), rate_hz=track.rate_hz, tier=read.tier, verifier=verifier)
                tally.add(case, [shot.onset for shot in found.shots], track.rate_hz, track.source().frames)
    return tally.score(quality)


def heard(cases: Iterable[Case]) -> Iterator[tuple[NDArray[np.float32], int, Times]]:
    """Yield each case's samples as detection hears them, their rate, and the true onsets in milliseconds."""
    for case in cases:
        if case.clip is not None:
            yield np.asarray(case.clip.heard), case.clip.rate_hz, case.true_ms
        elif case.path is not None:
            with open_soundtrack(case.path) as track:
                yield np.concatenate([clip.heard for clip in track.blocks()]), track.rate_hz, case.true_ms


class _Tally:
    """Counts that grow from film to film."""

    def __init__(self) -> None:
        self.counts = dict.fromkeys(WINDOWS_MS, Counts(0, 0, 0))
        self.cases: list[CaseScore] = []
        self.errors_ms: list[float] = []
        self.levels: list[tuple[float, bool]] = []
        self.free_minutes, self.free_false = 0.0, 0

    def add(self, case: Case, onsets: Sequence[int], rate_hz: int, frames: int) -> None:
        """Count one film's onsets."""
        found_ms = np.array(onsets, np.float64) * 1000.0 / rate_hz
        forgiven_ms = [*case.forgiven_ms, *(at for others in case.alternatives_ms for at in others)]
        for window_ms in WINDOWS_MS:
            true_ms = settled(found_ms, case.true_ms, case.alternatives_ms, window_ms)
            self.counts[window_ms] += count(found_ms, true_ms, window_ms, forgiven_ms=forgiven_ms)
        true_ms = settled(found_ms, case.true_ms, case.alternatives_ms, 10.0)
        pairs = match(found_ms, true_ms, 10.0)
        hit = {true for _, true in pairs}
        used = {found for found, _ in pairs}
        self.levels += [(float(level), index in hit) for index, level in enumerate(case.snr_db)]
        self.errors_ms += [
            float(found_ms[found] - true_ms[true]) for found, true in pairs if not case.snr_db[true] < CLEAR_SNR_DB
        ]
        counts = count(found_ms, true_ms, 10.0, forgiven_ms=forgiven_ms)
        minutes = frames / rate_hz / 60.0
        if not case.true_ms.size:
            self.free_minutes += minutes
            self.free_false += counts.false
        false_s = tuple(round(float(ms) / 1000.0, 4) for i, ms in enumerate(found_ms) if i not in used)
        missed_s = tuple(round(float(ms) / 1000.0, 4) for i, ms in enumerate(true_ms) if i not in hit)
        self.cases.append(CaseScore(case.name, minutes, counts.hits, counts.false, counts.missed, false_s, missed_s))

    def score(self, quality: Quality) -> DetectionScore:
        """Return the scores of everything that was added."""
        middle = self.counts[10.0]
        errors = np.abs(self.errors_ms)
        return DetectionScore(
            quality=quality,
            shots=middle.hits + middle.missed,
            minutes=sum(case.minutes for case in self.cases),
            precision=middle.precision,
            recall=middle.recall,
            f1_by_window_ms={f"{window_ms:g}": c.f1 for window_ms, c in self.counts.items()},
            recall_by_snr_db=_recall_by_level(self.levels),
            clear_error_median_ms=float(np.median(errors)) if errors.size else None,
            clear_error_p95_ms=float(np.percentile(errors, 95)) if errors.size else None,
            gun_free_minutes=self.free_minutes,
            gun_free_false=self.free_false,
            cases=tuple(self.cases),
        )


def _recall_by_level(levels: Sequence[tuple[float, bool]]) -> dict[str, float]:
    bins = {"<12": (-np.inf, 12.0), "12-22": (12.0, CLEAR_SNR_DB), ">=22": (CLEAR_SNR_DB, np.inf)}
    shares: dict[str, float] = {}
    for name, (low, high) in bins.items():
        hits = [hit for level, hit in levels if low <= level < high]
        if hits:
            shares[name] = sum(hits) / len(hits)
    return shares

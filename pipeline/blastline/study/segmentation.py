"""How well shots are parted into blast and reflections, against what the truth of their scenes says is heard.

Conventions
    Once at the true onsets, which judges the parting alone, and once as a run finds the shots. A reflection is right
    within 2 ms of one that is heard, none is used twice. Asked for are the heard ones of at least -12 dB, 8-500 ms
    after the onset, by what is said to have -15 dB or more; of those claims, what is near none that is heard, however
    weak, is wrong. `every` asks for all that are heard at those delays, and counts all that are found there. A blast
    that is heard for longer than the rules let one be (`longest_blast_ms`) counts as that long.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..detect import Verifier, drop_claimed_reflections, find_shots, shot_at, verifier_of
from ..model import Clip, Quality, Reflection, Shot
from ..progress import Progress, no_progress
from ..ruleset import QualityRules, load_rules
from ..soundtrack import open_soundtrack
from ..synth import ShotTruth, Truth, film_scene, render_scene, truth_of
from .bars import Bar
from .bootstrap import Interval, intervals
from .cost import listened
from .matching import Counts, match
from .mixes import as_16_bit
from .truth import scenes_with_shots, synthesised

WINDOW_MS, ONSET_WINDOW_MS, START_WINDOW_MS = 2.0, 10.0, 10.0
"""A reflection is right within the first, a shot is found within the second, starts are compared within the third."""

THERE_MS = 0.5
"""What is found so near to an echo that is there, but masked, is neither right nor wrong."""

DELAYS_MS, LEAST_DB, LEVEL_TOLERANCE_DB = (8.0, 500.0), -12.0, 3.0
FILM_S, FILM_SHOTS, FILM_NEGATIVES = 60.0, 30, 20
Echo = TypeVar("Echo", bound=Reflection)


@dataclass(frozen=True, eq=False)
class Film:
    """A film as detection hears it, its truth, and its file where it has one."""

    name: str
    path: Path | None
    samples: NDArray[np.float32]
    truth: Truth


class Parting(msgspec.Struct, frozen=True):
    """The figures at one kind of onsets; errors in ms, None where there is nothing to compare.

    The ranges hold 95 of 100 draws of as many shots.
    """

    shots: int
    asked: int
    precision: float
    recall: float
    f1: float
    f1_range: Interval
    every_asked: int
    every_precision: float
    every_recall: float
    every_f1: float
    every_f1_range: Interval
    blasts_cut: int
    blast_median_ms: float | None
    blast_p95_ms: float | None
    start_median_ms: float | None
    start_p95_ms: float | None


class SegmentationScore(msgspec.Struct, frozen=True):
    """The figures of a tier, and how many of the echoes that are heard were taken for shots."""

    quality: Quality
    films: int
    at_true: Parting
    at_found: Parting
    echoes_heard: int
    echoes_as_shots: int
    found_shots: int

    @property
    def bars(self) -> tuple[Bar, ...]:
        """Return the figures beside what is asked of them."""
        rows = []
        for name, parting in (("true", self.at_true), ("found", self.at_found)):
            at = f"at {name} onsets"
            rows += [
                Bar(f"reflections at 2 ms, F1 {at}", parting.f1, 0.9, "", "above"),
                Bar(f"blast end, median error {at}", _known(parting.blast_median_ms), 1.0, "ms"),
                Bar(f"blast end, 95 % within {at}", _known(parting.blast_p95_ms), 5.0, "ms"),
                Bar(f"reflection start, median error {at}", _known(parting.start_median_ms), 1.0, "ms"),
                Bar(f"reflection start, 95 % within {at}", _known(parting.start_p95_ms), 5.0, "ms"),
            ]
        share = 100.0 * self.echoes_as_shots / max(self.echoes_heard, 1)
        return (*rows, Bar("echoes counted as shots", share, 1.0, "%"))


def scene_films(folder: Path) -> Iterator[Film]:
    """Yield the scenes of a folder that have shots, synthesised; RuleError for none."""
    for name, path, truth in synthesised(scenes_with_shots(folder)):
        with open_soundtrack(path) as track:
            yield Film(name, path, np.concatenate([clip.heard for clip in track.blocks()]).astype(np.float32), truth)


def random_films(seeds: Iterable[int]) -> Iterator[Film]:
    """Yield a minute of film for each seed, with 30 shots, some in bursts, and 20 sounds that are none."""
    for seed in seeds:
        audio = render_scene(film_scene(seed, FILM_S, FILM_SHOTS, FILM_NEGATIVES))
        samples = as_16_bit(audio.read(0, audio.frames)[:, 0])
        yield Film(f"film {seed}", None, samples.astype(np.float32), truth_of(audio))


def score(
    films: Iterable[Film], quality: Quality, rules: Path | None = None, *, progress: Progress = no_progress
) -> SegmentationScore:
    """Part the shots of each film and return the figures of a tier."""
    read = load_rules(quality, rules)
    verifier = verifier_of(read.tier, rules)
    longest_ms = read.tier.segment.longest_blast_ms
    at_true, at_found = PartingTally(longest_ms), PartingTally(longest_ms)
    count, echoes, mistaken, found_shots = 0, 0, 0, 0
    progress("listening", 0, None)
    for film in films:
        count += 1
        at_true.add(film.truth.shots, shots_at_truth(film, read.tier), film.truth.rate_hz)
        found = _found(film, read.tier, verifier)
        hits = _hits(film.truth, found)
        at_found.add([true for true, _ in hits], [shot for _, shot in hits], film.truth.rate_hz)
        heard = _heard_starts_ms(film.truth)
        taken = {shot.onset for _, shot in hits}
        left_ms = np.array([shot.onset for shot in found if shot.onset not in taken]) * 1000.0 / film.truth.rate_hz
        echoes, found_shots = echoes + heard.size, found_shots + len(found)
        mistaken += len(match(left_ms, heard, WINDOW_MS))
        progress("listening", count, None)
    return SegmentationScore(quality, count, at_true.parting(), at_found.parting(), echoes, mistaken, found_shots)


def shots_at_truth(film: Film, tier: QualityRules) -> tuple[Shot, ...]:
    """Return the true shots with the parts that detection finds from their true onsets on."""
    rate_hz = film.truth.rate_hz
    clip = Clip(film.samples[:, None], rate_hz)
    shots = [shot_at(true.onset_sample, clip, confidence=1.0, tier=tier) for true in film.truth.shots]
    return drop_claimed_reflections(shots, rate_hz=rate_hz, rules=tier.bursts)


def _found(film: Film, tier: QualityRules, verifier: Verifier) -> tuple[Shot, ...]:
    """Return the shots that a run finds, in all channels of a file."""
    if film.path is not None:
        return listened(film.path, tier, verifier).detection.shots
    clip = Clip(film.samples[:, None], film.truth.rate_hz)
    return find_shots([clip], rate_hz=film.truth.rate_hz, tier=tier, verifier=verifier).shots


def _hits(truth: Truth, found: Sequence[Shot]) -> list[tuple[ShotTruth, Shot]]:
    """Return the true shots that were found, each with what was found."""
    found_ms = np.array([shot.onset for shot in found]) * 1000.0 / truth.rate_hz
    true_ms = np.array([shot.onset_s for shot in truth.shots]) * 1000.0
    return [(truth.shots[true], found[index]) for index, true in match(found_ms, true_ms, ONSET_WINDOW_MS)]


def _heard_starts_ms(truth: Truth) -> NDArray[np.float64]:
    starts = [echo.start for shot in truth.shots for echo in shot.reflections if echo.audible]
    return np.sort(np.array(starts, np.float64)) * 1000.0 / truth.rate_hz


@dataclass
class PartingTally:
    """Counts of each shot, and errors; a blast counts as `longest_ms` long at most."""

    longest_ms: float
    cut: int = 0
    asked: list[Counts] = field(default_factory=list)
    every: list[Counts] = field(default_factory=list)
    blast_ms: list[float] = field(default_factory=list)
    start_ms: list[float] = field(default_factory=list)

    def add(self, truths: Sequence[ShotTruth], shots: Sequence[Shot], rate_hz: int) -> None:
        """Count the shots of a film, each beside its truth."""
        for truth, shot in zip(truths, shots, strict=True):
            late_ms = (shot.onset - truth.onset_sample) * 1000.0 / rate_hz
            heard = _in_reach([echo for echo in truth.reflections if echo.audible])
            found = _in_reach(shot.reflections)
            heard_ms = np.array([echo.delay_ms for echo in heard])
            found_ms = np.array([echo.delay_ms for echo in found]) + late_ms
            pairs = match(found_ms, heard_ms, WINDOW_MS)
            there_ms = np.array([echo.delay_ms for echo in truth.reflections])
            right = {index for index, _ in pairs}
            right |= {i for i, at in enumerate(found_ms) if np.any(np.abs(there_ms - at) <= THERE_MS)}
            self.every.append(Counts(len(pairs), found_ms.size - len(right), heard_ms.size - len(pairs)))
            strong = {index for index, echo in enumerate(heard) if echo.level_db >= LEAST_DB}
            claims = {index for index, echo in enumerate(found) if echo.level_db >= LEAST_DB - LEVEL_TOLERANCE_DB}
            hits = sum(index in claims and true in strong for index, true in pairs)
            self.asked.append(Counts(hits, len(claims - right), len(strong) - hits))
            starts = match(found_ms, heard_ms, START_WINDOW_MS)
            self.start_ms += [abs(float(found_ms[index] - heard_ms[true])) for index, true in starts]
            if truth.heard_blast is not None:
                blast_ms = (truth.heard_blast.stop - truth.onset_sample) * 1000.0 / rate_hz
                self.cut += blast_ms > self.longest_ms
                found_stop_ms = (shot.blast.stop - truth.onset_sample) * 1000.0 / rate_hz
                self.blast_ms.append(abs(found_stop_ms - min(blast_ms, self.longest_ms)))

    def parting(self) -> Parting:
        """Return the figures of everything that was added."""
        asked, every = (sum(each, Counts(0, 0, 0)) for each in (self.asked, self.every))
        return Parting(
            shots=len(self.asked),
            asked=asked.hits + asked.missed,
            precision=asked.precision,
            recall=asked.recall,
            f1=asked.f1,
            f1_range=intervals(self.asked).f1,
            every_asked=every.hits + every.missed,
            every_precision=every.precision,
            every_recall=every.recall,
            every_f1=every.f1,
            every_f1_range=intervals(self.every).f1,
            blasts_cut=self.cut,
            blast_median_ms=_percentile(self.blast_ms, 50.0),
            blast_p95_ms=_percentile(self.blast_ms, 95.0),
            start_median_ms=_percentile(self.start_ms, 50.0),
            start_p95_ms=_percentile(self.start_ms, 95.0),
        )


def _in_reach(echoes: Iterable[Echo]) -> list[Echo]:
    return sorted((e for e in echoes if DELAYS_MS[0] <= e.delay_ms <= DELAYS_MS[1]), key=lambda echo: echo.delay_ms)


def _percentile(errors_ms: Sequence[float], share: float) -> float | None:
    return float(np.percentile(errors_ms, share)) if errors_ms else None


def _known(figure: float | None) -> float:
    return float("nan") if figure is None else figure

"""How well guns of unseen sources are found: `python benchmarks/unseen.py --corpus DIR --models DIR`.

Leave one group out: the sources of the recordings are dealt into four groups, and each group's guns, mixed into its
own beds with as many other sounds, are looked for by models that have learnt from the other three and from synthetic
sounds (`unseen_models.py` trains them), one of each training seed. The mixes of each seed are drawn at 6 to 30 dB over
the bed both ways. Peers that are installed hear the same mixes, each at the threshold that is best for all of a seed.
"""

import tempfile
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from statistics import mean, stdev
from typing import get_args

import numpy as np
from unseen_models import TRAINING_SEEDS, model_path

from blastline.detect import load_verifier
from blastline.model import Quality
from blastline.ruleset import load_rules
from blastline.study.cases import Case
from blastline.study.cost import listened
from blastline.study.datasets import FOLDS
from blastline.study.detection import Listener
from blastline.study.matching import Counts, Times
from blastline.study.mixes import Levels
from blastline.study.peer_scores import PeerHeard, PeerTally, heard_by, opened
from blastline.study.peers import Peer, installed
from blastline.study.sources import StudySource
from blastline.study.tally import SCORED_MS, counted
from blastline.study.workers import each_of

READINGS = {"rms": Levels(6.0, 30.0, "rms"), "peak": Levels(6.0, 30.0, "peak")}
SHOWN_MS = (2.0, 10.0, 50.0)


@dataclass(frozen=True, eq=False)
class Audience:
    """All who listen to a film: the models of one group, a listener for each training seed, and the peers."""

    listeners: tuple[Listener, ...]
    peers: tuple[Peer, ...]

    def __call__(self, case: Case) -> tuple[list[Times], list[PeerHeard]]:
        """Return the onsets that each listener finds, in ms, and what each peer hears."""
        found_ms = []
        for each in self.listeners:
            heard = listened(case.path, each.tier, each.verifier)
            found_ms.append(np.array([s.onset for s in heard.detection.shots], np.float64) * 1e3 / heard.rate_hz)
        sound = opened(case) if self.peers else None
        return found_ms, [heard_by(peer, *sound) for peer in self.peers] if sound else []


@dataclass
class Found:
    """What the models of one training seed found in the mixes of one seed, all groups together."""

    films: list[tuple[Case, Times]] = field(default_factory=list)

    def counts(self, window_ms: float) -> Counts:
        """Return the counts within a window."""
        return sum((counted(case, found_ms, window_ms) for case, found_ms in self.films), Counts(0, 0, 0))

    @property
    def gun_free_false(self) -> int:
        """Return the false alarms in films without a gun."""
        return sum(counted(case, found_ms, SCORED_MS).false for case, found_ms in self.films if not case.true_ms.size)


def listeners_of(options: Namespace, group: int) -> tuple[Listener, ...]:
    """Return a listener for each tier and training seed, none of which has heard the group."""
    listeners = []
    for quality, seed in product(options.quality, TRAINING_SEEDS):
        tier, model = load_rules(quality).tier, model_path(options.models, seed, group)
        name = f"{quality}, training seed {seed}"
        listeners.append(Listener(name, tier, load_verifier(model, networks=tier.verify.networks), model))
    return tuple(listeners)


def cases_of(options: Namespace, levels: Levels, group: int, seed: int, into: Path) -> Iterator[Case]:
    """Make the mixes of a group and a seed, in a folder of their own."""
    into.mkdir()
    source = StudySource(corpus=tuple(options.corpus), mix=levels, fold=group, films=options.films, seed=seed)
    return source.cases(into, jobs=options.jobs)


def row(name: str, f1s: Sequence[float], *more: str) -> str:
    """Return a line of the table."""
    return "  ".join([f"{name:<48}", *(f"{f1:.3f}" for f1 in f1s), *more])


def measure(options: Namespace, reading: str, seed: int, audiences: Sequence[Audience]) -> dict[str, list[list[float]]]:
    """Print the rows of the mixes of one seed; return the F1 of each tier and training seed, window by window."""
    listeners = audiences[0].listeners
    found = [Found() for _ in listeners]
    tallies = [PeerTally(peer) for peer in audiences[0].peers]
    with tempfile.TemporaryDirectory(prefix="blastline-") as made:
        for group, audience in enumerate(audiences):
            cases = cases_of(options, READINGS[reading], group, seed, Path(made, str(group)))
            for case, (by_model, by_peer) in each_of(audience, cases, jobs=options.jobs):
                for one, found_ms in zip(found, by_model, strict=True):
                    one.films.append((case, found_ms))
                for tally, heard in zip(tallies, by_peer, strict=True):
                    tally.add(case, heard)
    f1s: dict[str, list[list[float]]] = {quality: [] for quality in options.quality}
    for (quality, _), listener, one in zip(product(options.quality, TRAINING_SEEDS), listeners, found, strict=True):
        f1 = [one.counts(window_ms).f1 for window_ms in SHOWN_MS]
        f1s[quality].append(f1)
        at = one.counts(SCORED_MS)
        more = f"{at.precision:.2f} / {at.recall:.2f}", str(one.gun_free_false)
        print(row(f"{reading}, mix seed {seed}, {listener.name}", f1, *more), flush=True)
    for tally in tallies:
        score = tally.score(read_s=1.0, minutes=1.0)
        f1 = [score.f1_by_window_ms[f"{window_ms:g}"] for window_ms in SHOWN_MS]
        print(row(f"{reading}, mix seed {seed}, {score.name}", f1), flush=True)
    return f1s


def main() -> None:
    """Write the table: F1 at 2, 10 and 50 ms, precision and recall at 10 ms, false alarms in films without a gun."""
    parser = ArgumentParser(description="How well guns of unseen sources are found.")
    parser.add_argument("--corpus", type=Path, action="append", required=True, help="a folder with annotations.csv")
    parser.add_argument("--models", type=Path, required=True, help="what unseen_models.py wrote")
    parser.add_argument("--quality", choices=get_args(Quality), nargs="+", default=["standard", "reference"])
    parser.add_argument("--mix-seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--films", type=int, default=20, help="minutes a group, mix seed and reading")
    parser.add_argument("--peers", action="store_true", help="let the installed peers hear the mixes too")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    peers = installed()[0] if options.peers else ()
    audiences = [Audience(listeners_of(options, group), peers) for group in range(FOLDS)]
    for reading in READINGS:
        by_seed = [measure(options, reading, seed, audiences) for seed in options.mix_seeds]
        for quality in options.quality:
            runs = [run for of_seed in by_seed for run in of_seed[quality]]
            for number, window_ms in enumerate(SHOWN_MS):
                f1s = [run[number] for run in runs]
                spread = f"{min(f1s):.3f} to {max(f1s):.3f}, standard deviation {stdev(f1s):.3f}"
                print(f"{reading}, {quality}, F1 at {window_ms:g} ms: mean {mean(f1s):.3f}, {spread}", flush=True)


if __name__ == "__main__":
    main()

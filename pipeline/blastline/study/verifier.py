"""The verifier as it is trained: from lessons to gate, screen and networks, and what these score on held-out ones.

    lessons (films, mixes, recordings in mixes) --> candidates --> gate --> screen --> spectrograms --> networks

Candidates on a shot's onset are positives, all others negatives. Gate and screen learn from the lessons of the first
seed as they are; the networks also learn from those of other seeds and from augmented copies.
"""

import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..detect.forest import forest_from
from ..detect.network import NetworkFile, network_from
from ..detect.spectrogram import Spectrograms, spectrograms
from ..detect.verify import SCHEMA, ModelFile, Sieve, Verifier
from ..ruleset import QualityRules, load_rules
from .candidates import Candidates, best_f1, candidates, concatenated
from .lesson_files import LessonFile, SeededDatasets, augmented_copies, load_augmented, write_lessons
from .mixes import MIX_S, RATE_HZ
from .networks import between
from .sieves import GATE_LOSS, GATE_SETTINGS, SCREEN_LOSS, SCREEN_SETTINGS, fit_sieves, sieved
from .training import FINE_TUNING, SETTINGS, Examples, fine_tune, fit_network

_Thing = TypeVar("_Thing")

AFTER_SHARE = 0.6
"""Of the weights of a fine-tuned network; the rest is as before."""


def training_tier(tier: QualityRules) -> QualityRules:
    """Return a tier that scans lessons: with lower jumps than for films, so that there is more to learn from.

    And with one silence for all, since the shipped model was trained so.
    """
    scan = {"jump_db": 3.0, "difference_jump_db": 3.0, "band_jump_db": 4.0, "floor_dbfs": -80.0, "range_db": 140.0}
    return msgspec.structs.replace(tier, scan=msgspec.structs.replace(tier.scan, **scan))


def listen(tier: QualityRules, item: tuple[int, LessonFile]) -> Candidates:
    """Return the candidates of a lesson, numbered."""
    return candidates(load_augmented(item[1]), tier, item[0])


def _look(item: tuple[LessonFile, Candidates]) -> tuple[NDArray[np.float16], NDArray[np.float16]]:
    """Return the spectrograms of candidates of a lesson, near and wide, in half precision."""
    lesson, found = item
    shown = spectrograms(load_augmented(lesson).samples, found.onsets, RATE_HZ, found.loudest)
    return shown.near.astype(np.float16), shown.wide.astype(np.float16)


def look(every: Candidates, lessons: Sequence[LessonFile], pool: ProcessPoolExecutor) -> Examples:
    """Return the spectrograms of candidates with their features and labels; they are in order of lessons."""
    numbers = np.unique(every.lesson).tolist()
    wanted = [(lessons[number], every.taken(every.lesson == number)) for number in numbers]
    near, wide = zip(*pool.map(_look, wanted, chunksize=4), strict=True)
    return Examples(np.concatenate(near), np.concatenate(wide), every.rows, every.shots)


def _network(examples: Examples, seed: int, number: int, size: str, known: Sequence[NetworkFile]) -> NetworkFile:
    """Return the network of a number: a known one fine-tuned, or a new one of a size, annealed and averaged in turns.

    Of a known one it is the mean of the weights before and after: what was forgotten of the old lessons comes back.
    """
    if number < len(known):
        return between(known[number], fine_tune(known[number], examples, seed + number), AFTER_SHARE)
    return fit_network(examples, seed + number, averaged=number % 2 == 1, size=size)


def score(
    model: ModelFile, held_out: Candidates, lessons: Sequence[LessonFile], pool: ProcessPoolExecutor
) -> dict[str, Any]:
    """Return the best F1 on held-out candidates, by the screen alone and by one to all networks."""
    left = sieved(held_out, model.gate, model.screen)
    seen = look(left, lessons, pool)
    shown = Spectrograms(seen.near.astype(np.float32), seen.wide.astype(np.float32))
    rows = left.rows.astype(np.float64)
    gate, screen = (Sieve(forest_from(sieve.forest), sieve.threshold) for sieve in (model.gate, model.screen))
    networks = tuple(network_from(network) for network in model.networks)
    f1 = [best_f1(screen.probabilities(rows), left)[0]]
    for count in range(len(networks)):
        f1.append(best_f1(Verifier(gate, screen, networks[: count + 1]).probabilities(rows, shown), left)[0])
    return {
        "shots": int(left.shots.sum()) + left.missed,
        "missed": left.missed,
        "f1_by_networks": [round(each, 4) for each in f1],
    }


def train(
    seeded: Sequence[SeededDatasets],
    work: Path,
    *,
    networks: Sequence[str],
    jobs: int,
    copies: int = 0,
    before: ModelFile | None = None,
) -> ModelFile:
    """Return a verifier trained on datasets, or one from before fine-tuned; the first seed is the model's.

    Its networks are of the sizes named, and see `copies` augmented copies of each lesson as well.
    """
    hear = partial(listen, training_tier(load_rules("reference").tier))
    seed = seeded[0].seed
    with ProcessPoolExecutor(jobs) as pool:
        lessons = [
            each
            for of_seed in seeded
            for dataset in of_seed.datasets
            for each in _said(write_lessons(work, dataset, of_seed.seed, pool), f"{dataset.name} of {of_seed.seed}")
        ]
        lessons += augmented_copies(lessons, copies, seed)
        numbered = list(enumerate(lessons))
        training = concatenated(list(pool.map(hear, [item for item in numbered if not item[1].held_out], chunksize=4)))
        _say(f"{training.shots.size} candidates to learn from, {int(training.shots.sum())} of them shots")
        gate, screen = fit_sieves(training.taken(_as_they_are(training, lessons)), seed)
        left = sieved(training, gate, screen)
        _say(f"{left.shots.size} of them pass gate and screen, {int(left.shots.sum())} of them shots")
        examples = look(left, lessons, pool)
        known = before.networks if before else []
        trained = [
            _said(_network(examples, seed, number, size, known), f"network {number + 1}")
            for number, size in enumerate(networks)
        ]
        record = _record(seeded, training, left, copies, before)
        model = ModelFile(SCHEMA, gate, screen, trained, record)
        scores = {}
        for name in {each.dataset: None for each in lessons if each.held_out}:
            held_out = [item for item in numbered if item[1].held_out and item[1].dataset == name]
            scores[name] = score(model, concatenated(list(pool.map(hear, held_out, chunksize=4))), lessons, pool)
    _say(f"held out: {scores}")
    return msgspec.structs.replace(model, training=record | {"held_out": scores})


def _as_they_are(training: Candidates, lessons: Sequence[LessonFile]) -> NDArray[np.bool_]:
    """Return which candidates gate and screen learn from: those of lessons that are no augmented copies."""
    originals = np.array([each.augmentation is None for each in lessons], bool)
    return np.asarray(originals[training.lesson], bool)


def _record(
    seeded: Sequence[SeededDatasets], training: Candidates, left: Candidates, copies: int, before: ModelFile | None
) -> dict[str, Any]:
    """Return how a model was trained: on which lessons, of which so much passed the sieves, and after which model."""
    first, *more = (
        {"seed": each.seed, "lessons": {dataset.name: dataset.count for dataset in each.datasets}} for each in seeded
    )
    record: dict[str, Any] = {
        "command": "python -m blastline.study.train",
        **first,
        "more": more,
        "minutes_each": MIX_S / 60.0,
        "again": copies,
        "candidates": int(training.shots.size),
        "shots": int(training.shots.sum()),
        "shots_without_candidate": training.missed,
        "passed": int(left.shots.size),
        "shots_passed": int(left.shots.sum()),
        "gate": GATE_SETTINGS | {"loss": GATE_LOSS},
        "screen": SCREEN_SETTINGS | {"loss": SCREEN_LOSS},
        "networks": asdict(SETTINGS),
    }
    if before is None:
        return record
    return record | {"further": asdict(FINE_TUNING), "after_share": AFTER_SHARE, "before": before.training}


def _said(thing: _Thing, what: str) -> _Thing:
    """Say that a thing is there, and return it."""
    _say(what)
    return thing


def _say(message: str) -> None:
    sys.stderr.write(message + "\n")
    sys.stderr.flush()

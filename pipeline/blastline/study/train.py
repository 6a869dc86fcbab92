"""Train the verifier: `python -m blastline.study.train --corpus DIR [--corpus DIR ...] -o rules/verifier/shots.json`.

Mixes of synthetic shots and negatives, and of recordings where a corpus is given, are scanned as a film is; each
candidate that lies on a shot's onset is a positive, every other one a negative. Histogram gradient boosting learns
the difference; the threshold comes from folds that hold out whole sources of recordings.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..detect.bandshape import bandshape_names
from ..detect.features import feature_names
from ..detect.find import described, let_all_pass, stretches
from ..detect.tracks import Grid, pieces
from ..detect.verify import ForestFile, ModelFile, Tree
from ..model import Clip
from ..ruleset import QualityRules, load_rules
from .corpus import Recording, read_corpus
from .lessons import MIX_S, RATE_HZ, Lesson, recorded_mix, synthetic_film, synthetic_mix
from .mixes import Mix

ON_TARGET_MS, NEAR_TARGET_MS = 8.0, 20.0
SHOCK_LEAD_MS, SHOCK_ON_TARGET_MS = 60.0, 3.0
SETTINGS = {
    "max_iter": 350,
    "learning_rate": 0.08,
    "max_leaf_nodes": 24,
    "min_samples_leaf": 30,
    "l2_regularization": 5.0,
    "max_features": 0.3,
}


GATE_SETTINGS = SETTINGS | {"max_iter": 40, "learning_rate": 0.2, "max_leaf_nodes": 10}
GATE_LOSS = 0.03


@dataclass(frozen=True, eq=False)
class Rows:
    """Of n candidates: rough shapes, features and labels; and how many shots had no candidate near."""

    sketches: NDArray[np.float64]
    features: NDArray[np.float64]
    labels: NDArray[np.bool_]
    missed: int


def label_candidates(film: Mix, tier: QualityRules) -> Rows:
    """Scan a mix and label its candidates: of those near a shot's onset the nearest is right, the others left out.

    Where the scan saw nothing there, because the shock of the bullet just before hides it, the shock is right.
    """
    grid = Grid(RATE_HZ)
    clip = Clip(film.samples[:, None], RATE_HZ)
    found = [(s.start, described(s, grid, tier, let_all_pass)) for s in stretches(pieces([clip], RATE_HZ))]
    at = np.concatenate([start + each.onsets for start, each in found])
    rows = np.concatenate([each.rows for _, each in found])
    sketches = np.concatenate([each.sketches for _, each in found])
    labels = np.zeros(at.size, bool)
    if not film.onsets.size or not at.size:
        return Rows(sketches, rows, labels, int(film.onsets.size))
    ms = 1000.0 / RATE_HZ
    gaps = np.abs(at[:, None] - film.onsets[None, :]) * ms
    nearest = gaps.argmin(axis=0)
    hit = gaps[nearest, np.arange(film.onsets.size)] <= ON_TARGET_MS
    labels[nearest[hit]] = True
    at_ms, onsets_ms, shocks_ms = (np.asarray(x * ms, np.float64) for x in (at, film.onsets, film.unsure))
    hit |= _label_shocks(labels, at_ms, onsets_ms[~hit], shocks_ms, onsets_ms)
    places_of_interest = np.concatenate([film.onsets, film.unsure])
    clear = labels | (np.abs(at[:, None] - places_of_interest[None, :]).min(axis=1) * ms > NEAR_TARGET_MS)
    return Rows(sketches[clear], rows[clear], labels[clear], int((~hit).sum()))


def _label_shocks(
    labels: NDArray[np.bool_],
    at_ms: NDArray[np.float64],
    missed_ms: NDArray[np.float64],
    shocks_ms: NDArray[np.float64],
    onsets_ms: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Label the candidates on the shocks of shots that were missed, and return which of all shots that settles."""
    settled = np.zeros(onsets_ms.size, bool)
    for onset_ms in missed_ms:
        own = shocks_ms[(shocks_ms < onset_ms) & (shocks_ms > onset_ms - SHOCK_LEAD_MS)]
        near = np.flatnonzero((np.abs(at_ms[:, None] - own[None, :]) <= SHOCK_ON_TARGET_MS).any(axis=1))
        if near.size:
            labels[near[0]] = True
            settled |= onsets_ms == onset_ms
    return settled


def gather(lesson: Lesson, count: int, tier: QualityRules, jobs: int) -> Rows:
    """Return the labelled candidates of lessons 0 to `count` as one, made by `jobs` processes."""
    with ProcessPoolExecutor(jobs) as pool:
        return join(list(pool.map(partial(_learn, lesson, tier), range(count), chunksize=4)))


def _learn(lesson: Lesson, tier: QualityRules, number: int) -> Rows:
    return label_candidates(lesson(number), tier)


def join(rows: Sequence[Rows]) -> Rows:
    """Return several sets of rows as one."""
    return Rows(
        np.concatenate([r.sketches for r in rows]),
        np.concatenate([r.features for r in rows]),
        np.concatenate([r.labels for r in rows]),
        sum(r.missed for r in rows),
    )


def fit(features: NDArray[np.float64], labels: NDArray[np.bool_], seed: int, settings: dict[str, Any]) -> Any:
    """Return a fitted scikit-learn classifier."""
    from sklearn.ensemble import HistGradientBoostingClassifier

    return HistGradientBoostingClassifier(random_state=seed, **settings).fit(features, labels)


def fit_gate(rows: Rows, seed: int) -> tuple[Any, float]:
    """Return the gate's classifier and the probability below which hardly a shot lies: `GATE_LOSS` of them.

    The threshold is taken from halves of the rows that the classifier was not fitted to.
    """
    half = np.random.default_rng(seed).random(rows.labels.size) < 0.5
    of_shots: list[NDArray[np.float64]] = []
    for part in (half, ~half):
        classifier = fit(rows.sketches[part], rows.labels[part], seed, GATE_SETTINGS)
        of_shots.append(classifier.predict_proba(rows.sketches[~part & rows.labels])[:, 1])
    threshold = float(np.quantile(np.concatenate(of_shots), GATE_LOSS))
    return fit(rows.sketches, rows.labels, seed, GATE_SETTINGS), threshold


def passed(rows: Rows, gate: Any, threshold: float) -> Rows:
    """Return the rows that the gate lets pass; a shot it holds back counts as missed."""
    kept = gate.predict_proba(rows.sketches)[:, 1] >= threshold
    lost = int(rows.labels[~kept].sum())
    return Rows(rows.sketches[kept], rows.features[kept], rows.labels[kept], rows.missed + lost)


def exported(classifier: Any, features: tuple[str, ...]) -> ForestFile:
    """Return a fitted classifier as `detect.verify` reads it."""
    trees: list[Tree] = []
    for (predictor,) in classifier._predictors:
        nodes = predictor.nodes
        leaf = nodes["is_leaf"].astype(bool)
        trees.append(
            Tree(
                feature=np.where(leaf, -1, nodes["feature_idx"]).tolist(),
                threshold=[
                    0.0 if end else value for end, value in zip(leaf, nodes["num_threshold"].tolist(), strict=True)
                ],
                left=np.where(leaf, 0, nodes["left"]).tolist(),
                right=np.where(leaf, 0, nodes["right"]).tolist(),
                value=np.where(leaf, nodes["value"], 0.0).tolist(),
            )
        )
    return ForestFile(features, float(classifier._baseline_prediction.ravel()[0]), trees)


def f1_at(probability: NDArray[np.float64], rows: Rows, threshold: float) -> float:
    """Return F1 over candidates, a shot without a candidate counted as missed."""
    taken = probability >= threshold
    hits = int((taken & rows.labels).sum())
    return 2.0 * hits / max(1, int(taken.sum()) + int(rows.labels.sum()) + rows.missed)


def held_out(parts: Sequence[Rows], synthetic: Rows, seed: int) -> dict[str, float]:
    """Return F1 on recordings of sources that training did not hear, and the threshold at which it is best.

    `parts` are rows of mixes whose recordings come from disjoint sets of sources.
    """
    scores: list[NDArray[np.float64]] = []
    kept: list[Rows] = []
    for out, part in enumerate(parts):
        heard = join([synthetic, *(rows for index, rows in enumerate(parts) if index != out)])
        gate = fit_gate(heard, seed)
        heard, tested = passed(heard, *gate), passed(part, *gate)
        classifier = fit(heard.features, heard.labels, seed, SETTINGS)
        scores.append(np.asarray(classifier.predict_proba(tested.features)[:, 1], np.float64))
        kept.append(tested)
    every, probability = join(kept), np.concatenate(scores)
    thresholds = np.linspace(0.05, 0.95, 91)
    f1 = [f1_at(probability, every, float(t)) for t in thresholds]
    best = int(np.argmax(f1))
    ceiling = 1.0 - every.missed / (every.missed + int(every.labels.sum()))
    return {
        "folds": len(parts),
        "f1": round(f1[best], 4),
        "threshold": round(float(thresholds[best]), 2),
        "f1_at_half": round(f1_at(probability, every, 0.5), 4),
        "candidate_recall": round(ceiling, 4),
    }


def train(corpus: Sequence[Path], *, synthetic: int, recorded: int, folds: int, seed: int, jobs: int) -> ModelFile:
    """Return a verifier trained on synthetic films and mixes and, where a corpus is given, on recordings."""
    tier = load_rules("reference").tier
    _say(f"{synthetic} synthetic films and {synthetic // 6} synthetic mixes")
    made = join(
        [
            gather(synthetic_film(seed), synthetic, tier, jobs),
            gather(synthetic_mix(seed + 1), synthetic // 6, tier, jobs),
        ]
    )
    parts: list[Rows] = []
    sources = _by_fold(read_corpus(corpus), folds, seed)
    for fold, recordings in enumerate(sources):
        _say(f"mixes of recordings, part {fold + 1} of {folds}")
        parts.append(gather(recorded_mix(recordings, seed + 2 + fold), -(-recorded // folds), tier, jobs))
    training: dict[str, Any] = {"command": "python -m blastline.study.train", "seed": seed, "settings": SETTINGS}
    training |= {"synthetic_films": synthetic, "synthetic_mixes": synthetic // 6, "minutes_each": MIX_S / 60.0}
    training |= {"recorded_mixes": recorded if parts else 0}
    if len(parts) > 1:
        training["held_out"] = held_out(parts, made, seed)
        _say(f"on sources left out: {training['held_out']}")
    every = join([made, *parts])
    gate, threshold = fit_gate(every, seed)
    rows = passed(every, gate, threshold)
    training |= {"candidates": int(every.labels.size), "positives": int(every.labels.sum()), "missed": every.missed}
    training |= {"passed_by_gate": int(rows.labels.size), "positives_passed": int(rows.labels.sum())}
    verdict = exported(fit(rows.features, rows.labels, seed, SETTINGS), feature_names())
    return ModelFile(1, exported(gate, bandshape_names()), threshold, verdict, training)


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m blastline.study.train", description="Train the verifier.")
    parser.add_argument("--corpus", type=Path, action="append", default=[], help="a folder with annotations.csv")
    parser.add_argument("--synthetic", type=int, default=240, help="synthetic films of a minute (default: %(default)s)")
    parser.add_argument("--recorded", type=int, default=240, help="mixes of recordings (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes (default: %(default)s)")
    parser.add_argument("--folds", type=int, default=4, help="folds that hold sources out (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    model = train(
        options.corpus,
        synthetic=options.synthetic,
        recorded=options.recorded,
        folds=options.folds,
        seed=options.seed,
        jobs=options.jobs,
    )
    options.output.write_bytes(msgspec.json.encode(model) + b"\n")


def _by_fold(recordings: Sequence[Recording], folds: int, seed: int) -> list[list[Recording]]:
    """Return recordings in parts that share no source, each with sources of shots and of negatives; none for none."""
    armed = {r.source for r in recordings if r.gunshot}
    parts: list[list[Recording]] = [[] for _ in range(folds)]
    rng = np.random.default_rng(seed)
    for sources in (sorted(armed), sorted({r.source for r in recordings} - armed)):
        rng.shuffle(sources)
        for place, source in enumerate(sources):
            parts[place % folds] += [r for r in recordings if r.source == source]
    return [part for part in parts if part]


def _say(message: str) -> None:
    sys.stderr.write(message + "\n")


if __name__ == "__main__":
    main()

"""Boosted trees that drop hopeless candidates: fitted with scikit-learn, exported for `detect.verify`."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..detect.bandshape import bandshape_names
from ..detect.features import feature_names
from ..detect.forest import ForestFile, Tree, forest_from
from ..detect.verify import Sieve, SieveFile
from .candidates import Candidates

_COMMON = {
    "min_samples_leaf": 30,
    "l2_regularization": 5.0,
    "max_features": 0.3,
    "early_stopping": False,
}
GATE_SETTINGS = _COMMON | {"max_iter": 40, "learning_rate": 0.2, "max_leaf_nodes": 10}
SCREEN_SETTINGS = _COMMON | {"max_iter": 120, "learning_rate": 0.12, "max_leaf_nodes": 20}
GATE_LOSS, SCREEN_LOSS = 0.01, 0.025


def sieved(every: Candidates, gate: SieveFile, screen: SieveFile) -> Candidates:
    """Return the candidates that pass gate and screen."""
    rows = every.rows.astype(np.float64)
    bandshapes = rows[:, : len(bandshape_names())]
    passed = Sieve(forest_from(gate.forest), gate.threshold).lets_pass(bandshapes)
    passed[passed] = Sieve(forest_from(screen.forest), screen.threshold).lets_pass(rows[passed])
    return every.taken(passed)


def fit_sieves(training: Candidates, seed: int) -> tuple[SieveFile, SieveFile]:
    """Return the gate, fitted to the rough shapes, and the screen, fitted to all features of what passes the gate."""
    names = bandshape_names()
    gate = fit_sieve(
        training.rows[:, : len(names)], training.shots, names=names, loss=GATE_LOSS, settings=GATE_SETTINGS, seed=seed
    )
    bandshapes = training.rows[:, : len(names)].astype(np.float64)
    past = training.taken(Sieve(forest_from(gate.forest), gate.threshold).lets_pass(bandshapes))
    screen = fit_sieve(
        past.rows, past.shots, names=feature_names(), loss=SCREEN_LOSS, settings=SCREEN_SETTINGS, seed=seed
    )
    return gate, screen


def fit_sieve(
    rows: NDArray[np.float32],
    shots: NDArray[np.bool_],
    *,
    names: tuple[str, ...],
    loss: float,
    settings: dict[str, Any],
    seed: int,
) -> SieveFile:
    """Return trees and the probability below which no more than a share `loss` of the shots lies.

    The threshold is taken from halves of the rows that the trees were not fitted to.
    """
    half = np.random.default_rng(seed).random(shots.size) < 0.5
    of_shots: list[NDArray[np.float64]] = []
    for part in (half, ~half):
        classifier = fit(rows[part], shots[part], settings, seed)
        of_shots.append(classifier.predict_proba(rows[~part & shots])[:, 1])
    threshold = float(np.quantile(np.concatenate(of_shots), loss))
    return SieveFile(threshold, exported(fit(rows, shots, settings, seed), names))


def fit(rows: NDArray[np.float32], shots: NDArray[np.bool_], settings: dict[str, Any], seed: int) -> Any:
    """Return histogram gradient boosting fitted to the rows."""
    from sklearn.ensemble import HistGradientBoostingClassifier

    return HistGradientBoostingClassifier(random_state=seed, **settings).fit(rows, shots)


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

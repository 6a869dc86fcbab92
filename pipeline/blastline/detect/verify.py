"""The verifier: two sieves of boosted trees and the networks that judge what is left.

Trained offline (`study.train`) and shipped as one readable JSON file.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..errors import RuleError
from ..ruleset import QualityRules, verifier_path
from .bandshape import bandshape_names
from .contrast import contrasts
from .features import feature_names
from .forest import Forest, ForestFile, forest_from, forest_log_odds, probabilities
from .network import Network, NetworkFile, is_compatible, network_from, network_log_odds
from .spectrogram import Spectrograms

SCHEMA = 4
CONFIDENT_LOG_ODDS = 2.5
"""Log-odds of 92 to 8: hardly a second opinion turns them over."""

SCREEN_WEIGHT = 0.5
"""The weight of the screen, where each network has 1: docs/training.md, Trees, networks, or both."""

_DIGITS = 4
_SMALLEST = 0.5 * 10.0**-_DIGITS  # of probabilities, before they are rounded to 0


class SieveFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A forest and the probability below which it drops a candidate."""

    threshold: float
    forest: ForestFile


class ModelFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """`verifier/*.json`: the sieves, the networks, and how they were trained."""

    schema: int
    gate: SieveFile
    screen: SieveFile
    networks: list[NetworkFile]
    training: dict[str, Any]


class _SealedModelFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The same file, its networks still text: most of the file, and most tiers ask few of them."""

    schema: int
    gate: SieveFile
    screen: SieveFile
    networks: list[msgspec.Raw]
    training: dict[str, Any]


@dataclass(frozen=True, eq=False)
class Sieve:
    """A forest that drops candidates below its threshold."""

    forest: Forest
    threshold: float

    def lets_pass(self, rows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return whether each row may be a shot's, shape (n,)."""
        return self.probabilities(rows) >= self.threshold

    def probabilities(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the probability that each row is a shot's, shape (n,)."""
        return probabilities(rows, self.forest)


Look = Callable[[NDArray[np.intp]], Spectrograms]
"""Shows some of the candidates, by their indices, once more in another way."""


@dataclass(frozen=True, eq=False)
class Verdicts:
    """Of n candidates: the probability that each is a shot, that by the screen alone, and how many networks judged.

    Shape (n,) each; probabilities are to four digits.
    """

    probability: NDArray[np.float64]
    screen_probability: NDArray[np.float64]
    networks: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class LogOdds:
    """The log-odds of n candidates, shape (n,): by screen and networks together, and by the networks alone.

    `as_burst` are those by the networks of a candidate in a long row as if no more than a burst of it were there.
    """

    by_all: NDArray[np.float64]
    by_networks: NDArray[np.float64]
    as_burst: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Verifier:
    """The gate, by rough shapes; the screen, by shape and neighbourhood; the networks, which also see spectrograms."""

    gate: Sieve
    screen: Sieve
    networks: tuple[Network, ...]

    def probabilities(self, rows: NDArray[np.float64], shown: Spectrograms) -> NDArray[np.float64]:
        """Return the probability that each candidate is a shot, shape (n,)."""
        return self.verdicts(rows, shown).probability

    def verdicts(self, rows: NDArray[np.float64], shown: Spectrograms, looks: Sequence[Look] = ()) -> Verdicts:
        """Return what is thought of each candidate, by screen and networks.

        Trees and networks err in different places. A further network is asked only where those before it leave room
        for doubt. Where all of them do, they are asked again at each of the further `looks`, and what they say in the
        mean counts (test-time augmentation). To four digits: beyond them the sums depend on how many candidates are
        judged together.
        """
        by_screen, seen = forest_log_odds(rows, self.screen.forest), contrasts(shown)
        network_sum, odds, networks = np.zeros(rows.shape[0]), np.zeros(rows.shape[0]), np.zeros(rows.shape[0], np.intp)
        open_to_doubt = np.arange(rows.shape[0])
        for asked, network in enumerate(self.networks, start=1):
            network_sum[open_to_doubt] += network_log_odds(network, rows[open_to_doubt], seen.taken(open_to_doubt))
            odds[open_to_doubt] = combined_log_odds(network_sum[open_to_doubt], asked, by_screen[open_to_doubt])
            networks[open_to_doubt] = asked
            open_to_doubt = open_to_doubt[np.abs(odds[open_to_doubt]) < CONFIDENT_LOG_ODDS]
        if open_to_doubt.size and looks:
            doubted = rows[open_to_doubt]
            for again in (contrasts(look(open_to_doubt)) for look in looks):
                network_sum[open_to_doubt] += sum(network_log_odds(each, doubted, again) for each in self.networks)
            mean_sum = network_sum[open_to_doubt] / (1 + len(looks))
            odds[open_to_doubt] = combined_log_odds(mean_sum, len(self.networks), by_screen[open_to_doubt])
        return Verdicts(_probability(odds), _probability(by_screen), networks)


def combined_log_odds(
    network_sum: NDArray[np.float64], networks: int, by_screen: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the weighted mean log-odds, shape (n,), of `networks` networks, whose sum is `network_sum`, and the screen
    at weight `SCREEN_WEIGHT`.
    """
    return (network_sum + SCREEN_WEIGHT * by_screen) / (networks + SCREEN_WEIGHT)


def log_odds_in(verdicts: Verdicts) -> LogOdds:
    """Return the log-odds of n verdicts, shape (n,).

    From the rounded probabilities, so that they do not depend on how many candidates are judged together either.
    """
    by_all, by_screen = log_odds_of(verdicts.probability), log_odds_of(verdicts.screen_probability)
    by_networks = by_all + (by_all - by_screen) * (SCREEN_WEIGHT / verdicts.networks)
    return LogOdds(by_all, by_networks, by_networks)


def log_odds_of(probability: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Return the log-odds of probabilities, in their shape; those of 0 and 1 are what rounding may have left them."""
    p = np.clip(probability, _SMALLEST, 1.0 - _SMALLEST)
    return np.asarray(np.log(p / (1.0 - p)), np.float64)


def verifier_of(tier: QualityRules, overlay: Path | None = None) -> Verifier:
    """Read the verifier that a tier asks for, the user's model where there is one; RuleError as `read_model`."""
    return load_verifier(verifier_path(tier, overlay), networks=tier.verify.networks)


def load_verifier(path: Path, *, networks: int) -> Verifier:
    """Read the sieves and the first `networks` networks of a model file; RuleError as `read_model`.

    A file that has not changed since is not read again: that takes longer than a short film.
    """
    try:
        status = path.stat()
    except OSError as error:
        raise RuleError(f"{path}: not a verifier model: {error}") from error
    return _read_once(path, networks, (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns))


@lru_cache(maxsize=2)
def _read_once(path: Path, networks: int, _version: tuple[int, ...]) -> Verifier:
    model = read_model(path, networks=networks)
    gate, screen = (Sieve(forest_from(sieve.forest), sieve.threshold) for sieve in (model.gate, model.screen))
    return Verifier(gate, screen, tuple(network_from(network) for network in model.networks))


def read_model(path: Path, *, networks: int | None = None) -> ModelFile:
    """Read a model file with its first `networks` networks, or all.

    Raises RuleError where it has fewer, or what is read does not fit this version's features and spectrograms.
    """
    try:
        sealed = msgspec.json.decode(path.read_bytes(), type=_SealedModelFile)
    except (OSError, msgspec.DecodeError) as error:
        raise RuleError(f"{path}: not a verifier model: {error}") from error
    if sealed.schema != SCHEMA:
        raise RuleError(f"{path}: schema = {sealed.schema}: expected {SCHEMA}")
    for name, expected in (("gate", bandshape_names()), ("screen", feature_names())):
        sieve: SieveFile = getattr(sealed, name)
        if sieve.forest.features != expected:
            got = len(sieve.forest.features)
            raise RuleError(f"{path}: {name}.forest.features: expected the {len(expected)} of this version, got {got}")
    there = len(sealed.networks)
    if networks is not None and there < networks:
        raise RuleError(f"{path}: networks: expected at least {networks}, as [verify] asks, got {there}")
    opened = [_network(path, number, text) for number, text in enumerate(sealed.networks[:networks])]
    return ModelFile(sealed.schema, sealed.gate, sealed.screen, opened, sealed.training)


def _network(path: Path, number: int, text: msgspec.Raw) -> NetworkFile:
    try:
        network = msgspec.json.decode(text, type=NetworkFile)
    except msgspec.DecodeError as error:
        raise RuleError(f"{path}: not a verifier model: networks[{number}]: {error}") from error
    if not is_compatible(network, len(feature_names())):
        raise RuleError(f"{path}: networks[{number}]: expected layers for the features and pictures of this version")
    return network


def _probability(odds: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return log-odds as probabilities, to `_DIGITS`."""
    return np.asarray(np.round(1.0 / (1.0 + np.exp(-odds)), _DIGITS), np.float64)

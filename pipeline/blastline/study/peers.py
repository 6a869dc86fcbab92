"""What others find in the same films: librosa's onset detection, at whichever threshold suits it best."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .matching import Counts, Times, count

HOP_MS = 5.0
THRESHOLDS = (0.05, 0.1, 0.2, 0.4, 0.8)


@dataclass(frozen=True)
class PeerScore:
    """A peer's threshold and its counts at each window in milliseconds."""

    threshold: float
    counts: dict[float, Counts]


def librosa_onsets(samples: NDArray[np.float32], rate_hz: int, threshold: float) -> Times:
    """Return the onsets that librosa finds (spectral flux, backtracked to the rise), in milliseconds."""
    from librosa.onset import onset_backtrack, onset_detect, onset_strength

    hop = max(1, round(HOP_MS * rate_hz / 1000.0))
    strength = onset_strength(y=samples, sr=rate_hz, hop_length=hop)
    found = onset_detect(onset_envelope=strength, sr=rate_hz, hop_length=hop, delta=threshold)
    if len(found) == 0:
        return np.empty(0)
    return np.unique(onset_backtrack(found, strength)) * (1000.0 * hop / rate_hz)


def best_librosa_score(
    films: Iterable[tuple[NDArray[np.float32], int, Times]], windows_ms: Iterable[float], best_at_ms: float
) -> PeerScore:
    """Return librosa's score over films (samples, rate, true onsets) at the threshold with the best F1.

    The threshold is chosen on what is scored, which flatters the peer.
    """
    windows = tuple(windows_ms)
    none = Counts(0, 0, 0)
    tallies = {threshold: dict.fromkeys(windows, none) for threshold in THRESHOLDS}
    for samples, rate_hz, true_ms in films:
        for threshold, tally in tallies.items():
            found_ms = librosa_onsets(samples, rate_hz, threshold)
            for window_ms in windows:
                tally[window_ms] += count(found_ms, true_ms, window_ms)
    best = max(THRESHOLDS, key=lambda threshold: tallies[threshold][best_at_ms].f1)
    return PeerScore(best, tallies[best])

"""The candidates of a chunk: where the scan saw a rise, the features of each, and its onset to the sample.

    places of the scan -> rough shapes -> gate -> all features -> screen -> onsets

Gate and screen are given by the caller: detection drops the hopeless there, training keeps every candidate.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..ruleset import OnsetRules, QualityRules
from ..units import samples_from_ms
from .bandshape import band_levels, bandshape
from .chunks import Chunk
from .features import features
from .neighbours import neighbourhood
from .onset import farthest_ms, refine_onsets
from .pace import automatic
from .scan import CRACK_MS, candidate_steps
from .sparse import bands_near
from .tracks import Grid

_SOUND_MS = 2.0  # the crack of a bullet is over so soon after its onset
_SAME_ONSET_MS = 3.0  # candidates of one rise, which the refined onset has brought together


@dataclass(frozen=True, eq=False)
class CandidateFeatures:
    """Candidates of a chunk: onsets as indices into it, ascending, shape (n,), and their features, (n, features).

    `beyond` are the onsets of those outside its core, which are another chunk's: rows go on there.
    """

    onsets: NDArray[np.intp]
    rows: NDArray[np.float64]
    beyond: NDArray[np.intp]


Passes = Callable[[NDArray[np.float64], NDArray[np.intp]], NDArray[np.bool_]]
"""Says of each row of a table, whose candidates' places in the chunk are given, whether it is worth a closer look."""


def let_all_pass(rows: NDArray[np.float64], places: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Let every candidate pass, as training needs it; shape (n,)."""
    return np.ones(rows.shape[0], bool)


def candidate_places(chunk: Chunk, grid: Grid, tier: QualityRules) -> NDArray[np.intp]:
    """Return roughly where a chunk's n candidates are, as indices into it, ascending, shape (n,)."""
    pace = automatic(tier.bursts)
    steps = candidate_steps(chunk.peak, chunk.slope, chunk.bands, grid=grid, rules=tier.scan, pace=pace)
    places = steps * grid.step
    return places[places < chunk.stop - chunk.start]


def describe_candidates(
    chunk: Chunk, grid: Grid, tier: QualityRules, *, gate: Passes, screen: Passes, reach: int = 0
) -> CandidateFeatures:
    """Return the core's candidates that pass the gate, by their rough shapes, and the screen, by all features.

    The onset of those that are left is found to the sample. Both are also asked about those up to `reach` samples
    outside the core.
    """
    places = candidate_places(chunk, grid, tier)
    bands = chunk.bands if chunk.bands.size else bands_near(chunk.samples, places, grid)
    levels = band_levels(bands, places, grid)
    chosen = np.flatnonzero(_near_core(chunk, places, max(reach, _onset_margin(grid, tier))))
    bandshapes = bandshape(levels[chosen])
    passed = gate(bandshapes, places[chosen])
    chosen, bandshapes = chosen[passed], bandshapes[passed]
    rows = features(bandshapes, neighbourhood(places, levels, chosen, grid.rate_hz))
    passed = screen(rows, places[chosen])
    chosen, rows = chosen[passed], rows[passed]
    onsets = _onsets(chunk.samples, places, chosen, rate_hz=grid.rate_hz, rules=tier.onset)
    kept = well_apart(onsets, samples_from_ms(_SAME_ONSET_MS, grid.rate_hz))
    inside = _near_core(chunk, onsets[kept], 0) & (onsets[kept] + chunk.start < chunk.stop)
    return CandidateFeatures(onsets[kept[inside]], rows[kept[inside]], beyond=onsets[kept[~inside]])


def _near_core(chunk: Chunk, places: NDArray[np.intp], reach: int) -> NDArray[np.bool_]:
    """Return which of n places of a chunk lie in its core or at most so many samples outside, shape (n,)."""
    in_film = places + chunk.start
    return np.asarray((in_film >= chunk.core.start - reach) & (in_film < chunk.core.stop + reach))


def _onset_margin(grid: Grid, tier: QualityRules) -> int:
    """Return how far outside the core a candidate may be seen whose onset is found to lie inside."""
    return samples_from_ms(farthest_ms(tier.onset), grid.rate_hz)


def _onsets(
    samples: NDArray[np.float32],
    places: NDArray[np.intp],
    chosen: NDArray[np.intp],
    *,
    rate_hz: int,
    rules: OnsetRules,
) -> NDArray[np.intp]:
    """Return the onsets of the chosen places, shape (n,).

    One that would be that of the place before it is looked for after that one's sound: of a bullet's crack and the
    blast of the rifle both have an onset. Where none is there, both places are of one sound.
    """
    find = partial(refine_onsets, samples, rate_hz=rate_hz, rules=rules)
    onsets = find(places[chosen])
    earlier = np.searchsorted(places, places[chosen] - samples_from_ms(CRACK_MS, rate_hz), side="right") - 1
    gaps = np.where(earlier >= 0, places[chosen] - places[earlier], samples.shape[0])
    second = np.flatnonzero(gaps <= samples_from_ms(farthest_ms(rules), rate_hz))
    if second.size:
        before = find(places[earlier[second]])
        same = onsets[second] - before < samples_from_ms(_SAME_ONSET_MS, rate_hz)
        second, before = second[same], before[same]
        after = before + samples_from_ms(_SOUND_MS, rate_hz)
        again = find(places[chosen[second]], since=after)
        onsets[second] = np.where(again >= after, again, before)
    return onsets


def well_apart(onsets: NDArray[np.intp], apart: int) -> NDArray[np.intp]:
    """Return which onsets to keep so that any two are at least `apart` samples from each other.

    They are taken in order of time, each that follows the one taken last by enough; what is returned are their indices.

    >>> well_apart(np.array([500, 100, 140]), apart=50).tolist()
    [1, 0]
    """
    taken: list[int] = []
    for index in np.argsort(onsets, kind="stable").tolist():
        if not taken or onsets[index] - onsets[taken[-1]] >= apart:
            taken.append(index)
    return np.array(taken, np.intp)

"""The detector's story: stretches of the film go by, and what is a shot in each one's core is kept."""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from ..model import Clip, Rejection, Shot, Span
from ..ruleset import QualityRules
from ..units import samples_from_ms
from .bursts import group_bursts, keep_apart
from .features import features
from .onset import refine_onsets
from .scan import candidate_steps
from .segment import segment
from .tracks import Grid, Piece, pieces
from .verify import Verifier, probabilities

# A piece is about half a second. Before the core: the neighbourhood of `features`; after it: the longest decay.
LEFT_PIECES, CORE_PIECES, RIGHT_PIECES = 8, 32, 6
_SAME_ONSET_MS = 3.0


@dataclass(frozen=True)
class Detection:
    """What was found in a film: shots and rejections, both in order."""

    shots: tuple[Shot, ...]
    rejections: tuple[Rejection, ...]


@dataclass(frozen=True, eq=False)
class Stretch:
    """A few seconds of film with its tracks; the shots whose onset lies in `core` are this stretch's to find."""

    samples: NDArray[np.float32]
    peak: NDArray[np.float32]
    slope: NDArray[np.float32]
    bands: NDArray[np.float32]
    start: int
    stop: int
    core: Span


def find_shots(blocks: Iterable[Clip], *, rate_hz: int, tier: QualityRules, verifier: Verifier) -> Detection:
    """Return the gunshots of a film, given as blocks in order, in constant memory."""
    shots: list[Shot] = []
    rejections: list[Rejection] = []
    for stretch in stretches(pieces(blocks, rate_hz)):
        found, refused = _search(stretch, Grid(rate_hz), tier, verifier)
        shots += found
        rejections += refused
    kept, dropped = keep_apart(shots, rate_hz=rate_hz, rules=tier.bursts)
    return Detection(
        shots=group_bursts(kept, rate_hz=rate_hz, rules=tier.bursts),
        rejections=tuple(sorted(chain(rejections, dropped), key=lambda r: r.at_sample)),
    )


def stretches(film: Iterable[Piece]) -> Iterator[Stretch]:
    """Yield overlapping stretches whose cores tile the film.

    |left|    core    |right|
                 |left|    core    |right|
    """
    held: deque[Piece] = deque()
    left, start = 0, 0
    for piece in film:
        held.append(piece)
        if len(held) == left + CORE_PIECES + RIGHT_PIECES:
            yield _join(held, start, left, CORE_PIECES)
            for _ in range(left + CORE_PIECES - LEFT_PIECES):
                start += held.popleft().samples.shape[0]
            left = LEFT_PIECES
    if len(held) > left:
        yield _join(held, start, left, len(held) - left)


def _join(held: Iterable[Piece], start: int, left: int, core: int) -> Stretch:
    parts = list(held)
    size = parts[0].samples.shape[0]
    stop = start + sum(p.frames for p in parts)
    return Stretch(
        samples=np.concatenate([p.samples for p in parts]),
        peak=np.concatenate([p.peak for p in parts]),
        slope=np.concatenate([p.slope for p in parts]),
        bands=np.concatenate([p.bands for p in parts]),
        start=start,
        stop=stop,
        core=Span(start + left * size, start + (left + core) * size),
    )


def candidates(stretch: Stretch, grid: Grid, tier: QualityRules) -> NDArray[np.intp]:
    """Return the onsets of a stretch's candidates, as indices into it, ascending."""
    steps = candidate_steps(stretch.peak, stretch.slope, stretch.bands, grid=grid, rules=tier.scan)
    onsets = refine_onsets(stretch.samples, steps * grid.step, rate_hz=grid.rate_hz, rules=tier.onset)
    onsets = np.unique(onsets[onsets < stretch.stop - stretch.start])
    apart = samples_from_ms(_SAME_ONSET_MS, grid.rate_hz)
    return onsets[np.diff(onsets, prepend=-apart) >= apart]


def described(stretch: Stretch, grid: Grid, tier: QualityRules) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return the onsets of the core's candidates, as indices into the stretch, and their features."""
    onsets = candidates(stretch, grid, tier)
    at = onsets + stretch.start
    wanted = (at >= stretch.core.start) & (at < stretch.core.stop)
    return onsets[wanted], features(stretch.samples, stretch.bands, onsets, wanted, grid=grid)


def _search(stretch: Stretch, grid: Grid, tier: QualityRules, verifier: Verifier) -> tuple[list[Shot], list[Rejection]]:
    onsets, rows = described(stretch, grid, tier)
    surety = probabilities(rows, verifier)
    shots = [
        segment(
            stretch.samples,
            int(onset),
            film_start=stretch.start,
            film_stop=stretch.stop,
            confidence=float(p),
            rate_hz=grid.rate_hz,
            rules=tier.segment,
        )
        for onset, p in zip(onsets, surety, strict=True)
        if p >= tier.verify.threshold
    ]
    refused = [
        Rejection(int(onset) + stretch.start, "does not sound like a shot", {"probability": float(p)})
        for onset, p in zip(onsets, surety, strict=True)
        if tier.verify.report_from <= p < tier.verify.threshold
    ]
    return shots, refused

"""The detector's story: stretches of the film go by, and what is a shot in each one's core is kept."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from ..model import Clip, Rejection, Shot, Span
from ..ruleset import QualityRules
from ..units import samples_from_ms
from .bandshape import band_levels, bandshape
from .bursts import group_bursts, in_company, keep_apart, part_from_echoes, without_echoes
from .features import features
from .neighbours import neighbourhood
from .onset import farthest_ms, refine_onsets
from .picture import pictures
from .scan import candidate_steps
from .segment import segment
from .tracks import Grid, Piece, pieces
from .verify import Verifier

# A piece is about half a second. Before the core: the neighbourhood of `features`; after it: the longest decay.
LEFT_PIECES, CORE_PIECES, RIGHT_PIECES = 8, 64, 6
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


@dataclass(frozen=True, eq=False)
class Described:
    """Candidates of a stretch: onsets as indices into it, ascending, and their features."""

    onsets: NDArray[np.intp]
    rows: NDArray[np.float64]


Test = Callable[[NDArray[np.float64]], NDArray[np.bool_]]
"""Says of each row of a table whether its candidate is worth a closer look."""


def let_all_pass(rows: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Let every candidate pass, as training needs it."""
    return np.ones(rows.shape[0], bool)


def find_shots(blocks: Iterable[Clip], *, rate_hz: int, tier: QualityRules, verifier: Verifier) -> Detection:
    """Return the gunshots of a film, given as blocks in order, in constant memory."""
    shots: list[Shot] = []
    rejections: list[Rejection] = []
    for stretch in stretches(pieces(blocks, rate_hz)):
        found, refused = _search(stretch, Grid(rate_hz), tier, verifier)
        shots += found
        rejections += refused
    believed, alone = in_company(shots, rate_hz=rate_hz, rules=tier.verify)
    kept, dropped = keep_apart(believed, rate_hz=rate_hz, rules=tier.bursts)
    fired, echoes = without_echoes(kept, rate_hz=rate_hz, rules=tier.bursts)
    parted = part_from_echoes(fired, rate_hz=rate_hz, rules=tier.bursts)
    return Detection(
        shots=group_bursts(parted, rate_hz=rate_hz, rules=tier.bursts),
        rejections=tuple(sorted(chain(rejections, alone, dropped, echoes), key=lambda r: r.at_sample)),
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


def guesses(stretch: Stretch, grid: Grid, tier: QualityRules) -> NDArray[np.intp]:
    """Return roughly where a stretch's candidates are, as indices into it, ascending."""
    steps = candidate_steps(stretch.peak, stretch.slope, stretch.bands, grid=grid, rules=tier.scan)
    places = steps * grid.step
    return places[places < stretch.stop - stretch.start]


def described(stretch: Stretch, grid: Grid, tier: QualityRules, *, gate: Test, screen: Test) -> Described:
    """Return the core's candidates that pass the gate, by their rough shapes, and the screen, by all features.

    The onset of those that are left is found to the sample.
    """
    places = guesses(stretch, grid, tier)
    rough = band_levels(stretch.bands, places, grid)
    margin = samples_from_ms(farthest_ms(tier.onset), grid.rate_hz)
    at = places + stretch.start
    near = np.flatnonzero((at >= stretch.core.start - margin) & (at < stretch.core.stop + margin))
    sketches = bandshape(rough[near])
    passed = gate(sketches)
    near, sketches = near[passed], sketches[passed]
    rows = features(sketches, neighbourhood(places, rough, near, grid.rate_hz))
    passed = screen(rows)
    near, rows = near[passed], rows[passed]
    onsets = refine_onsets(stretch.samples, places[near], rate_hz=grid.rate_hz, rules=tier.onset)
    kept = _first_of_each(onsets, samples_from_ms(_SAME_ONSET_MS, grid.rate_hz))
    at = onsets[kept] + stretch.start
    kept = kept[(at >= stretch.core.start) & (at < min(stretch.core.stop, stretch.stop))]
    return Described(onsets[kept], rows[kept])


def _first_of_each(onsets: NDArray[np.intp], apart: int) -> NDArray[np.intp]:
    """Return the indices, in order of onset, of those that follow the one before by at least `apart`."""
    order = np.argsort(onsets, kind="stable")
    return order[np.diff(onsets[order], prepend=-apart) >= apart]


def _search(stretch: Stretch, grid: Grid, tier: QualityRules, verifier: Verifier) -> tuple[list[Shot], list[Rejection]]:
    screen = partial(verifier.screen.lets_pass, at_least=tier.verify.look_from)
    found = described(stretch, grid, tier, gate=verifier.gate.lets_pass, screen=screen)
    verdicts = verifier.verdicts(found.rows, pictures(stretch.samples, found.onsets, grid.rate_hz))
    shots = [
        segment(
            stretch.samples,
            int(onset),
            film_start=stretch.start,
            film_stop=stretch.stop,
            confidence=float(p),
            rate_hz=grid.rate_hz,
            rules=tier.segment,
            screen=float(screen_p),
            networks=int(networks),
        )
        for onset, p, screen_p, networks in zip(
            found.onsets, verdicts.surety, verdicts.screened, verdicts.networks, strict=True
        )
        if p >= tier.verify.company_threshold
    ]
    refused = [
        Rejection(int(onset) + stretch.start, "does not sound like a shot", {"probability": float(p)})
        for onset, p in zip(found.onsets, verdicts.surety, strict=True)
        if tier.verify.report_from <= p < tier.verify.company_threshold
    ]
    return shots, refused

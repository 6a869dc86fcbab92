"""Films that nobody shot: talk, action, chases, quiet and music in turn, each with its beds and its share of shots."""

import itertools
from dataclasses import dataclass

import numpy as np

from .beds import BedKind
from .chance import between, chance, generator, log_between, pick
from .negatives import NEGATIVE_KINDS
from .scene import BedItem, NegativeItem, Scene, ShotItem
from .spread import draw_negatives, draw_shots, spread

SPACING_S = 0.3
QUIETEST_SHOT_DB = 8.0


@dataclass(frozen=True)
class Sequence:
    """A kind of sequence: beds as (kind, how often, lowest and highest level), its share of shots and negatives.

    `loudest_db` is how far a shot may stand out: further where little else is heard.
    """

    beds: tuple[tuple[BedKind, float, float, float], ...]
    shots: float
    negatives: float
    loudest_db: float = 40.0


SEQUENCES: tuple[Sequence, ...] = (
    Sequence(
        (("ambience", 1.0, -64.0, -44.0), ("dialogue", 1.0, -34.0, -22.0), ("music", 0.3, -44.0, -30.0)),
        shots=0.4,
        negatives=1.0,
        loudest_db=48.0,
    ),
    Sequence(
        (
            ("ambience", 0.7, -50.0, -32.0),
            ("crowd", 0.3, -46.0, -28.0),
            ("wind", 0.2, -46.0, -30.0),
            ("dialogue", 0.5, -32.0, -22.0),
            ("music", 0.6, -34.0, -18.0),
        ),
        shots=6.0,
        negatives=2.0,
    ),
    Sequence(
        (("engine", 1.0, -36.0, -20.0), ("music", 0.5, -34.0, -20.0), ("dialogue", 0.3, -32.0, -24.0)),
        shots=2.0,
        negatives=1.5,
    ),
    Sequence(
        (("ambience", 0.8, -70.0, -48.0), ("rain", 0.3, -50.0, -34.0), ("wind", 0.3, -54.0, -36.0)),
        shots=0.8,
        negatives=1.0,
        loudest_db=60.0,
    ),
    Sequence((("music", 1.0, -30.0, -16.0), ("drums", 0.3, -32.0, -20.0)), shots=0.3, negatives=0.6),
    Sequence(
        (("crowd", 1.0, -40.0, -24.0), ("dialogue", 0.6, -32.0, -22.0), ("drums", 0.2, -36.0, -24.0)),
        shots=0.5,
        negatives=1.2,
    ),
)


def film_scene(
    seed: int,
    duration_s: float,
    shots: int,
    negatives: int,
    *,
    gun_free: bool = False,
    rate_hz: int = 48_000,
) -> Scene:
    """Return a film of sequences of half a minute to three, with so many shots and negatives; no shots where gun-free.

    Shots are 8 dB and more over what else is heard, up to 40 over music and to 60 over silence, negatives 3-38 dB, both
    as far as the master's drive lets them.
    """
    rng = generator(seed, "film")
    spans = _spans(rng, duration_s)
    kinds = [pick(rng, SEQUENCES) for _ in spans]
    beds = [bed for span, kind in zip(spans, kinds, strict=True) for bed in _beds(rng, span, kind)]
    others = draw_negatives(rng, negatives, (3.0, 38.0), kinds=NEGATIVE_KINDS)
    lengths = np.array([stop - start for start, stop in spans])
    shares = lengths * [kind.shots for kind in kinds]
    counts = rng.multinomial(0 if gun_free else shots, shares / shares.sum())
    shares = lengths * [kind.negatives for kind in kinds]
    homes = rng.choice(len(kinds), size=len(others), p=shares / shares.sum())
    all_shots: list[ShotItem] = []
    all_others: list[NegativeItem] = []
    for index, (start_s, stop_s) in enumerate(spans):
        drawn = draw_shots(rng, int(counts[index]), (QUIETEST_SHOT_DB, kinds[index].loudest_db))
        mine = [item for item, home in zip(others, homes, strict=True) if home == index]
        stop_s -= SPACING_S
        here, there = spread(rng, drawn, mine, start_s=start_s, stop_s=stop_s, spacing_s=SPACING_S)
        all_shots += here
        all_others += there
    return Scene(
        schema=1,
        rate_hz=rate_hz,
        duration_s=duration_s,
        seed=seed,
        name=f"film-{seed}",
        beds=tuple(beds),
        shots=tuple(all_shots),
        negatives=tuple(all_others),
    )


def _spans(rng: np.random.Generator, duration_s: float) -> list[tuple[float, float]]:
    """Return the sequences' starts and stops: as many as fit, stretched to fill the film."""
    lengths = [log_between(rng, (25.0, 180.0))]
    while sum(lengths) < duration_s:
        lengths.append(log_between(rng, (25.0, 180.0)))
    edges = np.concatenate([[0.0], np.cumsum(lengths)]) * (duration_s / sum(lengths))
    return [(float(start), float(stop)) for start, stop in itertools.pairwise(edges.tolist())]


def _beds(rng: np.random.Generator, span: tuple[float, float], kind: Sequence) -> list[BedItem]:
    """Return the beds of a sequence; they fade into the next one's or stop at a cut."""
    fade_s = pick(rng, (0.02, 0.5, 2.0))
    chosen = [(name, low, high) for name, often, low, high in kind.beds if chance(rng, often)]
    return [
        BedItem(kind=name, level_dbfs=between(rng, (low, high)), start_s=span[0], stop_s=span[1], fade_s=fade_s)
        for name, low, high in chosen
    ]

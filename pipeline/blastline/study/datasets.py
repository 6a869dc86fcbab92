"""The datasets that a training run learns from and is tested on: which lessons, and how many of each."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .corpus import Recording, read_corpus
from .film_lessons import SPARSE, gun_free_film, synthetic_film
from .lessons import blow_mix, designed_mix, jet_mix, outdoor_mix, plain_mix, recorded_mix, synthetic_mix
from .mixes import LessonMaker

FOLDS = 4
FOLD_SEED = 7  # the parts are the same for every training seed
FILMS_PER_MIX = 6
SPARSE_SHARE = 0.6  # so many films in which sounds stand alone come to each crowded one
GUN_FREE_SHARE = 0.4  # so many films without a gun come to each film with some
PLAIN_SHARE = 0.4  # so many mixes of textbook sounds come to each film
DESIGNED_SHARE = 1.5  # and so many of sounds as designers build them
BLOW_SHARE = 0.2  # and so many of steps and machines
OUTDOOR_SHARE = 1.0  # and so many of guns recorded outdoors, and of what hands do near a microphone
JET_SHARE = 0.5  # and so many of guns of much gas, which are fired again and again
HELD_OUT_EVERY = 12  # of the films one in so many is held out


@dataclass(frozen=True)
class Dataset:
    """Lessons of one kind: how they are made, how many, and which are held out of training (every n-th; 0 for none)."""

    name: str
    make_lesson: LessonMaker
    count: int
    held_out_every: int

    def is_held_out(self, number: int) -> bool:
        """Return whether a lesson is held out."""
        return bool(self.held_out_every) and number % self.held_out_every == 0


def datasets(
    corpus: Sequence[Path], *, synthetic: int, recorded: int, seed: int, hold_out: int | None
) -> list[Dataset]:
    """Return the datasets of a training run; the recordings' sources are split into `FOLDS`."""
    sparse = round(SPARSE_SHARE * synthetic)
    made = [
        Dataset("film", synthetic_film(seed), synthetic, HELD_OUT_EVERY),
        Dataset("gun-free", gun_free_film(seed + 50), round(GUN_FREE_SHARE * synthetic), 0),
        Dataset("sparse-film", synthetic_film(seed + 60, SPARSE), sparse, HELD_OUT_EVERY),
        Dataset("sparse-gun-free", gun_free_film(seed + 70, SPARSE), round(GUN_FREE_SHARE * sparse), 0),
        Dataset("mix", synthetic_mix(seed + 1), synthetic // FILMS_PER_MIX, 0),
    ]
    for fold, recordings in enumerate(by_fold(read_corpus(corpus), FOLDS, FOLD_SEED) if recorded else ()):
        make_lesson = recorded_mix(recordings, seed + 2 + fold)
        made.append(Dataset(f"recorded-{fold}", make_lesson, -(-recorded // FOLDS), 1 if fold == hold_out else 0))
    return [
        *made,
        Dataset("plain", plain_mix(seed + 80), round(PLAIN_SHARE * synthetic), HELD_OUT_EVERY),
        Dataset("blows", blow_mix(seed + 110), round(BLOW_SHARE * synthetic), HELD_OUT_EVERY),
        Dataset("designed", designed_mix(seed + 90), round(DESIGNED_SHARE * synthetic), HELD_OUT_EVERY),
        Dataset("outdoors", outdoor_mix(seed + 100), round(OUTDOOR_SHARE * synthetic), HELD_OUT_EVERY),
        Dataset("jets", jet_mix(seed + 120), round(JET_SHARE * synthetic), HELD_OUT_EVERY),
    ]


def by_fold(recordings: Sequence[Recording], folds: int, seed: int) -> list[list[Recording]]:
    """Return recordings in parts that share no source, each with sources of shots and of negatives; none for none."""
    armed = {r.source for r in recordings if r.gunshot}
    parts: list[list[Recording]] = [[] for _ in range(folds)]
    rng = np.random.default_rng(seed)
    for sources in (sorted(armed), sorted({r.source for r in recordings} - armed)):
        rng.shuffle(sources)
        for place, source in enumerate(sources):
            parts[place % folds] += [r for r in recordings if r.source == source]
    return [part for part in parts if part]

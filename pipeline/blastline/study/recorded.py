"""Recordings as parts of a mix: drawn so that no source outweighs the others, varied, or laid under as a bed."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from .corpus import Recording, load_sound
from .mixes import MIX_S, RATE_HZ, Sound
from .variants import varied

SHORTEST_BED_S = 4.0
LONGEST_S = 6.0
VARIED_SHARE = 0.8


def by_source(recordings: Iterable[Recording]) -> list[list[Recording]]:
    """Return recordings grouped by source and kind, so that a large source does not outweigh the others."""
    groups: dict[tuple[str, str], list[Recording]] = {}
    for recording in recordings:
        kind = "" if recording.gunshot else recording.sub_label
        groups.setdefault((recording.source, kind), []).append(recording)
    return list(groups.values())


def drawn(groups: list[list[Recording]], rng: np.random.Generator) -> Recording:
    """Return a recording of a group, groups drawn evenly."""
    group = groups[int(rng.integers(len(groups)))]
    return group[int(rng.integers(len(group)))]


def recorded_sound(recording: Recording, rng: np.random.Generator) -> Sound:
    """Return a recording as it is, six seconds of it where it has no shot."""
    samples = load_sound(recording, RATE_HZ).astype(np.float64)
    onsets = tuple(round(onset * RATE_HZ) for onset in recording.onsets_s)
    longest = int(LONGEST_S * RATE_HZ)
    if not onsets and samples.size > longest:
        start = int(rng.integers(samples.size - longest))
        samples = samples[start : start + longest]
    return Sound(samples, onsets)


def recorded_variant(recording: Recording, rng: np.random.Generator) -> Sound:
    """Return a recording, four in five times varied."""
    sound = recorded_sound(recording, rng)
    return varied(sound, rng, RATE_HZ) if rng.random() < VARIED_SHARE else sound


def recorded_bed(beds: list[Recording], rng: np.random.Generator, seconds: float = MIX_S) -> NDArray[np.float64]:
    """Return a bed of up to three long recordings without shots, each repeated as often as needed."""
    length = int(seconds * RATE_HZ)
    bed = np.zeros(length)
    for _ in range(int(rng.integers(1, 4))):
        layer = load_sound(beds[int(rng.integers(len(beds)))], RATE_HZ).astype(np.float64)
        rms = float(np.sqrt(np.mean(layer**2))) or 1.0
        bed += np.resize(layer, length) / rms * rng.uniform(0.02, 0.2)
    return bed

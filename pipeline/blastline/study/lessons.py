"""What the verifier learns from: endless minutes of film-like sound, synthetic and recorded, each from its own seed."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..synth import film_scene, random_bed, random_negative, random_shot, render_scene, truth_of
from .corpus import Recording, load_sound
from .mixes import Mix, Sound, as_16_bit, mix

RATE_HZ = 48_000
MIX_S = 60.0
SOUNDS_PER_MIX = 20
LEVELS_DB = (3.0, 40.0)


def synthetic_mixes(count: int, seed: int) -> Iterable[Mix]:
    """Yield mixes of synthetic sounds alone."""
    for child in np.random.SeedSequence(seed).spawn(count):
        rng = np.random.default_rng(child)
        yield mix(
            random_bed(rng, RATE_HZ, MIX_S),
            [_synthetic_sound(rng, shot=bool(rng.random() < 0.5)) for _ in range(SOUNDS_PER_MIX)],
            rng=rng,
            rate_hz=RATE_HZ,
            levels_db=LEVELS_DB,
        )


def synthetic_films(count: int, seed: int) -> Iterable[Mix]:
    """Yield scenes as `blastline synth` makes them: bursts, rooms and beds that change, mastered as one.

    Some are cut to begin with a shot or just before it, as a reel or a trailer may.
    """
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        shots, negatives = int(rng.integers(0, 16)), int(rng.integers(8, 40))
        scene = film_scene(seed * 10_000 + number, MIX_S, shots, negatives, gun_free=shots == 0, rate_hz=RATE_HZ)
        audio = render_scene(scene)
        truth = truth_of(audio)
        start = 0
        if truth.shots and rng.random() < 0.4:
            first = truth.shots[int(rng.integers(len(truth.shots)))].onset_sample
            start = max(0, first - int(rng.uniform(0.0, 0.3) ** 2 * RATE_HZ))
        kept = [shot for shot in truth.shots if shot.onset_sample >= start]
        unsure = [at - start for shot in kept for at in shot.accept_samples if at >= start]
        unsure += [n.at_sample - start for n in truth.negatives if n.kind == "explosion" and n.at_sample >= start]
        yield Mix(
            samples=as_16_bit(audio.read(start, audio.frames)[:, 0]),
            onsets=np.array([shot.onset_sample - start for shot in kept], np.intp),
            level_db=np.array([shot.snr_db for shot in kept], np.float64),
            unsure=np.array(unsure, np.intp),
        )


def recorded_mixes(recordings: Sequence[Recording], count: int, seed: int, synthetic: float = 0.3) -> Iterable[Mix]:
    """Yield mixes of recordings, sources drawn evenly, with a share of synthetic sounds and beds among them."""
    shots = _by_source(r for r in recordings if r.gunshot)
    negatives = _by_source(r for r in recordings if not r.gunshot)
    for child in np.random.SeedSequence(seed).spawn(count):
        rng = np.random.default_rng(child)
        sounds = []
        for _ in range(SOUNDS_PER_MIX):
            shot = bool(rng.random() < 0.5)
            if rng.random() < synthetic:
                sounds.append(_synthetic_sound(rng, shot=shot))
            else:
                sounds.append(_recorded_sound(_draw(shots if shot else negatives, rng), rng))
        bed = random_bed(rng, RATE_HZ, MIX_S) if rng.random() < synthetic else _recorded_bed(recordings, rng)
        yield mix(bed, sounds, rng=rng, rate_hz=RATE_HZ, levels_db=LEVELS_DB)


def _by_source(recordings: Iterable[Recording]) -> list[list[Recording]]:
    """Return recordings grouped by source and kind, so that a large source does not outweigh the others."""
    groups: dict[tuple[str, str], list[Recording]] = {}
    for recording in recordings:
        kind = "" if recording.gunshot else recording.sub_label
        groups.setdefault((recording.source, kind), []).append(recording)
    return list(groups.values())


def _draw(groups: list[list[Recording]], rng: np.random.Generator) -> Recording:
    group = groups[int(rng.integers(len(groups)))]
    return group[int(rng.integers(len(group)))]


def _recorded_sound(recording: Recording, rng: np.random.Generator) -> Sound:
    samples = load_sound(recording, RATE_HZ).astype(np.float64)
    onsets = tuple(round(onset * RATE_HZ) for onset in recording.onsets_s)
    longest = int(6.0 * RATE_HZ)
    if not onsets and samples.shape[0] > longest:
        start = int(rng.integers(samples.shape[0] - longest))
        samples = samples[start : start + longest]
    return Sound(samples, onsets)


def _recorded_bed(recordings: Sequence[Recording], rng: np.random.Generator) -> NDArray[np.float64]:
    """Return a bed of up to three layers, each a long recording without shots, repeated as often as needed."""
    length = int(MIX_S * RATE_HZ)
    bed = np.zeros(length)
    negatives = [r for r in recordings if not r.gunshot]
    for _ in range(int(rng.integers(1, 4))):
        layer = load_sound(negatives[int(rng.integers(len(negatives)))], RATE_HZ).astype(np.float64)
        if layer.shape[0] < 4 * RATE_HZ:
            layer = random_bed(rng, RATE_HZ, 20.0)
        rms = float(np.sqrt(np.mean(layer**2))) or 1.0
        bed += np.resize(layer, length) / rms * rng.uniform(0.02, 0.2)
    return bed


def _synthetic_sound(rng: np.random.Generator, *, shot: bool) -> Sound:
    if shot:
        samples, onset, truth = random_shot(rng, RATE_HZ)
        return Sound(samples, (onset,), truth.accept_samples)
    samples, _ = random_negative(rng, RATE_HZ)
    return Sound(samples)

"""What the verifier knows of a candidate: its attack and decay band by band, its waveform, and its neighbourhood.

Levels are relative to the candidate's own attack, so that the gain of a film changes nothing, and bounded, so that
digital silence is a number.
"""

import itertools

import numpy as np
from numpy.typing import NDArray

from ..units import samples_from_ms
from .tracks import BANDS, Grid

# segments of the band tracks around the onset, in milliseconds
SEGMENTS_MS = (
    (-500, -200),
    (-200, -50),
    (-50, -12),
    (-12, -4),
    (-2, 4),
    (4, 8),
    (8, 16),
    (16, 32),
    (32, 64),
    (64, 128),
    (128, 256),
    (256, 500),
)
ATTACK = SEGMENTS_MS.index((-2, 4))
LOWEST_DB, HIGHEST_DB = -70.0, 30.0

# how far the neighbourhood reaches, in milliseconds
PAST_MS, FUTURE_MS = 3000.0, 1000.0
REACH_MS = (PAST_MS + 100.0, FUTURE_MS + 100.0)

WAVE_MS = (0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
SPECTRA_MS = ((1.0, 22.0), (22.0, 64.0), (64.0, 150.0))
SPECTRUM_EDGES_HZ = (60.0, 250.0, 800.0, 2500.0, 8000.0)
LEVEL_STEPS_DB = (-12.0, -6.0, -3.0)


def feature_names() -> tuple[str, ...]:
    """Return the names of the columns of `features`, in order."""
    bands = [f"band{b}_{start}_{stop}_db" for b in range(BANDS) for start, stop in SEGMENTS_MS]
    total = [f"total_{start}_{stop}_db" for start, stop in SEGMENTS_MS]
    wave = [f"peak_{a}_{b}_db" for a, b in itertools.pairwise(WAVE_MS)]
    wave += [f"slope_{a}_{b}_db" for a, b in itertools.pairwise(WAVE_MS)]
    wave += [
        "rise_10_50_ms",
        "rise_10_90_ms",
        "peak_at_ms",
        "first_lobe_ms",
        "crossings_4ms",
        "crossings_16ms",
        "asymmetry",
    ]
    spectra = [
        f"{kind}_{start:g}_{stop:g}ms_{low:g}_{high:g}Hz"
        for start, stop in SPECTRA_MS
        for low, high in itertools.pairwise(SPECTRUM_EDGES_HZ)
        for kind in ("flatness", "peakiness")
    ]
    near = [
        "louder_past_db",
        "louder_future_db",
        "previous_ms",
        "next_ms",
        "previous_db",
        "next_db",
        "likeness_previous",
    ]
    near += [f"{side}_within{level:g}dB" for side in ("past", "future") for level in LEVEL_STEPS_DB]
    near += ["like_past", "like_future", "rhythm"]
    return tuple(bands + total + wave + spectra + near)


def features(
    samples: NDArray[np.float32],
    bands: NDArray[np.float32],
    onsets: NDArray[np.intp],
    wanted: NDArray[np.bool_],
    *,
    grid: Grid,
) -> NDArray[np.float64]:
    """Return the features of the wanted candidates, shape (wanted, features).

    `samples` and `bands` are a stretch of the film and its band track, starting together; `onsets` are sample
    indices in it, ascending, and hold the neighbourhood as well as the wanted candidates.
    """
    levels = _band_levels(bands, onsets, grid)
    attack_db = levels[:, -1, ATTACK]
    relative = np.clip(levels - attack_db[:, None, None], LOWEST_DB, HIGHEST_DB)
    chosen = onsets[wanted]
    return np.concatenate(
        [
            relative[wanted].reshape(chosen.size, (BANDS + 1) * len(SEGMENTS_MS)),
            _wave_shape(samples, chosen, grid.rate_hz),
            _spectra(samples, chosen, grid.rate_hz),
            _neighbourhood(onsets, attack_db, relative[:, :-1, ATTACK : ATTACK + 5], wanted, grid.rate_hz),
        ],
        axis=1,
    )


def _band_levels(bands: NDArray[np.float32], onsets: NDArray[np.intp], grid: Grid) -> NDArray[np.float64]:
    """Return the mean level of each band, and of all together, in each segment: (n, BANDS + 1, segments), in dB."""
    sums = np.zeros((bands.shape[0] + 1, BANDS), np.float64)
    np.cumsum(bands, axis=0, dtype=np.float64, out=sums[1:])
    frame = onsets[:, None] // grid.hop
    edges = np.array(SEGMENTS_MS, np.float64) * (grid.rate_hz / 1000.0 / grid.hop)
    starts = np.clip(frame + np.round(edges[:, 0]).astype(np.intp), 0, bands.shape[0])
    stops = np.clip(frame + np.round(edges[:, 1]).astype(np.intp), 0, bands.shape[0])
    energy = (sums[stops] - sums[starts]) / np.maximum(stops - starts, 1)[:, :, None]
    energy = np.moveaxis(np.maximum(energy, 0.0), 2, 1)
    energy = np.concatenate([energy, energy.sum(axis=1, keepdims=True)], axis=1)
    return np.asarray(10.0 * np.log10(energy + 1e-16), np.float64)


def _wave_shape(samples: NDArray[np.float32], onsets: NDArray[np.intp], rate_hz: int) -> NDArray[np.float64]:
    edges = [samples_from_ms(ms, rate_hz) for ms in WAVE_MS]
    wave = _gather(samples, onsets, 0, edges[-1])
    slope = np.diff(wave, axis=1, prepend=0.0)
    magnitude, steep = np.abs(wave), np.abs(slope)
    peak = magnitude.max(axis=1, keepdims=True) + 1e-12
    spans = [(a, max(b, a + 1)) for a, b in itertools.pairwise(edges)]
    peaks = [magnitude[:, a:b].max(axis=1) for a, b in spans]
    slopes = [steep[:, a:b].max(axis=1) for a, b in spans]
    shape = np.stack(peaks + slopes, axis=1) / peak
    first = max(1, samples_from_ms(4.0, rate_hz))
    early = magnitude[:, :first]
    early_peak = early.max(axis=1, keepdims=True) + 1e-12
    ms = 1000.0 / rate_hz
    tenth, half, most = (np.argmax(early >= ratio * early_peak, axis=1) for ratio in (0.1, 0.5, 0.9))
    sign = np.sign(np.take_along_axis(wave, most[:, None], axis=1))
    turned = (wave * sign < 0.0) & (np.arange(wave.shape[1]) > most[:, None])
    lobe = np.where(turned.any(axis=1), turned.argmax(axis=1), wave.shape[1]) - tenth
    crossings = np.diff(np.signbit(wave), axis=1)
    asymmetry = np.abs(wave.max(axis=1) + wave.min(axis=1)) / peak[:, 0]
    rows = [
        (half - tenth) * ms,
        (most - tenth) * ms,
        early.argmax(axis=1) * ms,
        lobe * ms,
        crossings[:, :first].mean(axis=1) * rate_hz / 1000.0,
        crossings.mean(axis=1) * rate_hz / 1000.0,
        asymmetry,
    ]
    return np.concatenate([20.0 * np.log10(np.maximum(shape, 1e-3)), np.stack(rows, axis=1)], axis=1)


def _spectra(samples: NDArray[np.float32], onsets: NDArray[np.intp], rate_hz: int) -> NDArray[np.float64]:
    """Return how noise-like (flatness) and how tonal (peakiness) each range of the spectrum is, in dB."""
    from scipy.fft import next_fast_len, rfft

    columns: list[NDArray[np.float64]] = []
    for start_ms, stop_ms in SPECTRA_MS:
        start, stop = samples_from_ms(start_ms, rate_hz), samples_from_ms(stop_ms, rate_hz)
        wave = _gather(samples, onsets, start, stop) * np.hanning(stop - start)
        length = next_fast_len(stop - start, real=True)
        power = np.abs(rfft(wave, length, axis=1)) ** 2 + 1e-14
        hz = np.arange(power.shape[1]) * rate_hz / length
        for low, high in itertools.pairwise(SPECTRUM_EDGES_HZ):
            part = power[:, (hz >= low) & (hz < high)]
            if part.shape[1] == 0:
                columns += [np.zeros(onsets.size), np.zeros(onsets.size)]
                continue
            mean = part.mean(axis=1)
            columns.append(10.0 * (np.log10(part).mean(axis=1) - np.log10(mean)))
            columns.append(10.0 * np.log10(part.max(axis=1) / mean))
    return np.stack(columns, axis=1) if onsets.size else np.zeros((0, len(columns)))


def _neighbourhood(
    onsets: NDArray[np.intp],
    attack_db: NDArray[np.float64],
    shapes: NDArray[np.float64],
    wanted: NDArray[np.bool_],
    rate_hz: int,
) -> NDArray[np.float64]:
    """Return how a candidate stands among those of the last three seconds and the next one."""
    past, future = samples_from_ms(PAST_MS, rate_hz), samples_from_ms(FUTURE_MS, rate_hz)
    first = np.searchsorted(onsets, onsets - past)
    last = np.searchsorted(onsets, onsets + future, side="right")
    rows = [
        _among(int(i), int(first[i]), int(last[i]), onsets, attack_db, shapes, rate_hz) for i in np.flatnonzero(wanted)
    ]
    return np.array(rows, np.float64).reshape(len(rows), 7 + 2 * len(LEVEL_STEPS_DB) + 3)


def _among(
    i: int,
    first: int,
    last: int,
    onsets: NDArray[np.intp],
    attack_db: NDArray[np.float64],
    shapes: NDArray[np.float64],
    rate_hz: int,
) -> list[float]:
    ms = 1000.0 / rate_hz
    level = attack_db[first:last] - attack_db[i]
    distance = np.sqrt(np.mean((shapes[first:last] - shapes[i]) ** 2, axis=(1, 2)))
    here = i - first
    before, after = level[:here], level[here + 1 :]
    strong = np.flatnonzero(level >= -9.0)
    earlier, later = strong[strong < here], strong[strong > here]
    previous = first + int(earlier[-1]) if earlier.size else -1
    following = first + int(later[0]) if later.size else -1
    gap_back = (onsets[i] - onsets[previous]) * ms if previous >= 0 else PAST_MS
    gap_on = (onsets[following] - onsets[i]) * ms if following >= 0 else FUTURE_MS
    counts = [float((side >= bound).sum()) for side in (before, after) for bound in LEVEL_STEPS_DB]
    alike = (distance < 5.0) & (np.abs(level) < 9.0)
    return [
        float(before.max(initial=LOWEST_DB)),
        float(after.max(initial=LOWEST_DB)),
        float(gap_back),
        float(gap_on),
        float(attack_db[previous] - attack_db[i]) if previous >= 0 else LOWEST_DB,
        float(attack_db[following] - attack_db[i]) if following >= 0 else LOWEST_DB,
        float(distance[previous - first]) if previous >= 0 else 50.0,
        *counts,
        float(alike[:here].sum()),
        float(alike[here + 1 :].sum()),
        _rhythm(onsets[first:last][alike | (np.arange(last - first) == here)], ms),
    ]


def _rhythm(onsets: NDArray[np.intp], ms: float) -> float:
    """Return how evenly alike candidates follow each other: the spread of their gaps over the mean gap, 2 for few."""
    gaps = np.diff(onsets) * ms
    return min(2.0, float(gaps.std() / gaps.mean())) if gaps.size >= 3 and gaps.mean() > 0.0 else 2.0


def _gather(samples: NDArray[np.float32], onsets: NDArray[np.intp], start: int, stop: int) -> NDArray[np.float64]:
    """Return `samples` from `start` to `stop` after each onset, shape (n, stop - start); zero beyond the stretch."""
    index = onsets[:, None] + np.arange(start, stop)
    inside = (index >= 0) & (index < samples.shape[0])
    return np.where(inside, samples[np.clip(index, 0, samples.shape[0] - 1)], 0.0).astype(np.float64)

"""A shot's parts: the blast, its discrete reflections, and where the decay is over.

    |\\                       blast: onset to the end of the direct sound
    | \\  /\\    .-.           reflections: copies of the blast, later, weaker
    |  \\/  \\__/   \\__        decay: down to `decay_db` below the peak or the background

A reflection is a lag at which the sound after the blast correlates with the blast itself: its level is the gain of
the copy that fits best (a matched filter with the blast as the template).
"""

import numpy as np
from numpy.typing import NDArray

from ..model import Reflection, Shot, Span
from ..ruleset import SegmentRules
from ..units import db_from_gain, gain_from_db, ms_from_samples, samples_from_ms

BACKGROUND_MS = 200.0
PEAK_MS = 20.0
_SMOOTH_MS = 10.0
# longer than the level stays low where the blast crosses zero, shorter than the gap to an echo
_BLAST_GRAIN_MS = 2.0
# a copy of the blast has to look like it: the correlation coefficient from which a lag counts
_LIKENESS = 0.5
_REFLECTION_APART_MS = 3.0


def segment(
    samples: NDArray[np.float32],
    onset: int,
    *,
    film_start: int,
    film_stop: int,
    confidence: float,
    rate_hz: int,
    rules: SegmentRules,
) -> Shot:
    """Return the shot whose blast starts at index `onset` of `samples`, a stretch that starts at `film_start`.

    `film_stop` is where the film, or what is known of it, ends.
    """
    reach = samples_from_ms(rules.longest_ms, rate_hz) + samples_from_ms(2 * _SMOOTH_MS, rate_hz)
    wave = samples[onset : min(onset + reach, film_stop - film_start)].astype(np.float64)
    before = samples[max(0, onset - samples_from_ms(BACKGROUND_MS, rate_hz)) : onset].astype(np.float64)
    background = float(np.sqrt(np.mean(before**2))) if before.size else 0.0
    peak = float(np.abs(wave[: samples_from_ms(PEAK_MS, rate_hz)]).max(initial=0.0))
    blast = _blast_length(wave, peak, rate_hz=rate_hz, rules=rules)
    at = film_start + onset
    return Shot(
        onset=at,
        confidence=confidence,
        peak_dbfs=db_from_gain(peak),
        snr_db=db_from_gain(peak / max(background, 1e-12)),
        blast=Span(at, at + blast),
        reflections=_reflections(wave, blast, at=at, rate_hz=rate_hz, rules=rules),
        span=Span(at, at + _decay_length(wave, peak, background, rate_hz=rate_hz, rules=rules)),
    )


def _blast_length(wave: NDArray[np.float64], peak: float, *, rate_hz: int, rules: SegmentRules) -> int:
    """Return where the envelope has fallen by `blast_decay_db` for the first time, in samples from the onset."""
    longest = min(wave.shape[0], samples_from_ms(rules.longest_blast_ms, rate_hz))
    grain = max(1, samples_from_ms(_BLAST_GRAIN_MS, rate_hz))
    envelope = _running_peak(np.abs(wave[: longest + grain]), grain)[:longest]
    top = int(np.argmax(envelope)) if longest else 0
    below = np.flatnonzero(envelope[top:] < peak * gain_from_db(-rules.blast_decay_db))
    return max(1, top + int(below[0]) if below.size else longest) if wave.size else 0


def _reflections(
    wave: NDArray[np.float64], blast: int, *, at: int, rate_hz: int, rules: SegmentRules
) -> tuple[Reflection, ...]:
    from scipy.signal import correlate, find_peaks

    earliest = max(blast, samples_from_ms(rules.earliest_reflection_ms, rate_hz))
    latest = min(wave.shape[0] - blast, samples_from_ms(rules.latest_reflection_ms, rate_hz))
    template = wave[:blast]
    energy = float(template @ template)
    if latest <= earliest or energy <= 0.0:
        return ()
    heard = wave[: latest + blast]
    product = correlate(heard, template, mode="valid", method="fft")
    sums = np.concatenate([[0.0], np.cumsum(heard**2)])
    local = np.maximum(sums[blast:] - sums[:-blast], 1e-30)
    gain = np.abs(product) / energy
    likeness = np.abs(product) / np.sqrt(energy * local)
    gain[:earliest] = 0.0
    peaks, _ = find_peaks(
        np.where(likeness >= _LIKENESS, gain, 0.0),
        height=gain_from_db(rules.reflection_level_db),
        distance=max(1, samples_from_ms(_REFLECTION_APART_MS, rate_hz)),
    )
    return tuple(
        Reflection(
            at + int(lag), at + int(lag) + blast, ms_from_samples(int(lag), rate_hz), db_from_gain(float(gain[lag]))
        )
        for lag in peaks
    )


def _decay_length(
    wave: NDArray[np.float64], peak: float, background: float, *, rate_hz: int, rules: SegmentRules
) -> int:
    """Return when the smoothed level first falls `decay_db` under its start, or to the background."""
    shortest, longest = samples_from_ms(rules.shortest_ms, rate_hz), samples_from_ms(rules.longest_ms, rate_hz)
    grain = max(1, samples_from_ms(_SMOOTH_MS, rate_hz))
    grains = wave[: wave.shape[0] // grain * grain].reshape(-1, grain)
    level = np.sqrt(np.mean(grains**2, axis=1))
    start = float(level[:3].max(initial=0.0))
    over = (level < start * gain_from_db(-rules.decay_db)) | (level < 1.4 * background)
    over &= np.arange(level.shape[0]) * grain >= shortest
    found = np.flatnonzero(over[:-1] & over[1:]) if over.size > 1 else np.empty(0, np.intp)
    length = int(found[0]) * grain if found.size else longest
    return max(1, min(length, longest, int(wave.shape[0])))


def _running_peak(magnitude: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """Return the largest of each sample and the `width - 1` after it."""
    from scipy.ndimage import maximum_filter1d

    ahead = maximum_filter1d(magnitude, width, mode="constant", cval=0.0, origin=-((width - 1) // 2))
    return np.asarray(ahead, np.float64)

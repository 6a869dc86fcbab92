r"""A shot's parts: the blast, its discrete reflections, and where the decay is over.

    |\                       blast: onset to the end of the direct sound
    | \  /\    .-.           reflections: copies of the blast, later, weaker
    |  \/  \__/   \__        decay: down to `decay_db` below its start, to the background, or to the next sound

A reflection is a lag at which the sound after the blast correlates with the blast itself (a matched filter). It is
looked for in the first difference, where a shock front is a spike and a voice or an engine hardly resembles it, and it
has to stand out of its own neighbourhood: a tail full of overlapping echoes holds no discrete one.
"""

import numpy as np
from numpy.typing import NDArray

from ..model import DecayEnd, Heard, Reflection, Shot, Span
from ..ruleset import SegmentRules
from ..units import db_from_gain, gain_from_db, ms_from_samples, samples_from_ms

BACKGROUND_MS = 200.0
PEAK_MS = 20.0
_SMOOTH_MS = 25.0  # a period of the lowest boom that a film puts under a shot
_RISE_AGAIN = 2.0  # the decay is over where the level, once 12 dB down, doubles: something else has begun
_DECAYED = 0.25
_NEIGHBOURHOOD_MS = 15.0
_REFLECTION_APART_MS = 3.0
# A Friedlander blast stays below a tenth of its peak for two thirds of its positive phase where it crosses zero: a peak
# held a little longer does not take the crossing for the end.
_HOLD_PER_PHASE = 0.8
_HOLD_MS = (0.1, 2.0)


def segment(
    samples: NDArray[np.float32],
    onset: int,
    *,
    film_start: int,
    film_stop: int,
    confidence: float,
    rate_hz: int,
    rules: SegmentRules,
    screen: float | None = None,
    networks: int = 0,
) -> Shot:
    """Return the shot whose blast starts at index `onset` of `samples`, a stretch that starts at `film_start`.

    `film_stop` is where the film, or what is known of it, ends; `screen` and `networks` are as in `model.Heard`.
    """
    stop = min(onset + reach(rate_hz=rate_hz, rules=rules), film_stop - film_start)
    wave = samples[onset:stop].astype(np.float64)
    before = samples[max(0, onset - samples_from_ms(BACKGROUND_MS, rate_hz)) : onset].astype(np.float64)
    wave -= np.mean(before) if before.size else wave[0]  # a constant is no sound
    background = float(np.std(before)) if before.size else 0.0
    peak = float(np.abs(wave[: samples_from_ms(PEAK_MS, rate_hz)]).max(initial=0.0))
    blast = _blast_length(wave, peak, rate_hz=rate_hz, rules=rules)
    at = film_start + onset
    reflections, room = _reflections(wave, blast, at=at, rate_hz=rate_hz, rules=rules)
    length, ended = _decay(wave, peak, background, rate_hz=rate_hz, rules=rules)
    return Shot(
        onset=at,
        confidence=confidence,
        peak_dbfs=db_from_gain(peak),
        snr_db=db_from_gain(peak / max(background, 1e-12)),
        blast=Span(at, at + blast),
        reflections=reflections,
        span=Span(at, at + length),
        heard=Heard(screen, networks, db_from_gain(room), ended),
    )


def reach(*, rate_hz: int, rules: SegmentRules) -> int:
    """Return how many samples from its onset on tell of a shot."""
    return samples_from_ms(rules.longest_ms, rate_hz) + samples_from_ms(2 * _SMOOTH_MS, rate_hz)


def _blast_length(wave: NDArray[np.float64], peak: float, *, rate_hz: int, rules: SegmentRules) -> int:
    """Return where the envelope has fallen by `blast_decay_db` for the first time, in samples from the onset."""
    longest = min(wave.shape[0], samples_from_ms(rules.longest_blast_ms, rate_hz))
    if longest == 0:
        return 0
    near = wave[: 2 * longest]
    top = int(np.argmax(np.abs(near[:longest])))
    turned = np.flatnonzero(near[top:] * near[top] < 0.0)
    phase = top + int(turned[0]) if turned.size else longest
    shortest_hold, longest_hold = (max(1, samples_from_ms(ms, rate_hz)) for ms in _HOLD_MS)
    hold = min(max(int(_HOLD_PER_PHASE * phase), shortest_hold), longest_hold)
    below = np.flatnonzero(_running_peak(np.abs(near), hold)[top:longest] < peak * gain_from_db(-rules.blast_decay_db))
    return max(1, top + int(below[0]) if below.size else longest)


def _reflections(
    wave: NDArray[np.float64], blast: int, *, at: int, rate_hz: int, rules: SegmentRules
) -> tuple[tuple[Reflection, ...], float]:
    """Return the reflections, and the gain that none can exceed: the loudest stretch that is as long as the blast.

    Where that is too little, none is looked for: a product of two signals is at most the product of their norms.
    """
    from scipy.ndimage import uniform_filter1d
    from scipy.signal import correlate, find_peaks

    earliest = max(blast, samples_from_ms(rules.earliest_reflection_ms, rate_hz))
    latest = min(wave.shape[0] - blast, samples_from_ms(rules.latest_reflection_ms, rate_hz))
    steep = np.diff(wave[: latest + blast], prepend=0.0)
    template = steep[:blast]
    energy = float(template @ template)
    if latest <= earliest or energy <= 0.0:
        return (), 0.0
    sums = np.concatenate([[0.0], np.cumsum(steep**2)])
    energies = np.maximum(sums[blast:] - sums[:-blast], 1e-30)
    room = float(np.sqrt(energies[earliest:].max() / energy))
    if room < gain_from_db(rules.reflection_level_db):
        return (), room
    product = np.abs(correlate(steep, template, mode="valid", method="fft"))
    likeness = product / np.sqrt(energy * energies)
    around = max(1, samples_from_ms(_NEIGHBOURHOOD_MS, rate_hz))
    prominence = product / np.sqrt(np.maximum(uniform_filter1d(product**2, around), 1e-30))
    stands_out = (likeness >= rules.reflection_likeness) & (prominence >= rules.reflection_prominence)
    stands_out[:earliest] = False
    gain = np.where(stands_out, product / energy, 0.0)
    apart = max(1, samples_from_ms(_REFLECTION_APART_MS, rate_hz))
    lags, _ = find_peaks(gain, height=gain_from_db(rules.reflection_level_db), distance=apart)
    found: list[Reflection] = []
    for lag in map(int, lags):
        level_db = db_from_gain(float(gain[lag]))
        found.append(Reflection(at + lag, at + lag + blast, ms_from_samples(lag, rate_hz), level_db))
    return tuple(found), room


def _decay(
    wave: NDArray[np.float64], peak: float, background: float, *, rate_hz: int, rules: SegmentRules
) -> tuple[int, DecayEnd]:
    """Return when the smoothed level falls `decay_db` under its start, to the background, or rises again; and which."""
    shortest, longest = samples_from_ms(rules.shortest_ms, rate_hz), samples_from_ms(rules.longest_ms, rate_hz)
    grain = max(1, samples_from_ms(_SMOOTH_MS, rate_hz))
    grains = wave[: wave.shape[0] // grain * grain].reshape(-1, grain)
    level = np.sqrt(np.mean(grains**2, axis=1))
    start = float(level[:2].max(initial=0.0))
    fallen, drowned = level < start * gain_from_db(-rules.decay_db), level < 1.4 * background
    lowest = np.minimum.accumulate(level)
    over = fallen | drowned | ((lowest < _DECAYED * start) & (level > _RISE_AGAIN * lowest))
    over &= np.arange(level.shape[0]) * grain >= shortest
    found = np.flatnonzero(over[:-1] & over[1:]) if over.size > 1 else np.empty(0, np.intp)
    longest = min(longest, int(wave.shape[0]))
    if not found.size or int(found[0]) * grain >= longest:
        return max(1, longest), "longest"
    first = int(found[0])
    ended: DecayEnd = "fallen" if fallen[first] else "background" if drowned[first] else "next sound"
    return max(1, first * grain), ended


def _running_peak(magnitude: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """Return the largest of each sample and the `width - 1` after it."""
    from scipy.ndimage import maximum_filter1d

    ahead = maximum_filter1d(magnitude, width, mode="constant", cval=0.0, origin=-((width - 1) // 2))
    return np.asarray(ahead, np.float64)

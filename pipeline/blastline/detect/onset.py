"""The first sample of a candidate's rise, in the waveform.

              noise        |quiet|/\\  peak
    ~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~/~~\\~~~~/\\~
                               ^ threshold crossing, then back along the rise to zero

Walk back from the peak as long as the waveform stays above a threshold, with gaps of less than `quiet_ms`. The
threshold clears the noise before the rise and 10 % of the peak; where that is late on a slow rise, the line
through the crossing and the half-peak leads back to zero.
"""

import numpy as np
from numpy.typing import NDArray

from ..ruleset import OnsetRules
from ..units import samples_from_ms
from .gather import gather

_PREFERENCE = 2.0  # the difference also sharpens noise: it has to be clearer by this much
_PASSES = 2  # the second starts from the first one's onset, so that the scan's grid leaves no trace


def refine_onsets(
    samples: NDArray[np.float32], guesses: NDArray[np.intp], *, rate_hz: int, rules: OnsetRules
) -> NDArray[np.intp]:
    """Return the onset of each guess, shape (n,): the index into `samples` of the first sample of the rise."""
    onsets = guesses
    if onsets.size:
        for _ in range(_PASSES):
            onsets = _clearest(samples, onsets, rate_hz=rate_hz, rules=rules)
    return onsets


def _clearest(
    samples: NDArray[np.float32], guesses: NDArray[np.intp], *, rate_hz: int, rules: OnsetRules
) -> NDArray[np.intp]:
    """Walk back in the waveform and in its first difference, and believe the one in which the rise stands out more.

    Under music or an engine a crack is clear only in the difference; a far, dull shot only in the waveform.
    """
    search = samples_from_ms(rules.search_ms, rate_hz)
    before = search + samples_from_ms(rules.noise_ms, rate_hz)
    wave = gather(samples, guesses - before - 1, before + 1 + search)
    plain, clear = _walk_back(wave[:, 1:], rate_hz=rate_hz, rules=rules)
    steep, sharp = _walk_back(np.diff(wave, axis=1), rate_hz=rate_hz, rules=rules)
    chosen = np.where(sharp > _PREFERENCE * clear, steep, plain)
    return np.asarray(np.clip(guesses + chosen - before, 0, samples.shape[0] - 1), np.intp)


def _walk_back(
    wave: NDArray[np.float32], *, rate_hz: int, rules: OnsetRules
) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
    """Return where in each row of `wave` (noise first, then the search) the rise starts, and how it stands out."""
    noise = samples_from_ms(rules.noise_ms, rate_hz)
    quiet = max(1, samples_from_ms(rules.quiet_ms, rate_hz))
    magnitude = np.abs(wave - wave[:, :noise].mean(axis=1, keepdims=True))
    rise = magnitude[:, noise:]
    peak_at = noise + rise.argmax(axis=1)
    peak = magnitude[np.arange(wave.shape[0]), peak_at]
    loudest = magnitude[:, :noise].max(axis=1)
    threshold = np.maximum(rules.noise_ratio * loudest, rules.peak_ratio * peak)
    threshold = np.minimum(threshold, 0.5 * peak)
    start = _group_start(magnitude >= threshold[:, None], peak_at, quiet)
    start -= _rise_before(magnitude, start, peak_at, threshold, peak)
    return start, peak / np.maximum(loudest, 1e-12)


def _group_start(above: NDArray[np.bool_], peak_at: NDArray[np.intp], quiet: int) -> NDArray[np.intp]:
    """Return where the group of samples above the threshold that holds the peak begins."""
    place = np.arange(above.shape[1], dtype=np.int32)
    last = np.maximum.accumulate(np.where(above, place, np.int32(-quiet - 1)), axis=1)
    starts = above & (place <= peak_at[:, None])
    starts[:, 1:] &= place[1:] - last[:, :-1] > quiet
    return np.asarray(np.where(starts, place, np.int32(0)).max(axis=1), np.intp)


def _rise_before(
    magnitude: NDArray[np.float32],
    start: NDArray[np.intp],
    peak_at: NDArray[np.intp],
    threshold: NDArray[np.float32],
    peak: NDArray[np.float32],
) -> NDArray[np.intp]:
    """Return how many samples before the crossing a straight rise through crossing and half-peak leaves zero."""
    place = np.arange(magnitude.shape[1])
    half = np.maximum(0.5 * peak, threshold)
    reached = (magnitude >= half[:, None]) & (place >= start[:, None])
    half_at = np.where(reached.any(axis=1), reached.argmax(axis=1), peak_at)
    level = magnitude[np.arange(start.size), start]
    gained = (magnitude[np.arange(start.size), half_at] - level).astype(np.float64)
    run = (half_at - start).astype(np.float64)
    back = np.divide(level * run, gained, out=np.zeros_like(run), where=(gained > 0.0) & (run > 0))
    # a rise is no longer than what it took from the crossing to the half-peak and as much again
    return np.floor(np.minimum(back, 2.0 * run + 1.0)).astype(np.intp)

"""The first sample of a candidate's rise: where the sound changes from what was before into the shot.

              before       |   after
    ~~~~~~~~~~~~~~~~~~~~~~~~/\\/\\/\\/|\\
                           ^     peak

Of all places to part the sound until just after its peak in two, the best explains both sides as noise of one power
each (the maximum-likelihood change point; Maeda 1985 picks the onsets of earthquakes so):

    k log(p(0, k) + q) + (n - k) log(p(k, n) + q)  is least,   p: mean power,   q: (`floor_ratio` x the peak)^2

It works on differences, in which neither a constant nor a slow swing counts, and weighs every sample, not a few loud
ones. The floor q keeps it from falling for what lies far beneath the shot: the pre-echo of a lossy codec, or the first
breath after silence. What only a film of a higher rate can hold has no say: of two changes of nearly one likelihood it
would choose the other.
"""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..ruleset import OnsetRules
from ..units import samples_from_ms
from .gather import gather

_PASSES = 2  # the second starts from the first one's onset, so that the scan's grid leaves no trace
_FAST_LAG_MS = 1.0 / 48.0  # a sample of a film's usual rate: at higher ones the same frequencies count
_SLOW_LAG_MS = 0.5  # halves 160 Hz and weakens what is below it more: a dull shot is left, an engine is not
_LAGS_MS = _SLOW_LAG_MS, _FAST_LAG_MS
_LONGEST_RISE_MS = 2.5
_LEAST_MS = 0.5, 0.15  # a power needs so much sound before and after the change
_BAND_HZ = 18_000.0, 20_000.0  # a film of 44.1 kHz holds it: from where to where the low-pass falls
_STOPBAND_DB = 40.0
_AT_ONCE = 256  # guesses whose surroundings are held together
_BLOCK = 64  # samples that are low-passed together


@dataclass(frozen=True, eq=False)
class _Changes:
    """Of n guesses, in the difference over each lag: where the change is looked for from, where it is, what it gains.

    All have shape (n, lags); a gain is how much more likely the change is than none (log, in samples).
    """

    start: NDArray[np.intp]
    at: NDArray[np.intp]
    gained: NDArray[np.float64]


def refine_onsets(
    samples: NDArray[np.float32],
    guesses: NDArray[np.intp],
    *,
    rate_hz: int,
    rules: OnsetRules,
    since: NDArray[np.intp] | None = None,
) -> NDArray[np.intp]:
    """Return the onset of each guess, shape (n,): the index into `samples` of the first sample of the rise.

    What was before it is listened to from `since` on, where given, indices of shape (n,): of two sounds in a row the
    second begins after the first.
    """
    found = [guesses[:0]]
    for first in range(0, guesses.size, _AT_ONCE):
        some = guesses[first : first + _AT_ONCE]
        around, places = _low_passed_around(samples, some, rate_hz=rate_hz, rules=rules)
        moved = some - places
        earliest = places - some if since is None else since[first : first + _AT_ONCE] - moved
        onsets, change = some, None
        for _ in range(_PASSES):
            change = _changes(around, onsets - moved, earliest, change, rate_hz=rate_hz, rules=rules)
            # what was before the first sample is not known: a rise by the second begins with the film
            onsets = _clearest(change) + moved
            onsets[onsets <= 1] = 0
            onsets = np.minimum(onsets, samples.shape[0] - 1)
        found.append(onsets)
    return np.concatenate(found)


def farthest_ms(rules: OnsetRules) -> float:
    """Return how far an onset may lie from its guess."""
    return _PASSES * (rules.search_ms + rules.noise_ms + _LONGEST_RISE_MS)


def _low_passed_around(
    samples: NDArray[np.float32], guesses: NDArray[np.intp], *, rate_hz: int, rules: OnsetRules
) -> tuple[NDArray[np.float32], NDArray[np.intp]]:
    """Return all that is heard of each guess, low-passed, one after another, and the index of each guess in it."""
    before = samples_from_ms(farthest_ms(rules) + _SLOW_LAG_MS, rate_hz) + 1
    after = samples_from_ms(_PASSES * (rules.search_ms + rules.after_ms), rate_hz) + 1
    filtering = _low_pass_matrix(rate_hz)
    taken, given = filtering.shape
    blocks = -(-(before + after) // given)
    starts = (guesses - before - (taken - given) // 2)[:, None] + given * np.arange(blocks)
    heard = gather(samples, starts.ravel(), taken) @ filtering
    return heard.ravel(), before + blocks * given * np.arange(guesses.size)


@cache
def _low_pass_matrix(rate_hz: int) -> NDArray[np.float32]:
    """Return what makes a block of low-passed samples of a longer one, shape (taken, given).

    A matrix product filters block beside block in an eighth of the time that a filter takes sample by sample.
    """
    taps = _low_pass(rate_hz)
    matrix = np.zeros((_BLOCK + taps.size - 1, _BLOCK), np.float32)
    for column in range(_BLOCK):
        matrix[column : column + taps.size, column] = taps
    return matrix


def _low_pass(rate_hz: int) -> NDArray[np.float64]:
    """Return a symmetric FIR low-pass by Kaiser's window, shape (odd,); one that does nothing where all is in band.

    By his formulas (1974) for a stopband of 21 to 50 dB: importing scipy.signal takes longer than all onsets of a film.
    """
    falls_from, falls_to = _BAND_HZ
    if rate_hz <= 2.0 * falls_to:
        return np.ones(1)
    over_21_db = _STOPBAND_DB - 21.0
    beta = 0.5842 * over_21_db**0.4 + 0.07886 * over_21_db
    half = math.ceil((_STOPBAND_DB - 7.95) / (2.285 * 2.0 * math.pi * (falls_to - falls_from) / rate_hz) / 2.0)
    passed = (falls_from + falls_to) / rate_hz  # the cutoff, midway, in half sample rates
    taps = np.sinc(passed * np.arange(-half, half + 1)) * np.kaiser(2 * half + 1, beta)
    return np.asarray(taps / taps.sum(), np.float64)


def _clearest(changes: _Changes) -> NDArray[np.intp]:
    """Return the greater of the two changes of each guess.

    Under music or an engine a crack is clear only in the fast one; a far, dull shot only in the slow one.
    """
    slow, fast = range(len(_LAGS_MS))
    clearer = changes.gained[:, fast] > changes.gained[:, slow]
    return np.asarray(np.where(clearer, changes.at[:, fast], changes.at[:, slow]), np.intp)


def _changes(
    samples: NDArray[np.float32],
    guesses: NDArray[np.intp],
    earliest: NDArray[np.intp],
    before: _Changes | None,
    *,
    rate_hz: int,
    rules: OnsetRules,
) -> _Changes:
    """Look for the change in the difference over half a millisecond and over a sample.

    What was found in the pass before is kept where it was looked for from the same place.
    """
    shape = guesses.size, len(_LAGS_MS)
    start, at, gained = np.empty(shape, np.intp), np.empty(shape, np.intp), np.empty(shape)
    if before is not None:
        at[:], gained[:] = before.at, before.gained
    for index, lag_ms in enumerate(_LAGS_MS):
        lag = max(1, samples_from_ms(lag_ms, rate_hz))
        start[:, index], peak = _attack(samples, guesses, lag, rate_hz, rules)
        new = np.arange(guesses.size) if before is None else np.flatnonzero(start[:, index] != before.start[:, index])
        at[new, index], gained[new, index] = _change_at(
            samples, start[new, index], peak[new], earliest[new], lag, rate_hz, rules
        )
    return _Changes(start, at, gained)


def _attack(
    samples: NDArray[np.float32], guesses: NDArray[np.intp], lag: int, rate_hz: int, rules: OnsetRules
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return from where the change is looked for in the difference over a lag, and the peak that it leads to."""
    search, before = (samples_from_ms(ms, rate_hz) for ms in (rules.search_ms, rules.noise_ms))
    around = np.abs(_differences(samples, guesses - search, 2 * search, lag))
    loudest = around.argmax(axis=1)
    return guesses - search + loudest - before, around[np.arange(loudest.size), loudest]


def _change_at(
    samples: NDArray[np.float32],
    start: NDArray[np.intp],
    peak: NDArray[np.float64],
    earliest: NDArray[np.intp],
    lag: int,
    rate_hz: int,
    rules: OnsetRules,
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return where the difference over a lag changes on its way to its peak, and how much more likely than nowhere."""
    before, after = (samples_from_ms(ms, rate_hz) for ms in (rules.noise_ms, rules.after_ms))
    wave = _differences(samples, start, before + after, lag)
    first = np.clip(earliest - start, 0, before // 2)
    change, gained = _change(wave, first, rules.floor_ratio * peak, rate_hz)
    longest_rise = samples_from_ms(_LONGEST_RISE_MS, rate_hz)
    return start + change - _rise_before(np.abs(wave), change, peak, longest_rise), gained


def _differences(samples: NDArray[np.float32], starts: NDArray[np.intp], length: int, lag: int) -> NDArray[np.float64]:
    """Return x[n] - x[n - lag] for `length` samples from each start, shape (n, length)."""
    wave = gather(samples, starts - lag, length + lag).astype(np.float64)
    return np.asarray(wave[:, lag:] - wave[:, :-lag], np.float64)


def _change(
    wave: NDArray[np.float64], first: NDArray[np.intp], floor: NDArray[np.float64], rate_hz: int
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return where in each row the power changes, and how much more likely that is than no change (log, in samples).

    Each row counts from its sample `first` on.
    """
    size = wave.shape[1]
    least_before, least_after = (max(1, samples_from_ms(least, rate_hz)) for least in _LEAST_MS)
    energy = np.cumsum(np.square(wave), axis=1)
    ignored = np.where(first > 0, energy[np.arange(first.size), first - 1], 0.0)[:, None]
    quiet = np.square(floor)[:, None] + 1e-30
    parted = np.arange(float(least_before), float(size - least_after))
    heard, left = np.maximum(parted - first[:, None], 1.0), size - parted
    head = energy[:, least_before - 1 : size - least_after - 1]
    unlikely = heard * _log_power(np.maximum(head - ignored, 0.0), heard, quiet)
    unlikely += left * _log_power(energy[:, -1:] - head, left, quiet)
    unlikely[parted < first[:, None] + least_before] = np.inf
    best = unlikely.argmin(axis=1)
    length = size - first[:, None]
    whole = length * _log_power(energy[:, -1:] - ignored, length, quiet)
    return np.asarray(least_before + best, np.intp), whole[:, 0] - unlikely[np.arange(best.size), best]


def _log_power(
    energy: NDArray[np.float64], samples: NDArray[np.float64] | NDArray[np.intp], floor: NDArray[np.float64]
) -> NDArray[np.float64]:
    power = energy / samples
    power += floor
    return np.log(power, out=power)


def _rise_before(
    magnitude: NDArray[np.float64], change: NDArray[np.intp], peak: NDArray[np.float64], longest: int
) -> NDArray[np.intp]:
    """Return how many samples before the change a straight rise through it and the half-peak leaves zero.

    0 where the change is to more than a quarter of the peak at once: that is a step, not a place on a rise.
    """
    row = np.arange(change.size)
    reached = (magnitude >= 0.5 * peak[:, None]) & (np.arange(magnitude.shape[1]) > change[:, None])
    run = np.where(reached.any(axis=1), reached.argmax(axis=1) - change, 0).astype(np.float64)
    level = magnitude[row, change]
    gained = magnitude[row, change + run.astype(np.intp)] - level
    back = np.divide(level * run, gained, out=np.zeros_like(run), where=gained > 0.0)
    back[level > 0.25 * peak] = 0.0
    return np.floor(np.minimum(back, longest)).astype(np.intp)

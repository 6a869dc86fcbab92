"""A shot's discrete reflections: where the sound after the blast answers to the blast as a mirror would.

    answer  the cross-spectrum of sound and blast over the sound's own smoothed power, back in time: a matched filter in
            which every frequency weighs alike, so that a copy of the blast is a spike however long the blast rolls on
    z       its envelope over the median of 8 ms before and after: a tail full of overlapping echoes, noise and music
            lie near 1, a discrete echo stands out, and its neighbours do not hide it

Once in a wide band and once in the low one that is left of an echo off something soft; the clearer one counts. What the
sound before the shot answers as loudly (a voice, an engine, a drum) is no echo.

Echoes thin out with their lag, about as 1 / lag, while chance does not, and noise exceeds z with exp(-pi z^2 / 4)
(Rayleigh): for the same odds z^2 has to grow by 4 / pi log(lag / 30 ms).
"""

import numpy as np
from numpy.typing import NDArray

from ..ruleset import SegmentRules
from ..units import samples_from_ms

_BANDS_HZ = ((400.0, 12_000.0), (300.0, 3_000.0))
_SMOOTH_HZ = 300.0
_AROUND_MS, _GRAIN_MS = 8.0, 1.0
_USUAL_LAG_MS = 30.0
_APART_MS = 3.0
_FADE_MS = 6.0
_USUAL, _UNUSUAL = 0.95, 1.2
_OVERSAMPLING = 2  # a spike between two values is at most 0.9 dB higher than they are
_FAINTEST = 1e-30


def discrete_reflections(
    wave: NDArray[np.float64], before: NDArray[np.float64], *, rate_hz: int, rules: SegmentRules
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return the reflections' lags in samples, ascending, and their gains.

    `wave` begins with the onset, and `before` is what lies directly before it.
    """
    from scipy.signal import find_peaks

    template = wave[: samples_from_ms(rules.longest_blast_ms, rate_hz)]
    latest = min(samples_from_ms(rules.latest_reflection_ms, rate_hz), wave.shape[0] - template.shape[0])
    earliest = samples_from_ms(rules.earliest_reflection_ms, rate_hz)
    if latest <= earliest or not template.any():
        return np.zeros(0, np.intp), np.zeros(0)
    heard = np.concatenate([before, wave[: latest + template.shape[0]]])
    step, answers = _answers(_faded(heard, rate_hz), _faded(template, rate_hz), rate_hz)
    first = int(np.ceil((before.shape[0] + earliest) / step))  # the blast answers to itself until then
    count = int((before.shape[0] + latest) / step) + 1
    silent = int(max(0, before.shape[0] - samples_from_ms(_APART_MS, rate_hz)) / step)
    lag_ms = (np.arange(first, count) * step - before.shape[0]) * 1000.0 / rate_hz
    rarer = 4.0 / np.pi * np.log(np.maximum(lag_ms / _USUAL_LAG_MS, 1.0))
    clearest, gain = np.zeros(count - first), np.zeros(count - first)
    for answer in answers:
        after = answer[first:count]
        z = after / (_around(after, rate_hz / step) + _FAINTEST)
        z[after < _UNUSUAL * _usual(answer[:silent], rate_hz / step)] = 0.0
        z = np.sqrt(np.maximum(z**2 - rarer, 0.0))
        gain = np.where(z > clearest, after, gain)
        clearest = np.maximum(clearest, z)
    apart = max(1, int(samples_from_ms(_APART_MS, rate_hz) / step))
    peaks, _ = find_peaks(clearest, height=rules.reflection_prominence, distance=apart)
    lags = np.round((first + peaks + _vertex(gain, peaks)) * step - before.shape[0]).astype(np.intp)
    return lags, gain[peaks]


def _answers(
    heard: NDArray[np.float64], template: NDArray[np.float64], rate_hz: int
) -> tuple[float, list[NDArray[np.float64]]]:
    """Return how many samples lie between two values of the answers, and in each band the answer to the template."""
    from scipy.fft import ifft, next_fast_len, rfft

    size = next_fast_len(heard.shape[0] + template.shape[0], real=True)
    whole, first = rfft(heard, size), rfft(template, size)
    bands = [_bins(band, size, rate_hz) for band in _BANDS_HZ]
    length = next_fast_len(_OVERSAMPLING * max(band.stop - band.start for band in bands))
    answers = []
    for band in bands:
        power = _running_mean(np.abs(whole[band]) ** 2, max(1, int(_SMOOTH_HZ * size / rate_hz)))
        weight = 1.0 / (power + _FAINTEST)
        own = float(np.sum(np.abs(first[band]) ** 2 * weight)) / length
        answer = np.abs(ifft(whole[band] * np.conj(first[band]) * weight, length))
        answers.append(answer / max(own, _FAINTEST))
    return size / length, answers


def _faded(wave: NDArray[np.float64], rate_hz: int) -> NDArray[np.float64]:
    """Return a sound that ends in half a cosine, of 6 ms or half its length."""
    fade = min(samples_from_ms(_FADE_MS, rate_hz), wave.shape[0] // 2)
    faded = wave.copy()
    faded[wave.shape[0] - fade :] *= np.cos(np.linspace(0.0, 0.5 * np.pi, fade)) ** 2
    return faded


def _bins(band_hz: tuple[float, float], size: int, rate_hz: int) -> slice:
    low_hz, high_hz = band_hz
    return slice(int(low_hz * size / rate_hz), int(min(high_hz, 0.45 * rate_hz) * size / rate_hz))


def _around(answer: NDArray[np.float64], values_per_s: float) -> NDArray[np.float64]:
    """Return the median around each value, of the means of a millisecond each."""
    grain = max(1, int(_GRAIN_MS * 1e-3 * values_per_s))
    missing = -answer.shape[0] % grain
    means = np.pad(answer, (0, missing), mode="edge").reshape(-1, grain).mean(axis=1)
    reach = min(int(_AROUND_MS / _GRAIN_MS), means.shape[0] - 1)
    views = np.lib.stride_tricks.sliding_window_view(np.pad(means, reach, mode="reflect"), 2 * reach + 1)
    return np.asarray(np.repeat(np.median(views, axis=1), grain)[: answer.shape[0]], np.float64)


def _usual(answer: NDArray[np.float64], values_per_s: float) -> float:
    """Return what the peaks of one millisecond in twenty reach: knocks in a row do, an earlier shot is too rare."""
    grain = max(1, int(_GRAIN_MS * 1e-3 * values_per_s))
    whole = answer[answer.shape[0] % grain :].reshape(-1, grain)
    return float(np.quantile(whole.max(axis=1), _USUAL)) if whole.size else 0.0


def _running_mean(values: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """Return the mean of so many values around each; what lies beyond the ends mirrors what is before."""
    from scipy.ndimage import uniform_filter1d

    return np.asarray(uniform_filter1d(values, width, mode="reflect"), np.float64)


def _vertex(values: NDArray[np.float64], peaks: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return how far beside each peak the parabola through it and its neighbours has its vertex."""
    left, middle, right = (values[np.clip(peaks + by, 0, values.shape[0] - 1)] for by in (-1, 0, 1))
    bend = left - 2.0 * middle + right
    away = np.divide(0.5 * (left - right), bend, out=np.zeros_like(middle), where=bend < 0.0)
    return np.clip(away, -0.5, 0.5)

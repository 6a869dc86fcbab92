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

from ..correlate import parabolic_offsets, parabolic_peaks
from ..ruleset import SegmentRules
from ..units import samples_from_ms

_BANDS_HZ = ((400.0, 12_000.0), (300.0, 3_000.0))
_SMOOTH_HZ = 300.0
_AROUND_MS, _GRAIN_MS = 8.0, 1.0
_USUAL_LAG_MS = 30.0
_APART_MS = 3.0
_FADE_MS = 6.0
_BACKGROUND_QUANTILE = 0.95  # of the peaks of each millisecond: knocks in a row reach it, an earlier shot is too rare
_OVER_BACKGROUND = 1.2  # what answers no louder than the sound before the shot is no echo
_OVERSAMPLING = 2  # a spike between two values is at most 0.9 dB higher than they are
_FAINTEST = 1e-30


def discrete_reflections(
    wave: NDArray[np.float64], before: NDArray[np.float64], *, rate_hz: int, rules: SegmentRules
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return the lags of n reflections in samples, ascending, and their gains against the blast, shape (n,) each.

    `wave`, shape (frames,), begins with the onset, and `before` is what lies directly before it.
    """
    from scipy.signal import find_peaks

    template = wave[: max(1, samples_from_ms(rules.longest_blast_ms, rate_hz))]
    latest = min(samples_from_ms(rules.latest_reflection_ms, rate_hz), wave.shape[0] - template.shape[0])
    earliest = samples_from_ms(rules.earliest_reflection_ms, rate_hz)
    if latest <= earliest or not template.any():
        return np.zeros(0, np.intp), np.zeros(0)
    step, answers = _answers(np.concatenate([before, wave[: latest + template.shape[0]]]), template, rate_hz)
    first = int(np.ceil((before.shape[0] + earliest) / step))  # the blast answers to itself until then
    count = int((before.shape[0] + latest) / step) + 1
    if count <= first:  # the film ends so soon that no value lies between the earliest lag and the latest
        return np.zeros(0, np.intp), np.zeros(0)
    silent = int(max(0, before.shape[0] - samples_from_ms(_APART_MS, rate_hz)) / step)
    grain = max(1, int(_GRAIN_MS * 1e-3 * rate_hz / step))
    heard = [BandAnswer(answer[first:count], answer[:silent], grain) for answer in answers]
    # what stands out nowhere, and lies beside nothing that does, need not be weighed
    spikes = np.logical_or.reduce([each.spikes(rules.reflection_prominence) for each in heard])
    near = np.unique(np.clip(np.flatnonzero(spikes)[:, None] + np.arange(-1, 2), 0, count - first - 1))
    lag_ms = ((first + near) * step - before.shape[0]) * 1000.0 / rate_hz
    clearest, gain = np.zeros(count - first), np.zeros(count - first)
    for each in heard:
        z = each.clearness(near, lag_ms)
        gain[near] = np.where(z > clearest[near], each.answer[near], gain[near])
        clearest[near] = np.maximum(clearest[near], z)
    apart = max(1, int(samples_from_ms(_APART_MS, rate_hz) / step))
    peaks, _ = find_peaks(clearest, height=rules.reflection_prominence, distance=apart)
    beside = parabolic_offsets(gain, peaks)
    lags = np.round((first + peaks + beside) * step - before.shape[0]).astype(np.intp)
    return lags, _gains(parabolic_peaks(gain, peaks, beside), lags, template.shape[0], rate_hz)


def _gains(
    answers: NDArray[np.float64], lags: NDArray[np.intp], template_frames: int, rate_hz: int
) -> NDArray[np.float64]:
    """Return the gains g of echoes at some lags t that make the blast, with what follows in the template, answer so.

    An echo ripples the sound's power by cos(2 pi f t). What of that is left when it is smoothed over `_SMOOTH_HZ`, the
    whitening takes for the sound's own colour: 1 - sinc(t `_SMOOTH_HZ`) of the answer is left. And what of the echo is
    in the template, a g of it, makes that stronger: the answer is g / (1 + a^2 g^2).
    """
    answers = answers / (1.0 - np.sinc(_SMOOTH_HZ * lags / rate_hz))
    whole = np.ones(template_frames)
    _fade(whole, rate_hz)
    inside = np.where(lags < template_frames, whole[np.minimum(lags, template_frames - 1)], 0.0)
    strength = np.minimum(inside * answers, 0.5)  # a g = 1 and more: as loud as the blast
    return np.asarray(answers * 2.0 / (1.0 + np.sqrt(1.0 - 4.0 * strength**2)), np.float64)


class BandAnswer:
    """The answers of one band after the blast, and the level that they have to exceed to be clear."""

    def __init__(self, answer: NDArray[np.float64], silent: NDArray[np.float64], grain: int) -> None:
        """Take the answers after the blast and those before the shot; `grain` values are a millisecond."""
        self.answer = answer
        self._loud = max(_OVER_BACKGROUND * _background(silent, grain), _FAINTEST)
        self._around = _around(answer, grain) + _FAINTEST

    def spikes(self, prominence: float) -> NDArray[np.bool_]:
        """Return which values of `answer` stand out by so much, however late they come."""
        return (self.answer >= self._loud) & (self.answer >= prominence * self._around)

    def clearness(self, places: NDArray[np.intp], lag_ms: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return z of some values at these lags, less what the later ones have to have more; 0 for the usual ones."""
        z = self.answer[places] / self._around[places]
        rarer = 4.0 / np.pi * np.log(np.maximum(lag_ms / _USUAL_LAG_MS, 1.0))
        z = np.sqrt(np.maximum(np.square(z) - rarer, 0.0))
        return np.where(self.answer[places] < self._loud, 0.0, z)


def _answers(
    heard: NDArray[np.float64], template: NDArray[np.float64], rate_hz: int
) -> tuple[float, list[NDArray[np.float64]]]:
    """Return how many samples lie between two values of the answers, and in each band the answer to the template."""
    from scipy.fft import ifft, next_fast_len, rfft

    size = next_fast_len(heard.shape[0] + template.shape[0], real=True)
    both = np.zeros((2, size))  # transforms side by side take half the time of one after the other
    for row, wave in zip(both, (heard, template), strict=True):
        row[: wave.shape[0]] = wave
        _fade(row[: wave.shape[0]], rate_hz)
    whole, first = rfft(both, axis=1)
    bands = [_bins(band, size, rate_hz) for band in _BANDS_HZ]
    length = next_fast_len(_OVERSAMPLING * max(band.stop - band.start for band in bands))
    crossed, own = np.zeros((len(bands), length), np.complex128), []
    for row, band in zip(crossed, bands, strict=True):
        power = _running_mean(_power(whole[band]), max(1, int(_SMOOTH_HZ * size / rate_hz)))
        weight = 1.0 / (power + _FAINTEST)
        own.append(max(float(_power(first[band]) @ weight) / length, _FAINTEST))
        row[: power.shape[0]] = whole[band] * np.conj(first[band]) * weight
    answers = np.abs(ifft(crossed, axis=1))
    return size / length, [answer / gain for answer, gain in zip(answers, own, strict=True)]


def _power(spectrum: NDArray[np.complex128]) -> NDArray[np.float64]:
    return np.square(spectrum.real) + np.square(spectrum.imag)


def _fade(wave: NDArray[np.float64], rate_hz: int) -> None:
    """Let a sound end in half a cosine, of 6 ms or half its length."""
    fade = min(samples_from_ms(_FADE_MS, rate_hz), wave.shape[0] // 2)
    wave[wave.shape[0] - fade :] *= np.cos(np.linspace(0.0, 0.5 * np.pi, fade)) ** 2


def _bins(band_hz: tuple[float, float], size: int, rate_hz: int) -> slice:
    low_hz, high_hz = band_hz
    return slice(int(low_hz * size / rate_hz), int(min(high_hz, 0.45 * rate_hz) * size / rate_hz))


def _around(answer: NDArray[np.float64], grain: int) -> NDArray[np.float64]:
    """Return the median around each value, of the means of a millisecond, `grain` values, each."""
    from scipy.ndimage import median_filter

    missing = -answer.shape[0] % grain
    means = np.add.reduceat(answer, np.arange(0, answer.shape[0], grain)) / grain
    means[-1] += missing * answer[-1] / grain
    reach = min(int(_AROUND_MS / _GRAIN_MS), means.shape[0] - 1)
    medians = median_filter(means, 2 * reach + 1, mode="mirror")
    return np.asarray(np.repeat(medians, grain)[: answer.shape[0]], np.float64)


def _background(answer: NDArray[np.float64], grain: int) -> float:
    """Return the `_BACKGROUND_QUANTILE` of the peaks of each millisecond, `grain` values."""
    starts = np.arange(answer.shape[0] % grain, answer.shape[0], grain)
    if not starts.size:
        return 0.0
    peaks = np.sort(np.maximum.reduceat(answer, starts))
    place = _BACKGROUND_QUANTILE * (peaks.size - 1)
    below = int(place)
    above = min(below + 1, peaks.size - 1)
    return float(peaks[below] + (place - below) * (peaks[above] - peaks[below]))


def _running_mean(values: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """Return the mean of so many values around each; what lies beyond the ends mirrors what is before."""
    from scipy.ndimage import uniform_filter1d

    return np.asarray(uniform_filter1d(values, width, mode="reflect"), np.float64)

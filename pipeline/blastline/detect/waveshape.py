"""A candidate's waveform: its rise, its first lobe, and how much of noise or of tone follows."""

import itertools

import numpy as np
from numpy.typing import NDArray

from ..units import samples_from_ms
from .gather import gather

WAVE_MS = (0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
SPECTRA_MS = ((1.0, 22.0), (22.0, 64.0), (64.0, 150.0))
SPECTRUM_EDGES_HZ = (60.0, 250.0, 800.0, 2500.0, 8000.0)


def waveshape_names() -> tuple[str, ...]:
    """Return the names of the columns of `waveshape`, in order."""
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
    return (*wave, *spectra)


def waveshape(samples: NDArray[np.float32], onsets: NDArray[np.intp], rate_hz: int) -> NDArray[np.float64]:
    """Return the shape of the waveform after each onset, an index into `samples`: (n, columns)."""
    return np.concatenate([_rise(samples, onsets, rate_hz), _spectra(samples, onsets, rate_hz)], axis=1)


def _rise(samples: NDArray[np.float32], onsets: NDArray[np.intp], rate_hz: int) -> NDArray[np.float64]:
    edges = [samples_from_ms(ms, rate_hz) for ms in WAVE_MS]
    wave = gather(samples, onsets, edges[-1])
    slope = np.diff(wave, axis=1, prepend=np.float32(0.0))
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
        wave = gather(samples, onsets + start, stop - start) * np.hanning(stop - start).astype(np.float32)
        length = next_fast_len(stop - start, real=True)
        spectrum = rfft(wave, length, axis=1)
        power = spectrum.real**2 + spectrum.imag**2 + np.float32(1e-14)
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

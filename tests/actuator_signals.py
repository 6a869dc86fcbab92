"""A synthetic actuator for tests: its exact response, and recordings of what it makes of noise."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from blastline.actuator import Recording, record
from blastline.model import Clip, Span

Samples = NDArray[np.float64]


@dataclass(frozen=True)
class Seat:
    """A mass on a spring above a first-order high-pass: resonance, damping, corner, delay and sign."""

    resonance_hz: float = 292.0
    damping: float = 0.15
    corner_hz: float = 25.0
    gain: float = 0.5
    delay_s: float = 0.01234
    sign: float = 1.0

    def at(self, frequencies_hz: Samples) -> NDArray[np.complex128]:
        """Return the exact response without its delay and sign."""
        s = 2j * math.pi * frequencies_hz
        w, corner = 2.0 * math.pi * self.resonance_hz, 2.0 * math.pi * self.corner_hz
        return np.asarray(self.gain * w * w / (s * s + 2.0 * self.damping * w * s + w * w) * s / (s + corner))

    def level_db(self, frequencies_hz: Samples) -> Samples:
        return np.asarray(20.0 * np.log10(np.abs(self.at(frequencies_hz))))


@dataclass(frozen=True, eq=False)
class Held:
    """A track in memory."""

    samples: Samples
    rate_hz: int
    damaged_samples: int = 0

    def blocks(self) -> Iterator[Clip]:
        for start in range(0, len(self.samples), 10_000):
            yield Clip(self.samples[start : start + 10_000, None], self.rate_hz, start)

    def read(self, span: Span, /, *, sides: bool = False) -> Clip:
        assert 0 <= span.start <= span.stop <= len(self.samples)
        return Clip(self.samples[span.start : span.stop, None], self.rate_hz, span.start)


def run_through(seat: Seat, sent: Samples, rate_hz: int, *, snr_db: float = 40.0, seed: int = 0) -> Samples:
    """Return what a seat makes of a signal, a second longer than it, with white noise `snr_db` below in power.

    The response is applied exactly, in the frequency domain: a delay may be any fraction of a sample.
    """
    size = len(sent) + rate_hz
    frequencies_hz = np.asarray(np.fft.rfftfreq(size, 1.0 / rate_hz), dtype=np.float64)
    turned = seat.sign * seat.at(frequencies_hz) * np.exp(-2j * math.pi * frequencies_hz * seat.delay_s)
    came = np.fft.irfft(np.fft.rfft(sent, size) * turned, size)
    noise = np.random.default_rng(seed + 1).normal(0.0, 1.0, size)
    return np.asarray(came + noise * (np.std(came) * 10.0 ** (-snr_db / 20.0)))


def noise(length_s: float, rate_hz: int, *, seed: int = 0) -> Samples:
    return np.random.default_rng(seed).normal(0.0, 0.1, round(length_s * rate_hz))


def run_of(
    seat: Seat, *, rate_hz: int = 48_000, length_s: float = 20.0, snr_db: float = 40.0, seed: int = 0
) -> tuple[Recording, Recording]:
    """Return the recordings of a run: excitation and response."""
    sent = noise(length_s, rate_hz, seed=seed)
    came = run_through(seat, sent, rate_hz, snr_db=snr_db, seed=seed)
    return recording("sent.wav", sent, rate_hz), recording("came.wav", came, rate_hz)


def recording(name: str, samples: Samples, rate_hz: int) -> Recording:
    return record(name, Held(samples, rate_hz))

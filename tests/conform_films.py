"""Films for the tests of conforming: sound that never repeats, with bangs, held in memory."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from blastline.conform import Film, hear
from blastline.model import Clip, Span

RATE_HZ = 16_000
Samples = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class InMemory:
    """Samples that can be cut like a file."""

    samples: Samples
    rate_hz: int = RATE_HZ

    def read(self, span: Span, *, sides: bool = False) -> Clip:
        assert 0 <= span.start <= span.stop <= len(self.samples)
        return Clip(self.samples[span.start : span.stop, None], self.rate_hz, span.start)

    def blocks(self, size: int = 65_536) -> Iterator[Clip]:
        for start in range(0, len(self.samples), size):
            yield Clip(self.samples[start : start + size, None].astype(np.float32), self.rate_hz, start)


def heard(samples: Samples, rate_hz: int = RATE_HZ) -> Film:
    """Return samples as a film that was listened to."""
    file = InMemory(samples, rate_hz)
    return hear(file, file.blocks())


def murmur(length_s: float, *, seed: int, rate_hz: int = RATE_HZ) -> Samples:
    """Return noise whose level and colour wander, as a film's sound does."""
    rng = np.random.default_rng(seed)
    count = round(length_s * rate_hz)
    knots = np.arange(0.0, length_s + 0.25, 0.1)
    times = np.arange(count) / rate_hz
    level = np.exp(np.interp(times, knots, rng.normal(-4.5, 1.0, len(knots))))
    tilt = np.interp(times, knots, rng.uniform(0.0, 0.95, len(knots)))
    noise = rng.normal(size=count)
    return np.asarray(level * (noise - tilt * np.roll(noise, 1)))


def steady(length_s: float, onsets_s: Sequence[float], *, seed: int) -> Samples:
    """Return a film of nothing but hiss, as of rain or air conditioning, with a shot of its own at each onset."""
    samples: Samples = 0.0045 * np.random.default_rng(seed).normal(size=round(length_s * RATE_HZ))
    for number, onset_s in enumerate(onsets_s):
        put(samples, bang(seed=1000 * seed + number), onset_s)
    return samples


def bang(*, seed: int, rate_hz: int = RATE_HZ) -> Samples:
    """Return a shot with a tail of 300 ms."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(round(0.3 * rate_hz)) / rate_hz
    return np.asarray(0.5 * np.exp(-time_s / 0.04) * rng.normal(size=len(time_s)))


def film(length_s: float, onsets_s: Sequence[float], *, seed: int, rate_hz: int = RATE_HZ) -> Samples:
    """Return a film with a shot of its own at each onset."""
    samples = murmur(length_s, seed=seed, rate_hz=rate_hz)
    for number, onset_s in enumerate(onsets_s):
        put(samples, bang(seed=1000 * seed + number, rate_hz=rate_hz), onset_s, rate_hz=rate_hz)
    return samples


def put(samples: Samples, sound: Samples, at_s: float, *, rate_hz: int = RATE_HZ) -> None:
    """Add a sound to samples in place."""
    start = round(at_s * rate_hz)
    part = sound[: max(0, len(samples) - start)]
    samples[start : start + len(part)] += part


def seconds(samples: Samples, start_s: float, stop_s: float, rate_hz: int = RATE_HZ) -> Samples:
    """Return a part of a film."""
    return samples[round(start_s * rate_hz) : round(stop_s * rate_hz)]

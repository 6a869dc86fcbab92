"""A shot's sound in the band of vibration, and what is felt of the drive that belongs to it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..model import Event, Phase, Span
from ..ruleset import ActuatorProfile, AlignRules
from ..units import samples_from_ms
from .sounds import Place, Sound, drive_at, stretch_of

Samples = NDArray[np.float64]

_SETTLE_MS = 250.0
"""Filters run this long before what is compared: eight time constants of a 5 Hz high-pass."""

_FFT_GRAIN = 15 * 2**10
"""Transforms come in few sizes, so that the band's response is computed a few times in a film."""

_AT_LIMIT = 0.995
"""A drive sample of this share of the limit is taken as limited: interpolated and quantised ones miss it a little."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """What the checks of every shot share: films, rules, and the actuator's filters at the soundtrack's rate."""

    audio: Sound
    drive: Sound
    rules: AlignRules
    phase: Phase
    felt: Samples
    band: Samples
    band_gains: Callable[[int], Samples]

    @property
    def rate_hz(self) -> int:
        """Return the rate at which everything is compared, the soundtrack's."""
        return self.audio.rate_hz

    def samples(self, duration_ms: float) -> int:
        """Return a duration in samples."""
        return samples_from_ms(duration_ms, self.rate_hz)

    def shown_to_actuator(self, samples: Samples) -> Samples:
        """Return samples through H backwards in time: what of them a drive, sample for sample, can do about."""
        return dsp.run_filter(self.felt, samples[::-1])[::-1]


def compare(audio: Sound, drive: Sound, *, profile: ActuatorProfile, rules: AlignRules, phase: Phase) -> Comparison:
    """Return what the checks of every shot share."""
    rate_hz = audio.rate_hz
    band = dsp.band(profile)

    @lru_cache(maxsize=64)
    def band_gains(size: int) -> Samples:
        frequencies_hz = np.asarray(np.fft.rfftfreq(size, 1.0 / rate_hz), dtype=np.float64)
        if phase == "zero":
            return np.abs(dsp.half_band(profile).at(frequencies_hz)) ** 2
        return np.abs(band.at(frequencies_hz))

    felt = dsp.digital(dsp.felt_response(profile), rate_hz)
    return Comparison(audio, drive, rules, phase, felt, dsp.digital(band, rate_hz), band_gains)


@dataclass(frozen=True, eq=False)
class Heard:
    """The sound of a shot in the band of vibration, over `span`, of which `core` holds the shot itself.

    `intended` has the delay that the drive is meant to have, `undelayed` none; `direct` is what direct conversion
    would make felt.
    """

    span: Span
    core: slice
    intended: Samples
    undelayed: Samples
    direct: Samples


@dataclass(frozen=True, eq=False)
class Felt:
    """The drive of a shot over a span: its vibration as felt, and what of it is to follow the sound.

    They are the same but for a `direct` drive, which does not compensate: there the drive itself is to follow, in
    the band of vibration. `free` marks the samples at which the drive is not at the actuator's limit.
    """

    drive: Samples
    vibration: Samples
    following: Samples
    free: NDArray[np.bool_]
    peak: float


def is_direct(event: Event) -> bool:
    """Return whether a shot's drive is its sound as it is."""
    return event.drive is not None and event.drive.model == "direct"


def hear(shared: Comparison, event: Event, part: Span, *, margin: int) -> Heard:
    """Return the sound of a shot over its part and `margin` samples on either side."""
    settle = shared.samples(_SETTLE_MS)
    span = Span(part.start - margin, part.stop + margin)
    audio = stretch_of(shared.audio, Span(span.start - settle, span.stop + settle))
    kept = slice(settle, settle + len(span))
    undelayed = _without_delay(shared, audio)[kept]
    intended = undelayed
    if shared.phase == "causal" and not is_direct(event):
        intended = dsp.run_filter(shared.band, audio[: kept.stop])[kept]
    direct = dsp.run_filter(shared.felt, np.clip(audio[: kept.stop], -1.0, 1.0))[kept]
    return Heard(span, slice(margin, margin + len(part)), intended, undelayed, direct)


def feel(shared: Comparison, event: Event, span: Span, *, place: Place) -> Felt:
    """Return what is felt over a span of the film, with the drive read from where `place` says."""
    settle = shared.samples(_SETTLE_MS)
    wide = Span(span.start - settle, span.stop + settle)
    drive, written = drive_at(shared.drive, wide, rate_hz=shared.rate_hz, place=place)
    kept = slice(settle, settle + len(span))
    vibration = dsp.run_filter(shared.felt, drive[: kept.stop])[kept]
    following = _without_delay(shared, drive)[kept] if is_direct(event) else vibration
    free = np.abs(drive[kept]) < _AT_LIMIT * shared.rules.peak
    return Felt(drive[kept], vibration, following, free, float(np.abs(written).max(initial=0.0)))


def _without_delay(shared: Comparison, samples: Samples) -> Samples:
    """Return samples in the band of vibration, by the magnitude of its response alone, hence without delay."""
    from scipy import fft

    size = -(-len(samples) // _FFT_GRAIN) * _FFT_GRAIN
    return np.asarray(fft.irfft(fft.rfft(samples, size) * shared.band_gains(size), size)[: len(samples)], np.float64)

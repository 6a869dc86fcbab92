"""What the checks of every shot share: both films, the rules, and the actuator as it acts on them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..model import Background, Phase
from ..ruleset import ActuatorProfile, AlignRules
from ..units import samples_from_ms
from .sounds import Sound

Samples = NDArray[np.float64]

_FADED = 1e-3
"""H has forgotten what is left with this share of its answer's amplitude."""

_LONGEST_MEMORY_S = 1.7
"""No longer is waited for H to forget: seven time constants of 0.25 s."""

_BEND_MS: dict[Phase, float] = {"causal": 0.1, "zero": 0.125}
_BEND_AT_HZ = 1000.0
"""How far the actuator's limit alone can bend the plain correlation's peak aside, in a band up to there: 1.1 samples at
48 kHz was the most seen, without delay 5.7. A band that ends lower swings more slowly; one up to 80 Hz was bent by
0.5 ms."""

_SET_AT_HZ, _COARSE_MS = 48_000, 0.25
"""Drives with corners 0.25 ms apart were felt up to 15 us aside, a sample at 96 kHz; a third as far apart 0.3 us."""

_ABOVE = 2.0
"""From so many times the corner of the band on, a drive does nothing for what is felt."""

_FFT_GRAIN = 15 * 2**10
"""Transforms come in few sizes, so that the band's response is computed a few times in a film."""

_LOWEST_HZ = 1.0
"""Where the search for the greatest response begins."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Films, rules, and the actuator's filters at the soundtrack's rate.

    `level_db` is how much stronger than usual every shot was asked to be, `corner_ms` how far apart the tier has the
    corners of the straight lines that a solved drive is made of; on some seats they are elsewhere. `felt` and `band`
    are second-order sections, shape (sections, 6); `band_gains` gives the band's magnitudes for a real transform of so
    many samples. `above_band` keeps what lies above it, None where a film holds nothing there. `compensated` makes of a
    sound the drive that is felt like it where nothing limits it. `step` is 1 / max |H|^2: so long a step down the slope
    of |H u - t|^2 / 2 never overshoots. `settle` is how many samples the filters run before what is compared, `preroll`
    how many they ran before a window when its drive was made, `memory` how many H remembers. `bend_ms` is by how
    much the limit alone may displace what is felt.
    """

    audio: Sound
    drive: Sound
    rules: AlignRules
    lead_ms: float
    phase: Phase
    background: Background
    level_db: float
    corner_ms: float
    felt: Samples
    band: Samples
    band_gains: Callable[[int], Samples]
    above_band: Samples | None
    compensated: Callable[[Samples], Samples]
    step: float
    settle: int
    preroll: int
    memory: int
    bend_ms: float

    @property
    def rate_hz(self) -> int:
        """Return the rate at which everything is compared, the soundtrack's."""
        return self.audio.rate_hz

    @property
    def coarseness(self) -> float:
        """Return by how much limits in samples, set at 48 kHz, grow for drives of straight lines between corners.

        What such a drive is felt aside is a time, of more samples at a higher rate.
        """
        return max(1.0, self.rate_hz / _SET_AT_HZ * min(1.0, (self.corner_ms / _COARSE_MS) ** 2))

    @property
    def bend(self) -> float:
        """Return `bend_ms` in samples, not rounded."""
        return self.rate_hz * self.bend_ms / 1000.0

    def samples(self, duration_ms: float) -> int:
        """Return a duration in samples."""
        return samples_from_ms(duration_ms, self.rate_hz)

    def adjoint(self, samples: Samples) -> Samples:
        """Return H'x, shape (frames,), the adjoint of the felt response: H run backwards in time.

        The gradient of 1/2 |H u - t|^2 is H'(H u - t).
        """
        return dsp.run_backwards(self.felt, samples)

    def without_delay(self, samples: Samples) -> Samples:
        """Return samples in the band of vibration, by the magnitude of its response alone, hence without delay."""
        from scipy import fft

        size = -(-len(samples) // _FFT_GRAIN) * _FFT_GRAIN
        return np.asarray(
            fft.irfft(fft.rfft(samples, size) * self.band_gains(size), size)[: len(samples)], dtype=np.float64
        )


def compare(
    audio: Sound,
    drive: Sound,
    *,
    profile: ActuatorProfile,
    rules: AlignRules,
    lead_ms: float,
    preroll_ms: float,
    phase: Phase,
    background: Background,
    level_db: float,
    corner_ms: float,
) -> Comparison:
    """Return what the checks of every shot share."""
    rate_hz = audio.rate_hz
    response, compensator = dsp.felt_response(profile), dsp.compensator(profile)
    felt = dsp.discretise(response, rate_hz)
    frequencies_hz = dsp.telling_hz(response, _LOWEST_HZ, rate_hz / 2.0, 2048)
    return Comparison(
        audio,
        drive,
        rules,
        lead_ms=lead_ms,
        phase=phase,
        background=background,
        level_db=level_db,
        corner_ms=corner_ms,
        felt=felt,
        band=dsp.discretise(dsp.band(profile), rate_hz),
        band_gains=_band_gains(profile, rate_hz, phase),
        above_band=_above_band(profile, rate_hz),
        compensated=_compensation(profile, rate_hz, phase),
        step=1.0 / float(np.max(np.abs(response.at(frequencies_hz)) ** 2)),
        settle=round(dsp.settle_s(response, compensator) * rate_hz),
        preroll=samples_from_ms(dsp.preroll_ms(preroll_ms, dsp.compensator_slowest_s(profile, phase)), rate_hz),
        memory=_memory(felt, rate_hz),
        bend_ms=_BEND_MS[phase] * max(1.0, _BEND_AT_HZ / profile.lowpass.corner_hz),
    )


def _band_gains(profile: ActuatorProfile, rate_hz: int, phase: Phase) -> Callable[[int], Samples]:
    """Return what gives the magnitude of the band's response for a transform of so many samples."""
    band, half = dsp.band(profile), dsp.half_band(profile)

    @lru_cache(maxsize=64)
    def gains(size: int) -> Samples:
        frequencies_hz = np.asarray(np.fft.rfftfreq(size, 1.0 / rate_hz), dtype=np.float64)
        return np.abs(half.at(frequencies_hz)) ** 2 if phase == "zero" else np.abs(band.at(frequencies_hz))

    return gains


def _above_band(profile: ActuatorProfile, rate_hz: int) -> Samples | None:
    """Return the high-pass above the band as second-order sections; None where that leaves less than an octave."""
    from scipy.signal import butter

    corner_hz = _ABOVE * profile.lowpass.corner_hz
    if corner_hz > rate_hz / 4.0:
        return None
    return np.asarray(butter(4, corner_hz, "highpass", fs=rate_hz, output="sos"), dtype=np.float64)


def _compensation(profile: ActuatorProfile, rate_hz: int, phase: Phase) -> Callable[[Samples], Samples]:
    """Return what makes a drive of a sound, by the filters that render it; a direct drive does without their design."""

    @lru_cache(maxsize=1)
    def sections() -> tuple[Samples, Samples | None]:
        backwards = dsp.band_sections(profile, rate_hz, phase, lean=True) if phase == "zero" else None
        return dsp.compensator_sections(profile, rate_hz, phase, lean=True), backwards

    def compensated(samples: Samples) -> Samples:
        forwards, backwards = sections()
        return dsp.run_both_ways(forwards, samples, backwards=backwards)

    return compensated


def _memory(felt: Samples, rate_hz: int) -> int:
    """Return how many samples H remembers: poles that lie together fade later than one, so its own answer tells."""
    impulse = np.zeros(round(_LONGEST_MEMORY_S * rate_hz))
    impulse[0] = 1.0
    left = np.cumsum(dsp.run_filter(felt, impulse)[::-1] ** 2)[::-1]
    return int(np.count_nonzero(left > _FADED**2 * left[0]))

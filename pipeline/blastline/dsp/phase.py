"""The band of vibration and the compensator as sections, causal or without phase.

Causal, each runs forwards once. Without phase, each holds half of the band's roll-off and runs forwards, and half the
band runs backwards over what comes of that: B(s) B(-s) has no phase.
"""

import numpy as np
from numpy.typing import NDArray

from ..model import Phase
from ..ruleset import ActuatorProfile
from .analogue import Analogue, band, half_band, inverse, slowest_s
from .digital import discretise, run_filter

Samples = NDArray[np.float64]


def band_sections(profile: ActuatorProfile, rate_hz: int, phase: Phase, *, lean: bool = False) -> Samples:
    """Return the band of vibration as second-order sections, half of it with phase "zero"; as `discretise`."""
    return discretise(_shape(profile, phase), rate_hz, lean=lean)


def compensator_sections(profile: ActuatorProfile, rate_hz: int, phase: Phase, *, lean: bool = False) -> Samples:
    """Return the compensator in the band of vibration, or in half of it with phase "zero"; see `discretise`."""
    return discretise(inverse(profile) * _shape(profile, phase), rate_hz, lean=lean)


def compensator_slowest_s(profile: ActuatorProfile, phase: Phase) -> float:
    """Return the longest time constant of the compensator: half a band has other poles than the whole."""
    return slowest_s(inverse(profile) * _shape(profile, phase))


def run_backwards(sections: Samples, samples: Samples) -> Samples:
    """Return samples through sections backwards in time, shape (frames,), from rest after the last of them."""
    return run_filter(sections, samples[::-1])[::-1]


def run_both_ways(sections: Samples, samples: Samples, *, backwards: Samples | None) -> Samples:
    """Return samples through sections, shape (frames,), and then backwards through others, None in causal phase."""
    forwards = run_filter(sections, samples)
    return forwards if backwards is None else run_backwards(backwards, forwards)


def _shape(profile: ActuatorProfile, phase: Phase) -> Analogue:
    return band(profile) if phase == "causal" else half_band(profile)

"""Filters as zeros, poles and a gain, how they become digital, and fades between what they make."""

from .analogue import Analogue, band, butterworth, compensator, felt_response, half_band, inverse
from .digital import digital, run_filter
from .fades import cross_fade, fade
from .settled import Settling, settled_state, settling

__all__ = [
    "Analogue",
    "Settling",
    "band",
    "butterworth",
    "compensator",
    "cross_fade",
    "digital",
    "fade",
    "felt_response",
    "half_band",
    "inverse",
    "run_filter",
    "settled_state",
    "settling",
]

"""Filters as zeros, poles and a gain, and how they become digital; fades; what a film stands on."""

from .analogue import (
    Analogue,
    band,
    butterworth,
    compensator,
    felt_response,
    half_band,
    inverse,
    preroll_ms,
    settle_s,
    telling_hz,
)
from .digital import discretise, run_filter
from .fades import cross_fade, fade
from .offset import level_at, opening_frames, opening_level
from .phase import band_sections, compensator_sections, compensator_slowest_s, run_backwards, run_both_ways
from .settled import Settling, settled_state, settling

__all__ = [
    "Analogue",
    "Settling",
    "band",
    "band_sections",
    "butterworth",
    "compensator",
    "compensator_sections",
    "compensator_slowest_s",
    "cross_fade",
    "discretise",
    "fade",
    "felt_response",
    "half_band",
    "inverse",
    "level_at",
    "opening_frames",
    "opening_level",
    "preroll_ms",
    "run_backwards",
    "run_both_ways",
    "run_filter",
    "settle_s",
    "settled_state",
    "settling",
    "telling_hz",
]

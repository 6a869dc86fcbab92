"""The detection pipeline: find the gunshots of a film while it streams by.

    blocks -> tracks -> candidates -> onsets -> features -> verify -> segment -> bursts -> shots and rejections

A cheap scan over the whole film (`tracks`, `scan`) names candidates; everything after works on the candidates only.
"""

from .bursts import drop_claimed_reflections, group_bursts
from .direction import with_azimuths
from .find import LATENCY_S, Detection, find_shots
from .given import audio_around, shot_at, shot_in_clearer_mix
from .sides import side_as_main
from .verify import Verifier, load_verifier, read_model, verifier_of

__all__ = [
    "LATENCY_S",
    "Detection",
    "Verifier",
    "audio_around",
    "drop_claimed_reflections",
    "find_shots",
    "group_bursts",
    "load_verifier",
    "read_model",
    "shot_at",
    "shot_in_clearer_mix",
    "side_as_main",
    "verifier_of",
    "with_azimuths",
]

"""Find the gunshots of a film while it streams by.

    blocks -> tracks -> candidates -> onsets -> features -> verify -> segment -> bursts -> shots and rejections

A cheap scan over the whole film (`tracks`, `scan`) names candidates; everything after works on the candidates only.
"""

from .bursts import group_bursts, part_from_echoes
from .direction import placed
from .find import LATENCY_S, Detection, find_shots
from .given import audio_around, shot_at
from .sides import as_heard
from .verify import Verifier, load_verifier, read_model

__all__ = [
    "LATENCY_S",
    "Detection",
    "Verifier",
    "as_heard",
    "audio_around",
    "find_shots",
    "group_bursts",
    "load_verifier",
    "part_from_echoes",
    "placed",
    "read_model",
    "shot_at",
]

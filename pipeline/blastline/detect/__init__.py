"""Find the gunshots of a film while it streams by.

    blocks -> tracks -> candidates -> onsets -> features -> verify -> segment -> bursts -> shots and rejections

A cheap scan over the whole film (`tracks`, `scan`) names candidates; everything after works on the candidates only.
"""

from .find import Detection, find_shots
from .verify import Verifier, load_verifier

__all__ = ["Detection", "Verifier", "find_shots", "load_verifier"]

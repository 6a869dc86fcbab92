"""A shot that somebody else has found: its parts, and the rise nearest to where it was said to be."""

import numpy as np

from ..model import Clip, Shot, Span
from ..ruleset import QualityRules
from ..units import samples_from_ms
from .segment import BACKGROUND_MS, reach, segment


def audio_around(onset: int, *, frames: int, rate_hz: int, tier: QualityRules) -> Span:
    """Return the stretch of a film of so many frames that `shot_at` listens to."""
    before = samples_from_ms(BACKGROUND_MS, rate_hz)
    return Span(max(0, onset - before), min(frames, onset + reach(rate_hz=rate_hz, rules=tier.segment)))


def shot_at(onset: int, audio: Clip, *, confidence: float, tier: QualityRules) -> Shot:
    """Return the shot that begins at a sample of the film, as detection would have parted it.

    `audio` is what `audio_around` names. That there is a shot at all is taken on trust.
    """
    return segment(
        np.asarray(audio.heard, np.float32),
        onset - audio.start,
        film_start=audio.start,
        film_stop=audio.span.stop,
        confidence=confidence,
        rate_hz=audio.rate_hz,
        rules=tier.segment,
    )

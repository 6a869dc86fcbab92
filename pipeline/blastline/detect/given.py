"""Segment a shot whose onset is given, for example by an editor."""

import msgspec
import numpy as np

from ..model import Clip, Shot, Span
from ..ruleset import QualityRules
from ..units import samples_from_ms, samples_from_s
from .rate import LISTENING_HZ, film_sample, resampled, shot_in_film
from .segment import BACKGROUND_MS, reach, segment
from .sides import COVERED_DB, side_as_main


def audio_around(onset: int, *, frames: int, rate_hz: int, tier: QualityRules) -> Span:
    """Return the span of a film of `frames` samples that `shot_at` needs."""
    before = samples_from_ms(BACKGROUND_MS, rate_hz)
    return Span(max(0, onset - before), min(frames, onset + reach(rate_hz=rate_hz, rules=tier.segment)))


def shot_at(onset: int, audio: Clip, *, confidence: float, tier: QualityRules) -> Shot:
    """Return the shot that begins at sample `onset` of the film, segmented as detection would have done it.

    `audio` is what `audio_around` names. That there is a shot at all is not checked.
    """
    rate_hz, begins = audio.rate_hz, onset - audio.start
    heard = np.concatenate([np.asarray(clip.heard, np.float32) for clip in resampled([audio], rate_hz)])
    nearest = min(samples_from_s(begins / rate_hz, LISTENING_HZ), heard.shape[0] - 1)
    shot = segment(
        heard,
        nearest,
        film_start=0,
        film_stop=heard.shape[0],
        confidence=confidence,
        rate_hz=LISTENING_HZ,
        rules=tier.segment,
    )
    beside = onset - film_sample(nearest, rate_hz)
    return shot_in_film(shot, lambda sample: min(film_sample(sample, rate_hz) + beside, audio.span.stop))


def shot_in_clearer_mix(onset: int, audio: Clip, *, confidence: float, tier: QualityRules) -> Shot:
    """Return what `shot_at` does of the mix that the shot stands out of more: of the mains, or of the sides.

    What lies deep under the mains is no sound of the sides, as in detection.
    """
    mains = shot_at(onset, audio, confidence=confidence, tier=tier)
    if audio.sides is None:
        return mains
    sides = shot_at(onset, side_as_main(audio), confidence=confidence, tier=tier)
    if sides.peak_dbfs < mains.peak_dbfs - COVERED_DB or sides.snr_db <= mains.snr_db:
        return mains
    return msgspec.structs.replace(sides, heard_in="sides")

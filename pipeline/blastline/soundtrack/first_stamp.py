"""Whether the first time stamp of a track is wild: those that follow tell."""

from collections.abc import Sequence
from fractions import Fraction

from .placement import TOLERANCE_S
from .stamped import Stamped


def origin_by_others(frames: Sequence[Stamped], rate_hz: int) -> Fraction | None:
    """Return the time of sample 0 by the stamps of most of these frames, the first ones of a track.

    None where the first frame agrees with them, where they do not agree with one another, or where any has no stamp.
    """
    origins, counted = [], 0
    for frame in frames:
        if frame.pts is None or not frame.time_base:
            return None
        origins.append(frame.pts * frame.time_base - Fraction(counted, rate_hz))
        counted += frame.samples
    if len(origins) < 3 or not (time_base := frames[0].time_base):
        return None
    tolerance = max(Fraction(TOLERANCE_S), 2 * time_base)
    # one stamp may be that of several frames, so more than the first one may be wrong
    wrong = next((k for k, origin in enumerate(origins) if abs(origin - origins[-1]) <= tolerance), 0)
    others = origins[wrong:]
    agreed = max(others) - min(others) <= tolerance and len(others) > max(wrong, 1)
    return others[0] if wrong and agreed else None

"""What a copy without resampling is: the old film's own speed, to the last bit, and whole samples later or earlier.

measured   new = 1.0000006 old - 0.000005     what was resampled to be compared is heard some microseconds beside
copied     new = old + 0                      its place; along the line of a copy it is not
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .anchors import ANCHOR_S, SHARP_S, find_anchors
from .film import Film
from .lines import Line
from .segments import MatchedSegment
from .waveform import EXACT_S

_MOST_DRIFT_S = 1e-4
"""By so much a measured line may drift, from end to end, and yet be that of a copy."""

_ROUNDS = 3  # a first line may be a sample beside that of the copy


def copied_line(segment: MatchedSegment, times: Sequence[float], old: Film, new: Film, *, agreeing: int) -> Line | None:
    """Return the line of a copy that a segment's measured line stands for; None where the new film is no such copy.

    So many of the anchors at `times` as are `agreeing` on the measured line have to lie on it.
    """
    line = segment.line
    if abs(line.scale - 1.0) * (segment.stop_s - segment.start_s) > _MOST_DRIFT_S:
        return None
    middle_s = 0.5 * (segment.start_s + segment.stop_s)
    offset_s = line.at(middle_s) - middle_s
    for _ in range(_ROUNDS):
        copied = replace(line, scale=1.0, offset_s=_in_samples(offset_s, old, new))
        along = replace(segment, line=copied)
        late_s = find_anchors(along, times, old, new, pitch_scale=1.0, within_s=ANCHOR_S).late_s
        near_s = late_s[np.abs(late_s) <= SHARP_S]
        if len(near_s) >= agreeing and float(np.median(np.abs(near_s))) <= EXACT_S:
            return copied
        if not late_s.size:
            return None
        offset_s = copied.offset_s + float(np.median(late_s))
    return None


def _in_samples(offset_s: float, old: Film, new: Film) -> float:
    """Return an offset in whole samples; as it is between films of two rates."""
    return round(offset_s * new.rate_hz) / new.rate_hz if old.rate_hz == new.rate_hz else offset_s

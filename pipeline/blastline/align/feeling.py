"""What is felt of the drive that belongs to a shot."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..model import Event, Span
from .comparison import Comparison, Samples
from .hearing import Part, is_direct, resting_until
from .sounds import TimeMap, drive_at

_AT_LIMIT = 0.995
"""A drive sample of this share of the limit is taken as limited: interpolated and quantised ones miss it a little."""


@dataclass(frozen=True, eq=False)
class Felt:
    """The drive of a shot over a span, in arrays of its length: its vibration as felt, and what is to follow the sound.

    What is to follow is the vibration without what the windows before leave ringing; of a `direct` drive, which does
    not compensate, it is the drive itself in the band of vibration. `own` is what is felt of the shot's window alone,
    from rest: a seat that rings for long still moves with what was before. `free` marks the samples at which the drive
    is not at the actuator's limit.
    """

    drive: Samples
    vibration: Samples
    own: Samples
    following: Samples
    free: NDArray[np.bool_]
    peak: float


def feel(shared: Comparison, event: Event, part: Part, span: Span, *, time_map: TimeMap) -> Felt:
    """Return what is felt over a span of the film, with the drive read from where `time_map` says."""
    settle = shared.settle
    wide = Span(span.start - settle, span.stop + settle)
    drive, written = drive_at(shared.drive, wide, rate_hz=shared.rate_hz, time_map=time_map)
    kept = slice(settle, settle + len(span))

    def felt_from(at: int) -> Samples:
        return dsp.run_filter(shared.felt, resting_until(at, drive, wide)[: kept.stop])[kept]

    vibration, own = felt_from(wide.start), felt_from(event.window.start)
    following = shared.without_delay(drive)[kept] if is_direct(event) else felt_from(part.earlier_stop)
    free = np.abs(drive[kept]) < _AT_LIMIT * shared.rules.peak
    return Felt(drive[kept], vibration, own, following, free, float(np.abs(written).max(initial=0.0)))


def peak_in(shared: Comparison, span: Span, *, time_map: TimeMap) -> float:
    """Return the largest magnitude of the drive's own samples over a span of the film."""
    _, written = drive_at(shared.drive, span, rate_hz=shared.rate_hz, time_map=time_map)
    return float(np.abs(written).max(initial=0.0))

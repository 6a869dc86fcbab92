"""The drive as haptic formats read it: shown to be a drive, and made into a haptic track."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import TimelineError
from ..export import HapticTrack, Rounding, haptic_track
from ..model import Span, Timeline
from ..progress import Note
from ..ruleset import ActuatorProfile, HapticRules
from ..soundtrack import Soundtrack
from ..timecode import timecode_at
from .belonging import require_length
from .listening import BLOCK


def track_of(timeline: Timeline, drive: Soundtrack, *, profile: ActuatorProfile, rules: HapticRules) -> HapticTrack:
    """Return the haptic track of a drive that has been decoded."""

    def read(span: Span) -> NDArray[np.float64]:
        return np.asarray(drive.read(span).driving, dtype=np.float64)

    return haptic_track(timeline, read, profile=profile, rules=rules)


def decode_drive(timeline: Timeline, drive: Soundtrack, file: Path, note: Note) -> None:
    """Decode a drive that has just been opened, so that it can be read.

    `note` is told where it goes beyond the actuator's limit, which is all that the formats hold. Raises TimelineError
    where it is not as long as its timeline, or some of its samples are no numbers.
    """
    frames, peak, beyond = 0, 1.0, []
    for block in drive.blocks(BLOCK):
        frames += len(block.span)
        over = np.abs(block.driving) > 1.0
        if over.any():
            beyond.append(block.start + int(np.argmax(over)))
            peak = max(peak, float(np.abs(block.driving).max()))
    require_length(timeline, file, rate_hz=drive.rate_hz, frames=frames, what="the drive of this timeline")
    if drive.damaged_samples:
        raise TimelineError(f"{file}: {drive.damaged_samples} of its samples are no numbers; expected a drive")
    if beyond:
        note(
            f"{file}: reaches {peak:.3g} times the actuator's limit, first at "
            f"{timecode_at(timeline.source, beyond[0])}; what is over the limit is written as the limit"
        )


def tell_silent(track: HapticTrack, note: Note) -> None:
    """Tell which shots the drive does not move the seat for, if any."""
    if track.silent:
        some = ", ".join(track.silent[:3]) + (", ..." if len(track.silent) > 3 else "")
        note(f"the drive is at rest at {len(track.silent)} of the shots, which get no pulse: {some}")


def rounding_notes(note: Note) -> Callable[[str, Rounding], None]:
    """Return what tells a note the rounding of each format."""
    return lambda name, rounding: note(f"{name}: {rounding}")

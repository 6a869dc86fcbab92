"""The drive as haptic formats read it: found, shown to belong to its timeline, and made into a haptic track."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..export import HapticTrack, Rounding, haptic_track
from ..model import Span, Timeline
from ..progress import Note
from ..ruleset import ActuatorProfile, HapticRules
from ..soundtrack import Soundtrack


def track_of(timeline: Timeline, drive: Soundtrack, *, profile: ActuatorProfile, rules: HapticRules) -> HapticTrack:
    """Return the haptic track of a drive that has been decoded."""

    def read(span: Span) -> NDArray[np.float64]:
        return np.asarray(drive.read(span).driving, dtype=np.float64)

    return haptic_track(timeline, read, profile=profile, rules=rules)


def tell_silent(track: HapticTrack, note: Note) -> None:
    """Tell which shots the drive does not move the seat for, if any."""
    if track.silent:
        some = ", ".join(track.silent[:3]) + (", ..." if len(track.silent) > 3 else "")
        note(f"the drive is at rest at {len(track.silent)} of the shots, which get no pulse: {some}")


def rounding_notes(note: Note) -> Callable[[str, Rounding], None]:
    """Return what tells a note the rounding of each format."""
    return lambda name, rounding: note(f"{name}: {rounding}")

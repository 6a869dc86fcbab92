"""Which shots can be checked: those whose drive is comparable with their sound."""

from ..model import Event, Span
from .comparison import Comparison
from .hearing import Part, is_direct
from .sanity import audio_rise_db
from .sounds import TimeMap, drive_at, read_padded

_LEAST_MS = {"causal": 5.0, "zero": 20.0}
"""So much of a shot is compared at least: less, before the next shot or the window's end, leaves its lag open."""

_PIECE_MS = 1000.0

_SOFTER_DB = 30.0
"""A shot asked to be so much softer than what plays before it lies beneath what is left of that."""


def is_comparable(shared: Comparison, event: Event, part: Part) -> bool:
    """Return whether a shot's drive can be compared with its sound.

    A shot cannot be that is all but over before the next begins, or that was muted beside a louder one or beside the
    film's own sound; nor one that only other channels play; nor one set by hand where nothing begins: in a tone or in
    silence one place sounds like the next, and so nothing tells whether the drive is in its own; nor one whose drive
    was never to follow its sound, on a seat that cannot.
    """
    if len(part.span) < shared.samples(_LEAST_MS[shared.phase]) or _softer_db(shared, event, part) > _SOFTER_DB:
        return False
    rules = shared.rules
    if event.drive is not None and not is_direct(event) and event.drive.fidelity < rules.least_correlation:
        return False
    if event.origin != "found" and audio_rise_db(event, shared.audio) < rules.hand_rise_db:
        return False
    return not _is_still(shared, event)


def _softer_db(shared: Comparison, event: Event, part: Part) -> float:
    """Return by how much a shot was asked to be softer than what plays before it: the background, or another shot."""
    if part.opens and shared.background == "direct":
        return -(event.gain_db + shared.level_db)
    return part.before_db


def _is_still(shared: Comparison, event: Event) -> bool:
    """Return whether both sound and drive are silent in a shot's window.

    Read piece by piece up to the first that is not: a thousand shots of a battle may share a window of minutes.
    """
    whole, piece = event.window.span, shared.samples(_PIECE_MS)
    spans = [Span(start, min(start + piece, whole.stop)) for start in range(whole.start, whole.stop, piece)]
    return not (
        any(read_padded(shared.audio, span, event.made_of).any() for span in spans)
        or any(drive_at(shared.drive, span, rate_hz=shared.rate_hz, time_map=TimeMap())[0].any() for span in spans)
    )

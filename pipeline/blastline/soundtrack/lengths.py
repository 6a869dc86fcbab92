"""Whether a track is as long as its file declares: what is missing, and what is too much."""

from collections.abc import Iterator

from .track import TrackFacts

_MIN_OFF_S, _MIN_OFF_COUNTED_S = 0.1, 0.005
"""What a lossy codec may round its length by, and more: less than this is not called missing. Nothing is rounded where
samples are counted."""

_MAX_ROUNDED_S = 0.5

_MAX_MORE_S, _MAX_MORE_COUNTED_S, _MAX_MORE_SHARED_S = 0.1, 0.05, 1.0
"""So much more than declared a lossy codec may have, to fill its last frame and to begin with; one that counts, where
an MXF rounds to whole pictures; and a film that gives the time of all its streams, which some write in whole seconds.
"""

_MOST_FILLING_FRAMES = 4_096
"""Two frames of the codecs with the longest: at low rates more than the time above."""


def length_warnings(facts: TrackFacts, frames: int) -> Iterator[str]:
    """Yield a line where a track of so many frames is shorter or longer than declared."""
    declared = facts.declared_frames or 0
    if declared - facts.unsure_frames - frames > _tolerated(facts, declared):
        yield _missing(facts, declared, frames)
    elif facts.lacking_bytes:
        yield lacking_warning(facts.lacking_bytes)
    elif declared and frames - declared > _tolerated_more(facts):
        lasts, found = declared / facts.rate_hz, frames / facts.rate_hz
        yield (
            f"the file declares {lasts:.3f} s of sound but {found:.3f} s were read: some may be there twice or be no "
            "sound at all, and what follows plays late"
        )


def lacking_warning(lacking_bytes: int) -> str:
    """Return the line for the user where a file is so many bytes shorter than its header says."""
    lost = "1 byte is" if lacking_bytes == 1 else f"{lacking_bytes} bytes are"
    return (
        f"by its header {lost} missing in the file: if they are missing in the sound, what follows the loss may be "
        "noise or play early"
    )


def _tolerated(facts: TrackFacts, declared: int) -> float:
    """Return how many frames may be missing from what is declared."""
    if facts.breaks_off:
        return _MIN_OFF_COUNTED_S * facts.rate_hz
    if facts.length == "packets":
        return _MIN_OFF_S * facts.rate_hz
    if facts.length in ("rounded", "shared"):
        return min(max(0.01 * declared, _MIN_OFF_S * facts.rate_hz), _MAX_ROUNDED_S * facts.rate_hz)
    return _MIN_OFF_COUNTED_S * facts.rate_hz


def _tolerated_more(facts: TrackFacts) -> float:
    """Return how many frames may be read beyond what is declared."""
    if facts.length == "shared":
        return _MAX_MORE_SHARED_S * facts.rate_hz
    if facts.length in ("stored", "counted"):
        return _MAX_MORE_COUNTED_S * facts.rate_hz
    return max(_MAX_MORE_S * facts.rate_hz, _MOST_FILLING_FRAMES)


def _missing(facts: TrackFacts, declared: int, frames: int) -> str:
    """Return the line for the user where a track is shorter than declared."""
    lasts, found = declared / facts.rate_hz, frames / facts.rate_hz
    if facts.length == "shared":
        return f"the file lasts for {lasts:.3f} s but its sound for {found:.3f} s: some of it may be missing"
    before = ", or a part before it, and what follows plays early"
    if facts.length == "stored" and facts.stored is not None:
        lacking = facts.lacking_bytes or (declared - frames) * facts.stored.frame_bytes
        before = f", {lacking} bytes, or as many before it, and what follows the loss may be noise or play early"
    return f"the file declares {lasts:.3f} s of sound but only {found:.3f} s could be read: the end is missing{before}"

"""What both readers, of sample files and of films, tell about a sound track."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from ..streams import Streams

Samples = NDArray[np.float32]

Length = Literal["stored", "counted", "packets", "rounded", "shared"]
"""How a file declares its length: by the samples it stores in a row, of which only the end can be missing; by a count
of samples, or of packets, that may be damaged anywhere; by a time, which a lossy codec may round; or by the time of the
whole file, whose sound may be meant to end before its picture."""

PIECE = 65_536
"""Frames that are read or decoded at once: large enough that Python costs nothing, small enough for the cache."""

_LATEST_S = 7 * 86_400
"""A time stamp later than a week after midnight is none."""


@dataclass(frozen=True)
class Stored:
    """How samples lie in a file as they are, frame behind frame: where in it the first begins, and how long each is."""

    first_byte: int
    frame_bytes: int

    def place(self, frame: int) -> int:
        """Return at which byte of the file a frame begins."""
        return self.first_byte + frame * self.frame_bytes


@dataclass(frozen=True)
class TrackFacts:
    """What is known of a track before it is decoded.

    `layout` is None where the file does not name its channels, empty where they may be in any order; `declared_frames`
    is None where it does not say how long the track is, and then `guessed_s` is what its size suggests, if anything;
    `length` tells how it says so, `unsure_frames` how many of these may be time in which no sound was ever meant to
    play, and `breaks_off` that the file is known to stop before its end, so that what is missing is no rounding.
    `is_integer` tells that no sample can be NaN, `is_pcm` that samples are stored as they are; `stored` is where, None
    where that is not known, and `lacking_bytes` how many of their bytes were lost by what the header says. `beside`
    names the file's other sound streams.
    `ignored_reference` is a time stamp that can be none; `is_picture_missing` tells that a track of pictures
    is empty, or begins later than any was sought. The rest is as in `model.Source`.
    """

    rate_hz: int
    channels: int
    layout: tuple[str, ...] | None
    declared_frames: int | None
    length: Length = "rounded"
    unsure_frames: int = 0
    breaks_off: bool = False
    stream: Streams = 0
    is_integer: bool = False
    is_pcm: bool = False
    stored: Stored | None = None
    lacking_bytes: int = 0
    start_timecode: str | None = None
    has_picture: bool = False
    frame_rate: str | None = None
    start_offset_s: float = 0.0
    ignored_reference: int | None = None
    is_picture_missing: bool = False
    guessed_s: float | None = None
    beside: tuple[str, ...] = ()


@dataclass(frozen=True)
class TimeStamp:
    """A file's time stamp in samples after midnight: one to believe, or one to ignore; both None where it has none."""

    believed: int | None
    ignored: int | None


def time_stamp(reference: int | None, rate_hz: int) -> TimeStamp:
    """Return a time stamp, believed unless it is later than any film begins."""
    if reference is not None and reference > _LATEST_S * rate_hz:
        return TimeStamp(None, reference)
    return TimeStamp(reference, None)


def stamp_warnings(facts: TrackFacts) -> list[str]:
    """Return the line for the user where a time stamp was ignored."""
    if facts.ignored_reference is None:
        return []
    days = facts.ignored_reference / facts.rate_hz / 86_400.0
    said = f"the time stamp says {facts.ignored_reference} samples, {days:.3g} days, after midnight"
    return [f"{said}; it was ignored"]


class Track(Protocol):
    """One track of a file, decoded once from its first sample to its last."""

    facts: TrackFacts

    def pieces(self) -> Iterator[Samples]:
        """Yield all samples in order, shape (frames, channels)."""

    def read_approximately(self, start_s: float, frames: int) -> Iterator[Samples]:
        """Yield at least so many samples, if there are, from about that time on: a rough look before decoding."""

    def warnings(self) -> list[str]:
        """Return what had to be mended, one line each, once all pieces have been taken."""

    def close(self) -> None:
        """Release the file."""


def in_blocks(pieces: Iterable[Samples], frames: int) -> Iterator[Samples]:
    """Yield the same samples in blocks of `frames`, without a copy where a piece is one block or many."""
    held: list[Samples] = []
    count = 0
    for piece in pieces:
        held.append(piece)
        count += piece.shape[0]
        if count < frames:
            continue
        joined = held[0] if len(held) == 1 else np.concatenate(held)
        whole = count - count % frames
        for start in range(0, whole, frames):
            yield joined[start : start + frames]
        count -= whole
        held = [joined[whole:]] if count else []
    if count:
        yield np.concatenate(held)

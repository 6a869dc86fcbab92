"""Spans of time, pieces of sound, and the files that they are read from."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final, Literal, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

HeardIn = Literal["mains", "sides"]
"""The mix in which a shot is heard: all main channels together, or what they hold beside their middle."""

MadeOf = Literal["mains", "sides", "left", "right"]
"""What becomes a drive: what the user has named, usually the mains; or their sides, or one of two channels."""

SPAN_KEYS: Final = {"start": "start_sample", "stop": "stop_sample"}
"""What the ends of a range are called in `timeline.json`."""


class Span(msgspec.Struct, frozen=True, order=True, rename=SPAN_KEYS):
    """A half-open range of samples, ordered by its start.

    >>> Span(0, 10) & Span(4, 20)
    Span(start=4, stop=10)
    >>> Span(0, 10) | Span(14, 20)
    Span(start=0, stop=20)
    """

    start: int
    stop: int

    def __post_init__(self) -> None:
        """Refuse a range that runs backwards."""
        if self.stop < self.start:
            raise ValueError(f"a span must not run backwards: {self.start} to {self.stop}")

    def __len__(self) -> int:
        """Return the number of samples inside."""
        return self.stop - self.start

    def __bool__(self) -> bool:
        """Return whether any sample lies inside."""
        return self.stop > self.start

    def __contains__(self, sample: int) -> bool:
        """Return whether a sample lies inside."""
        return self.start <= sample < self.stop

    def __and__(self, other: "Span") -> "Span":
        """Return what both cover; an empty span at the later start where they do not meet."""
        start = max(self.start, other.start)
        return Span(start, max(start, min(self.stop, other.stop)))

    def __or__(self, other: "Span") -> "Span":
        """Return the smallest span that covers both, with any gap between them."""
        return Span(min(self.start, other.start), max(self.stop, other.stop))


@dataclass(frozen=True, eq=False)
class Clip:
    """A piece of sound that knows its place in the film.

    `samples` is (frames, columns), floating point; `start` is the film's sample index of its first frame. A mixed
    soundtrack has one column, or two where the drive is made from other channels than detection listens to. `sides`,
    shape (frames,), is the side signal: half the left-right difference of a pair (mid/side), or the mains without the
    centre channel; None where nobody asked or there is no such thing.
    """

    samples: NDArray[np.floating]
    rate_hz: int
    start: int = 0
    sides: NDArray[np.floating] | None = None

    @property
    def span(self) -> Span:
        """Return the range of the film that the clip covers."""
        return Span(self.start, self.start + self.samples.shape[0])

    @property
    def heard(self) -> NDArray[np.floating]:
        """Return the column in which detection listens, shape (frames,)."""
        return self.samples[:, 0]

    @property
    def driving(self) -> NDArray[np.floating]:
        """Return the column that becomes the drive, shape (frames,); the heard one where there is only one."""
        return self.samples[:, -1]

    def heard_in(self, mix: HeardIn) -> NDArray[np.floating] | None:
        """Return a mix in which shots are heard, shape (frames,); None for sides that were not read."""
        return self.sides if mix == "sides" else self.heard

    def driving_of(self, made_of: MadeOf) -> NDArray[np.floating]:
        """Return what becomes a drive that is made of that, shape (frames,); all but the mains need `sides`.

        Two channels are the mains, which are half their sum, and the sides, half their difference, added or not.
        """
        if made_of == "mains":
            return self.driving
        if self.sides is None:
            raise ValueError(f"a drive made of the {made_of} needs a clip with sides")
        if made_of == "sides":
            return self.sides
        sign = 1.0 if made_of == "left" else -1.0
        return np.asarray(self.heard + sign * self.sides)

    def slice(self, span: Span) -> "Clip":
        """Return the part inside `span`, which must lie within the clip."""
        if span.start < self.start or span.stop > self.span.stop:
            raise ValueError(f"{span} does not lie within {self.span}")
        inside = slice(span.start - self.start, span.stop - self.start)
        sides = None if self.sides is None else self.sides[inside]
        return Clip(self.samples[inside], self.rate_hz, span.start, sides)


@dataclass(frozen=True)
class Channels:
    """The channels of a film as they were before they were mixed.

    `azimuths_deg` says of each where its loudspeaker stands, 0 in front and positive to the right; None has no place.
    `centre` is the channel in the middle of the others, None where there is none.
    `read` returns a span, shape (frames, channels), or None where it can no longer be had.
    """

    azimuths_deg: tuple[float | None, ...]
    centre: int | None
    read: Callable[[Span], NDArray[np.floating] | None]


class RandomAccessSound(Protocol):
    """A sound file of which any span can be read again exactly, once it has been decoded."""

    @property
    def rate_hz(self) -> int:
        """Return the sample rate."""

    def read(self, span: Span, /, *, sides: bool = False) -> Clip:
        """Return what is inside `span`, which lies inside the file, with its sides if asked for and there."""


class SoundFile(RandomAccessSound, Protocol):
    """A sound file that is not yet decoded: read once from end to end, then span by span."""

    @property
    def damaged_samples(self) -> int:
        """Return how many of the samples that were read are no number, or beyond any sound, and were set to 0."""

    def blocks(self) -> Iterable[Clip]:
        """Return the whole file as clips that follow each other without gaps."""

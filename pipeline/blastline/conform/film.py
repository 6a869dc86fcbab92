"""A film that was listened to once and can be read again from then on."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from ..model import Clip, RandomAccessSound, Span
from .fingerprint import Fingerprint, fingerprint


@dataclass(frozen=True, eq=False)
class Film:
    """A film's sound: its file, its length in frames, and its fingerprint."""

    file: RandomAccessSound
    frames: int
    fingerprint: Fingerprint

    @property
    def rate_hz(self) -> int:
        """Return the sample rate."""
        return self.file.rate_hz

    @property
    def duration_s(self) -> float:
        """Return the length in seconds."""
        return self.frames / self.file.rate_hz

    def read(self, span: Span, *, sides: bool = False) -> Clip:
        """Return the exact samples of a span inside the film, with its sides if asked for and there."""
        return self.file.read(span, sides=sides)


def hear(file: RandomAccessSound, blocks: Iterable[Clip]) -> Film:
    """Return a film from its file and its one decoding pass, clips that follow each other from the first frame."""
    frames = 0

    def counted() -> Iterator[Clip]:
        nonlocal frames
        for block in blocks:
            frames = block.span.stop
            yield block

    printed = fingerprint(counted(), file.rate_hz)
    return Film(file, frames, printed)

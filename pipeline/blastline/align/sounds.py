"""What the checks read: spans of soundtrack and drive, at any place and rate."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Clip, MadeOf, RandomAccessSound, Span


@dataclass(frozen=True)
class Sound:
    """A file that has been read to its end, with the number of frames that it proved to have."""

    file: RandomAccessSound
    frames: int

    @property
    def rate_hz(self) -> int:
        """Return the sample rate."""
        return self.file.rate_hz

    def pieces(self, frames: int = 1 << 20) -> Iterator[Clip]:
        """Yield the whole file, a piece at a time."""
        for start in range(0, self.frames, frames):
            yield self.file.read(Span(start, min(start + frames, self.frames)))


@dataclass(frozen=True)
class TimeMap:
    """Where the drive's file holds what belongs to a sample of the film: file_sample = scale * film_sample + offset.

    In samples at the soundtrack's rate; a right file has scale 1 and offset 0.
    """

    scale: float = 1.0
    offset: float = 0.0

    @property
    def is_whole(self) -> bool:
        """Return whether every sample of the film has a sample of its own in a file of the same rate."""
        return self.scale == 1.0 and self.offset == round(self.offset)

    def lag(self, sample: float) -> float:
        """Return how many samples late the drive is at a sample of the film."""
        return (self.scale - 1.0) * sample + self.offset


def read_padded(sound: Sound, span: Span, made_of: MadeOf = "mains") -> NDArray[np.float64]:
    """Return what of a file becomes, or is, a drive that is made of that, over `span`; zeros beyond its ends."""
    samples = np.zeros(len(span))
    inside = span & Span(0, sound.frames)
    if inside:
        samples[inside.start - span.start : inside.stop - span.start] = sound.file.read(
            inside, sides=made_of != "mains"
        ).driving_of(made_of)
    return samples


def drive_at(
    drive: Sound, span: Span, *, rate_hz: int, time_map: TimeMap
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the drive that belongs to `span` of the film, and the samples of its file that this was read from.

    The first is at the film's rate and has the span's length. Whole samples are read as they are; other places and
    rates are interpolated by a cubic spline, which is exact enough in the band of vibration but may overshoot.
    """
    ratio = drive.rate_hz / rate_hz
    if ratio == 1.0 and time_map.is_whole:
        offset = round(time_map.offset)
        samples = read_padded(drive, Span(span.start + offset, span.stop + offset))
        return samples, samples
    from scipy.interpolate import CubicSpline

    positions = (np.arange(span.start, span.stop) * time_map.scale + time_map.offset) * ratio
    around = Span(int(np.floor(positions[0])) - 2, int(np.ceil(positions[-1])) + 3)
    written = read_padded(drive, around)
    spline = CubicSpline(np.arange(len(around)), written)
    return np.asarray(spline(positions - around.start), dtype=np.float64), written

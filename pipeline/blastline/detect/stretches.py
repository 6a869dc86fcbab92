"""Stretches of a film with their tracks, long enough to tell of each shot what comes before and after it."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from ..model import Span
from ..units import levels_db, samples_from_ms
from .segment import PEAK_MS
from .tracks import Grid, Piece

# A piece is about a second. Before the core: the neighbourhood of `features`; after it: that and the longest decay that
# rules may ask for. What is silence around the farthest neighbours is told by what is here of the 2 s around them.
LEFT_PIECES, CORE_PIECES, RIGHT_PIECES = 4, 32, 3


@dataclass(frozen=True, eq=False)
class Stretch:
    """A few seconds of film with its tracks; the shots whose onset lies in `core` are this stretch's to find."""

    samples: NDArray[np.float32]
    peak: NDArray[np.float32]
    slope: NDArray[np.float32]
    bands: NDArray[np.float32]
    start: int
    stop: int
    core: Span


def stretches(film: Iterable[Piece]) -> Iterator[Stretch]:
    """Yield overlapping stretches whose cores tile the film; the arrays of each hold until the next is asked for.

    |left|    core    |right|
                 |left|    core    |right|
    """
    for (stretch,) in side_by_side(film):
        yield stretch


def side_by_side(*films: Iterable[Piece]) -> Iterator[tuple[Stretch, ...]]:
    """Yield the stretches of films that are cut alike, those of each place together; they are read in turns."""
    rest = zip(*films, strict=True)
    first = next(rest, None)
    if first is None:
        return
    rooms, left = [_Room(piece, LEFT_PIECES + CORE_PIECES + RIGHT_PIECES) for piece in first], 0
    for together in chain([first], rest):
        for room, piece in zip(rooms, together, strict=True):
            room.append(piece)
        if rooms[0].held == left + CORE_PIECES + RIGHT_PIECES:
            yield tuple(room.stretch(left, CORE_PIECES) for room in rooms)
            for room in rooms:
                room.keep(LEFT_PIECES + RIGHT_PIECES)
            left = LEFT_PIECES
    if rooms[0].held > left:
        yield tuple(room.stretch(left, room.held - left) for room in rooms)


def track_peaks_dbfs(stretch: Stretch, places: NDArray[np.intp], grid: Grid) -> NDArray[np.float64]:
    """Return roughly how loud the first 20 ms from each place of a stretch on get, by the scan's track."""
    steps = places[:, None] // grid.step + np.arange(samples_from_ms(PEAK_MS, grid.rate_hz) // grid.step)
    return levels_db(stretch.peak[np.minimum(steps, stretch.peak.shape[0] - 1)].max(axis=1, initial=0.0))


class _Room:
    """Room for some pieces in a row, used again and again: new memory from the system costs half as much as a read."""

    def __init__(self, like: Piece, pieces: int) -> None:
        """Make room for so many pieces like the given one."""
        self._size = like.samples.shape[0]
        self._tracks = [np.empty((pieces, *track.shape), np.float32) for track in _tracks(like)]
        self._start, self._stop, self.held = 0, 0, 0

    def append(self, piece: Piece) -> None:
        """Add the piece that follows."""
        for room, track in zip(self._tracks, _tracks(piece), strict=True):
            room[self.held] = track
        self.held += 1
        self._stop += piece.frames

    def keep(self, pieces: int) -> None:
        """Let go of all but the last pieces."""
        gone = self.held - pieces
        for room in self._tracks:
            room[:pieces] = room[gone : self.held]
        self._start += gone * self._size
        self.held = pieces

    def stretch(self, left: int, core: int) -> Stretch:
        """Return what is held, of which so many pieces after the first `left` ones are the core."""
        samples, peak, slope, bands = (room[: self.held].reshape(-1, *room.shape[2:]) for room in self._tracks)
        first = self._start + left * self._size
        return Stretch(
            samples, peak, slope, bands, self._start, self._stop, core=Span(first, first + core * self._size)
        )


def _tracks(piece: Piece) -> tuple[NDArray[np.float32], ...]:
    return piece.samples, piece.peak, piece.slope, piece.bands

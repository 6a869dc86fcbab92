"""Overlapping chunks of a film with their tracks, long enough to tell what comes before and after each shot."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from ..model import Span
from ..units import levels_db, samples_from_ms
from .segment import PEAK_MS
from .tracks import Grid, Piece

# A piece is about a second. Before the core: what `neighbours` looks at; after it: that and the longest decay that
# rules may ask for. What is silence around the farthest neighbours is told by what is here of the 2 s around them.
LEFT_PIECES, CORE_PIECES, RIGHT_PIECES = 4, 64, 3
SHORT_CORE_PIECES = 32  # where as much of all channels has to be remembered


@dataclass(frozen=True, eq=False)
class Chunk:
    """A chunk of film with its tracks; `core` is what it owns: the shots that begin there. The rest is context.

    `samples` has shape (frames,), `peak` and `slope` (steps,), `bands` (hops, BANDS), as in `Piece`. `start`, `stop`
    and `core` are in samples of the film as it is listened to; beyond `stop` the film is over and stays level.
    """

    samples: NDArray[np.float32]
    peak: NDArray[np.float32]
    slope: NDArray[np.float32]
    bands: NDArray[np.float32]
    start: int
    stop: int
    core: Span


def chunks(film: Iterable[Piece], core_pieces: int = CORE_PIECES) -> Iterator[Chunk]:
    """Yield overlapping chunks whose cores tile the film; the arrays of each hold until the next is asked for.

    |left|    core    |right|
                 |left|    core    |right|
    """
    for (chunk,) in aligned_chunks(film, core_pieces=core_pieces):
        yield chunk


def aligned_chunks(*films: Iterable[Piece], core_pieces: int) -> Iterator[tuple[Chunk, ...]]:
    """Yield the chunks of films that are cut alike, those of each place together; the films are read in turns."""
    rest = zip(*films, strict=True)
    first = next(rest, None)
    if first is None:
        return
    buffers, left = [_ChunkBuffer(piece, LEFT_PIECES + core_pieces + RIGHT_PIECES) for piece in first], 0
    for together in chain([first], rest):
        for buffer, piece in zip(buffers, together, strict=True):
            buffer.append(piece)
        if buffers[0].held == left + core_pieces + RIGHT_PIECES:
            yield tuple(buffer.chunk(left, core_pieces) for buffer in buffers)
            for buffer in buffers:
                buffer.keep(LEFT_PIECES + RIGHT_PIECES)
            left = LEFT_PIECES
    # of each chunk what follows its core is kept: at least that is left for the last one
    yield tuple(buffer.chunk(left, buffer.held - left) for buffer in buffers)


def track_peaks_dbfs(chunk: Chunk, places: NDArray[np.intp], grid: Grid) -> NDArray[np.float64]:
    """Return roughly how loud 20 ms from each of n places of a chunk on get, shape (n,), by the scan's track."""
    steps = places[:, None] // grid.step + np.arange(samples_from_ms(PEAK_MS, grid.rate_hz) // grid.step)
    return levels_db(chunk.peak[np.minimum(steps, chunk.peak.shape[0] - 1)].max(axis=1, initial=0.0))


class _ChunkBuffer:
    """A buffer of successive pieces that is reused: new memory from the system costs half as much as a read."""

    def __init__(self, like: Piece, pieces: int) -> None:
        """Allocate space for so many pieces like the given one."""
        self._size = like.samples.shape[0]
        self._tracks = [np.empty((pieces, *track.shape), np.float32) for track in _tracks(like)]
        self._start, self._stop, self.held = 0, 0, 0

    def append(self, piece: Piece) -> None:
        """Add the piece that follows."""
        for buffer, track in zip(self._tracks, _tracks(piece), strict=True):
            buffer[self.held] = track
        self.held += 1
        self._stop += piece.frames

    def keep(self, pieces: int) -> None:
        """Let go of all but the last pieces."""
        gone = self.held - pieces
        for buffer in self._tracks:
            buffer[:pieces] = buffer[gone : self.held]
        self._start += gone * self._size
        self.held = pieces

    def chunk(self, left: int, core: int) -> Chunk:
        """Return what is held, of which so many pieces after the first `left` ones are the core."""
        samples, peak, slope, bands = (buffer[: self.held].reshape(-1, *buffer.shape[2:]) for buffer in self._tracks)
        first = self._start + left * self._size
        return Chunk(samples, peak, slope, bands, self._start, self._stop, core=Span(first, first + core * self._size))


def _tracks(piece: Piece) -> tuple[NDArray[np.float32], ...]:
    return piece.samples, piece.peak, piece.slope, piece.bands

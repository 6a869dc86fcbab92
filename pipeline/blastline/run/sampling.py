"""A sample of a film: a few seconds from every part of it in one short file, and what reading the film takes."""

import errno
import hashlib
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..errors import OutputError, SoundtrackError
from ..model import Clip, Source, Span
from ..soundtrack import Soundtrack, as_front, write_excerpt
from ..units import samples_from_ms
from .listening import BLOCK

EXCERPT_FRAMES = 12 * BLOCK
"""What is taken from one place: a scene rather than a moment, since shots come in company."""

TIMED_FRAMES = 4 * BLOCK
TIMED_SHARE, TIMED_S = 0.1, 72.0
"""Each tier is timed over a tenth of the film, but no more than 72 s, in pieces of a few seconds from all over it."""

COUNTED_S, LEAST_COUNTED_S = 1200.0, 360.0
"""What a run costs depends most on how many shots there are: they are counted, once, in all of a film of 20 minutes.

In longer ones, which have more of them, fewer seconds tell as well, but no fewer than 360."""

LEAST_S = 12.0

_JOIN_MS = 20.0
_HASHED_BYTES = 8 << 20


@dataclass(frozen=True)
class FilmSample:
    """A sample of a film of `film_s` seconds: excerpts of it in one file of so many `seconds`.

    Every `stride`th few seconds of it make a shorter sample. `source` is the film's; `loudest` the sample's loudest
    frame; `decode_per_s` the CPU seconds that decoding a second of the film takes, `hash_s` those of its digest.
    """

    path: Path
    seconds: float
    stride: int
    loudest: int
    film_s: float
    source: Source
    decode_per_s: float
    hash_s: float


def shorter_sample(sample: Soundtrack, stride: int, *, sides: bool) -> list[Clip]:
    """Return every `stride`th few seconds of a sample, as blocks that follow one another, as a run hears them."""
    frames, starts_apart = sample.source().frames, stride * TIMED_FRAMES
    starts = [at for first in range(0, frames, starts_apart) for at in range(first, first + TIMED_FRAMES, BLOCK)]
    blocks: list[Clip] = []
    for start in starts:
        if start < frames:
            part = sample.read(Span(start, min(start + BLOCK, frames)), sides=sides)
            position = blocks[-1].span.stop if blocks else 0
            beside = None if part.sides is None else part.sides.astype(np.float32)
            blocks.append(Clip(part.samples.astype(np.float32), part.rate_hz, position, beside))
    return blocks


def timed_s(film_s: float) -> float:
    """Return over how many seconds of a film each tier is timed.

    >>> [round(timed_s(minutes * 60.0)) for minutes in (0.1, 1, 10, 120)]
    [6, 12, 60, 72]
    """
    return min(film_s, max(LEAST_S, min(TIMED_S, TIMED_SHARE * film_s)))


def counted_s(film_s: float) -> float:
    """Return in how many seconds of a film its shots are counted.

    >>> [round(counted_s(minutes * 60.0)) for minutes in (1, 10, 20, 30, 120)]
    [60, 600, 1200, 800, 360]
    """
    return min(film_s, max(LEAST_COUNTED_S, COUNTED_S * min(1.0, COUNTED_S / film_s)))


@contextmanager
def room_for_samples() -> Iterator[Path]:
    """Yield a folder for a while; a full disk is told by its name, which the results' disk is not."""
    try:
        with tempfile.TemporaryDirectory(prefix="blastline-") as folder:
            yield Path(folder)
    except OSError as error:
        if error.errno != errno.ENOSPC or error.filename is not None:
            raise
        raise OutputError(
            f"{tempfile.gettempdir()}: cannot write what the budget is tried on: {error.strerror}"
        ) from error


def sample_film(film: Path, track: Soundtrack, path: Path, *, counted: bool) -> FilmSample:
    """Take excerpts from the middle of equal parts of the film, enough to time or also to count, and write them.

    One channel, or where the film has sides, three whose mains and sides are heard as the film's are.
    Raises SoundtrackError for a film that cannot be read, or whose length nothing tells.
    """
    film_s = track.expected_s
    if not film_s:
        raise SoundtrackError(f"{film}: does not say how long it is, so no budget can be kept; give a --quality")
    frames = EXCERPT_FRAMES if counted else TIMED_FRAMES
    excerpt_s = frames / track.rate_hz
    wanted_s = counted_s(film_s) if counted else timed_s(film_s)
    parts = max(1, round(wanted_s / excerpt_s))
    track.read_approximately(0.0, excerpt_s)  # whatever is imported or set up on the way
    starts_s = [max(0.0, (part + 0.5) * film_s / parts - excerpt_s / 2.0) for part in range(parts)]
    taken = _Taken(track, starts_s, frames)
    written = write_excerpt(path, taken.excerpts(), rate_hz=track.rate_hz, channels=taken.channels)
    if not written:
        raise SoundtrackError(f"{film}: no sound could be read at any of {parts} places; give a --quality")
    seconds = written / track.rate_hz
    return FilmSample(
        path,
        seconds,
        stride=max(1, round(seconds / timed_s(film_s))),
        loudest=taken.loudest,
        film_s=film_s,
        source=track.describe(),
        decode_per_s=taken.decode_s / seconds,
        hash_s=_cpu_of_hashing(film),
    )


class _Taken:
    """Excerpts of a film, one at a time: what decoding them took so far, and where the loudest frame of all is."""

    def __init__(self, track: Soundtrack, starts_s: Sequence[float], frames: int) -> None:
        """Take so many frames from each place."""
        self._track, self._starts_s, self._frames = track, starts_s, frames
        self.channels = 3 if track.has_sides else 1
        self.decode_s, self.loudest = 0.0, 0

    def excerpts(self) -> Iterator[NDArray[np.float32]]:
        """Yield the excerpts, faded where they meet, so that no step is taken for a sound."""
        fade = dsp.fade(samples_from_ms(_JOIN_MS, self._track.rate_hz)).astype(np.float32)[:, None]
        at, peak, last = 0, -1.0, len(self._starts_s) - 1
        for part, start_s in enumerate(self._starts_s):
            excerpt = self._decoded(start_s)
            frames = excerpt.shape[0]
            if not frames:
                continue
            short = fade[:frames]
            if at:
                excerpt[: short.size] *= short
            if part < last:
                excerpt[frames - short.size :] *= short[::-1]
            loudest = int(np.argmax(np.abs(excerpt[:, 0])))
            if abs(excerpt[loudest, 0]) > peak:
                peak, self.loudest = float(abs(excerpt[loudest, 0])), at + loudest
            at += frames
            yield as_front(*excerpt.T) if self.channels > 1 else excerpt

    def _decoded(self, start_s: float) -> NDArray[np.float32]:
        """Return what is heard, and beside it, where the film has sides, these."""
        began = process_time()
        columns = self._track.read_approximately(start_s, self._frames / self._track.rate_hz, sides=True)
        self.decode_s += process_time() - began
        return columns[: self._frames, [0, -1] if self.channels > 1 else [0]]


def _cpu_of_hashing(film: Path) -> float:
    """Return what the digest of the whole file takes, from that of its beginning."""
    began = process_time()
    with film.open("rb") as file:
        start = file.read(_HASHED_BYTES)
    hashlib.sha256(start).digest()
    return (process_time() - began) * film.stat().st_size / max(1, len(start))

"""New cuts of a film, with the exact place of each of its moments: scenes removed and inserted, other speeds.

old   ├──── kept ────┤ removed ├──── kept, faster ────┤
new   ├──── kept ────┤ inserted ├─ kept, faster ─┤
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.float32]

_HEARD_S, _MISSED_S = 0.05, 0.005
"""A shot of which less than the one is left, or no more than the other is missing, is neither there nor gone."""

_STEP_S = 0.03
"""The furthest that `atempo` moves a sound from where it would be; the shots of a burst are further apart."""


@dataclass(frozen=True)
class Piece:
    """A piece of a film, in seconds; `inserted` pieces are of another film. A `speed` of 25/24 plays it 4 % faster."""

    start_s: float
    stop_s: float
    speed: float = 1.0
    inserted: bool = False


@dataclass(frozen=True)
class Place:
    """Where a kept piece begins in the new film."""

    piece: Piece
    new_start_s: float


@dataclass(frozen=True, eq=False)
class Recut:
    """The new film, mono, and where the pieces of the old one are; `marked` says it for some moments by itself."""

    samples: Samples
    rate_hz: int
    places: tuple[Place, ...]
    marked: Mapping[float, float] = field(default_factory=dict)

    def true_s(self, old_s: float) -> float | None:
        """Return where a moment of the old film is in the new one; None where it was removed."""
        if old_s in self.marked:
            return self.marked[old_s]
        for place in self.places:
            piece = place.piece
            if piece.start_s <= old_s < piece.stop_s:
                return place.new_start_s + (old_s - piece.start_s) / piece.speed
        return None

    def is_unsure(self, old_s: float) -> bool:
        """Return whether a shot at this moment is cut so that it is neither there nor gone."""
        pieces = [place.piece for place in self.places]
        cut_short = any(0.0 < piece.stop_s - old_s < _HEARD_S for piece in pieces)
        return cut_short or any(0.0 < piece.start_s - old_s < _MISSED_S for piece in pieces)


def recut(old: Samples, other: Samples, pieces: Sequence[Piece], rate_hz: int) -> Recut:
    """Return the film that the pieces make, end to end."""
    parts: list[Samples] = []
    places: list[Place] = []
    done = 0
    for piece in pieces:
        first, last = round(piece.start_s * rate_hz), round(piece.stop_s * rate_hz)
        part = (other if piece.inserted else old)[first:last]
        if not piece.inserted:
            exact = Piece(first / rate_hz, last / rate_hz, piece.speed)
            places.append(Place(exact, done / rate_hz))
        if piece.speed != 1.0:
            part = faster(part, piece.speed, rate_hz)
        parts.append(part)
        done += part.shape[0]
    return Recut(np.concatenate(parts), rate_hz, tuple(places))


def faster(samples: Samples, speed: float, rate_hz: int) -> Samples:
    """Return samples played faster, the pitch with them, as a transfer of 24 pictures a second to 25 does."""
    import soxr

    return np.asarray(soxr.resample(samples, rate_hz * speed, rate_hz), np.float32)


def stretched(samples: Samples, moments_s: Sequence[float], speed: float, rate_hz: int) -> Recut:
    """Return a film played faster at its old pitch, by FFmpeg's `atempo` (WSOLA), and where it put some moments.

    Such a tool moves the sound in steps, each to where it joins best. What it did to a moment is told by a faint click
    in a second channel, which has to go along.
    """
    clicks = np.zeros_like(samples)
    clicks[[round(at * rate_hz) for at in moments_s]] = 1e-3
    both = _through_atempo(np.stack([samples, clicks], axis=1), speed, rate_hz)
    marked = {}
    for at in moments_s:
        first = max(0, round((at / speed - _STEP_S) * rate_hz))
        near = np.abs(both[first : first + round(2.0 * _STEP_S * rate_hz), 1])
        if near.size and near.max() > 0.0:
            marked[at] = (first + int(np.argmax(near))) / rate_hz
    whole = Place(Piece(0.0, samples.shape[0] / rate_hz, speed), 0.0)
    return Recut(both[:, 0].copy(), rate_hz, (whole,), marked)


def _through_atempo(samples: Samples, speed: float, rate_hz: int) -> Samples:
    import av
    from av.filter import Graph

    graph = Graph()
    source = graph.add_abuffer(sample_rate=rate_hz, format="flt", layout="stereo")
    tempo, sink = graph.add("atempo", f"{speed:.9f}"), graph.add("abuffersink")
    source.link_to(tempo)
    tempo.link_to(sink)
    graph.configure()
    parts: list[Samples] = []

    def drain() -> None:
        while True:
            try:
                parts.append(np.asarray(graph.pull().to_ndarray(), np.float32).reshape(-1, 2))
            except (av.BlockingIOError, av.EOFError):
                return

    for start in range(0, samples.shape[0], rate_hz):
        block = np.ascontiguousarray(samples[start : start + rate_hz]).reshape(1, -1)
        frame = av.AudioFrame.from_ndarray(block, format="flt", layout="stereo")
        frame.sample_rate, frame.pts = rate_hz, start
        graph.push(frame)
        drain()
    graph.push(None)
    drain()
    return np.concatenate(parts)


def in_surround(samples: Samples) -> Samples:
    """Return mono sound as 5.1, shape (frames, 6), as a mixer would spread it; the mains sum to about what it was."""
    weights = np.array([0.3, 0.3, 0.45, 0.2, 0.1, 0.1], np.float32)
    return samples[:, None] * weights

"""Streams of one channel each, as film masters keep them, read side by side as the channels of one sound.

Each is read from the file by itself, all in step: so however the file interleaves them, no more than a piece is held.
What grows with the film is FFmpeg's index of it, once for each stream: up to 50 MB in two hours of a finely interleaved
MOV. One pass for all would need it once, but hold whole streams where a file has one after the other.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import zip_longest
from pathlib import Path

import numpy as np

from ..errors import SoundtrackError
from ..streams import streams_text
from .chunks import ChunkTable
from .film import FilmTrack, open_film
from .singles import layout_of
from .track import PIECE, Samples, TrackFacts, in_blocks


class JoinedTrack:
    """Several streams of one file; the first is the first channel."""

    def __init__(self, tracks: Sequence[FilmTrack]) -> None:
        """Take over open streams. Raises SoundtrackError where they are not channels of one sound."""
        self._tracks = tracks
        self._frames = [0] * len(tracks)
        self.facts = _joined_facts(tracks)

    def pieces(self) -> Iterator[Samples]:
        """Yield all samples in order, shape (frames, channels); a stream that ends early is silent from there on."""
        for parts in zip_longest(*(_in_step(track, track.pieces()) for track in self._tracks)):
            for channel, part in enumerate(parts):
                self._frames[channel] += 0 if part is None else part.shape[0]
            yield _side_by_side(parts)

    def read_approximately(self, start_s: float, frames: int) -> Iterator[Samples]:
        """Yield at least so many samples, if there are, from about that time on."""
        streams = (_in_step(track, track.read_approximately(start_s, frames)) for track in self._tracks)
        yield from map(_side_by_side, zip_longest(*streams))

    def warnings(self) -> list[str]:
        """Return what was damaged, filled or overruled, one line each, with the streams of which it is true."""
        told: dict[str, list[int]] = {}
        for track, frames in zip(self._tracks, self._frames, strict=True):
            lines = track.warnings()
            if frames < max(self._frames):
                ends_s, last_s = frames / self.facts.rate_hz, max(self._frames) / self.facts.rate_hz
                lines.append(f"ends at {ends_s:.3f} s, others at {last_s:.3f} s: silence was put in its place")
            for line in lines:
                told.setdefault(line, []).append(track.number)
        return [
            line if len(of) == len(self._tracks) else f"sound stream {streams_text(of)}: {line}"
            for line, of in told.items()
        ]

    def close(self) -> None:
        """Close the file."""
        for track in self._tracks:
            track.close()


def open_joined(path: Path, streams: Sequence[int], *, table: ChunkTable | None) -> JoinedTrack:
    """Open streams of one channel each as one track; `table` is what a WAV header declares.

    Raises SoundtrackError where one of them cannot be read, or where they are not channels of one sound.
    """
    tracks: list[FilmTrack] = []
    try:
        for stream in streams:
            tracks.append(open_film(path, stream=stream, table=table))
        return JoinedTrack(tracks)
    except BaseException:
        for track in tracks:
            track.close()
        raise


def _joined_facts(tracks: Sequence[FilmTrack]) -> TrackFacts:
    """Return what is known of the joined sound. Raises SoundtrackError where the streams do not go together."""
    first, all_facts = tracks[0].facts, [track.facts for track in tracks]
    for track, facts in zip(tracks, all_facts, strict=True):
        if facts.channels != 1:
            raise SoundtrackError(
                f"sound stream {facts.stream} has {facts.channels} channels; expected one in each stream that is joined"
            )
        if facts.rate_hz != first.rate_hz:
            raise SoundtrackError(
                f"sound stream {facts.stream} has {facts.rate_hz} Hz; expected {first.rate_hz} Hz as in stream "
                f"{first.stream}, with which it is joined"
            )
        late_s = (track.origin or Fraction(0)) - (tracks[0].origin or Fraction(0))
        if abs(late_s) * first.rate_hz >= 1:
            raise SoundtrackError(
                f"sound stream {facts.stream} begins {float(late_s):+.6f} s off stream {first.stream}, with which it "
                "is joined; expected the same start"
            )
    declared = [facts.declared_frames for facts in all_facts]
    return replace(
        first,
        channels=len(tracks),
        layout=layout_of([facts.layout for facts in all_facts], [track.title for track in tracks]),
        declared_frames=None if None in declared else max(frames or 0 for frames in declared),
        stream=tuple(track.number for track in tracks),
        beside=tuple(each for each in first.beside if all(each in facts.beside for facts in all_facts)),
    )


def _in_step(track: FilmTrack, pieces: Iterable[Samples]) -> Iterator[Samples]:
    """Yield the samples of a stream in blocks as long as those of the others; its errors tell which it is."""
    try:
        yield from in_blocks(pieces, PIECE)
    except SoundtrackError as error:
        raise SoundtrackError(f"sound stream {track.number}: {error}") from error


def _side_by_side(parts: Sequence[Samples | None]) -> Samples:
    """Return one block of all streams, shape (frames, channels), silent where a stream has no more."""
    joined = np.zeros((max(part.shape[0] for part in parts if part is not None), len(parts)), np.float32)
    for channel, part in enumerate(parts):
        if part is not None:
            joined[: part.shape[0], channel] = part[:, 0]
    return joined

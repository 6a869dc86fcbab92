"""One sound track of a file: decoded once, mixed to what detection hears and what drives, and read again exactly.

file ──► track (sample file or film) ──► mend ──► mix ──► blocks ──► detection
                                                    └──► spool, where the file cannot be read twice ──► spans read again
"""

import hashlib
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ..errors import SoundtrackError
from ..model import Channels, Clip, Source, Span
from ..timebase import AS_FILMED, Timebase, uncounted, with_timebase
from ..timecode import time_of_start
from .condition import Condition
from .files import FileState, naming, require_unchanged
from .loudspeakers import azimuths
from .mix import Matrix, centre_of, mixed, sides_matrix, summing_order
from .pcm import PcmTrack
from .recent import Recent
from .repair import mended
from .spool import Spool
from .track import PIECE, Samples, Track, in_blocks


class Soundtrack:
    """A sound track that is open for reading; made by `open_soundtrack`, closed by `close` or a `with` block."""

    def __init__(
        self,
        path: Path,
        track: Track,
        *,
        matrix: Matrix,
        mix: str,
        spool: Spool | None,
        timebase: Timebase = AS_FILMED,
        opened: FileState | None = None,
    ) -> None:
        """Take over an open track; `spool` keeps its mixed sound where the track cannot be read a second time.

        `opened` is what the path named then, which it has to name to the end; None for a track that comes from no file.
        """
        self._path, self._track, self._matrix, self._mix, self._spool = path, track, matrix, mix, spool
        self._opened = opened
        self._timebase = timebase
        self._frames: int | None = None
        self._started = False
        self._condition = Condition(track.facts, mix, matrix)
        layout, channels = track.facts.layout, track.facts.channels
        self._order = summing_order(layout, channels)
        self._sides = sides_matrix(layout, channels, mix)
        self._centre = centre_of(layout, channels)
        self._azimuths_deg = azimuths(layout, channels)
        self._recent: Recent | None = None
        self.rate_hz = track.facts.rate_hz
        self.channels = track.facts.channels
        self.columns = int(matrix.shape[1])
        self.expected_frames = track.facts.declared_frames

    @property
    def time_reference(self) -> int:
        """Return the samples between midnight and the first sample, 0 where the file does not say."""
        return time_of_start(self.describe())

    @property
    def damaged_samples(self) -> int:
        """Return how many samples of the blocks taken so far were no number, or beyond any sound, and were set to 0."""
        return self._condition.damaged_samples

    @property
    def has_sides(self) -> bool:
        """Return whether the film has sides, as `mix.py` explains them, that can be listened to as well."""
        return self._sides is not None

    @property
    def is_pair(self) -> bool:
        """Return whether the sides are what two channels play against each other, which the mains do not hold."""
        return self._sides is not None and self._centre is None

    @property
    def channels_in_space(self) -> Channels | None:
        """Return where a film's channels play and how to read them; None where it has not two that have a place.

        Of a file that cannot be read twice, only what `blocks` was asked to remember can be read.
        """
        return None if self._azimuths_deg is None else Channels(self._azimuths_deg, self._centre, self._channels)

    def blocks(
        self, frames: int = PIECE, *, sides: bool = False, kept_sides: bool = False, remembered_s: float = 0.0
    ) -> Iterator[Clip]:
        """Yield the mixed sound from its first sample to its last, float32; this is the one decoding pass.

        Every block has `frames` frames but the last. With `sides`, those that the film has come with it; with
        `kept_sides` they can be read again afterwards, as those of a pair always can. The channels of the last
        `remembered_s` seconds can be read through `channels_in_space`. Raises SoundtrackError where the file proves to
        be unreadable, OutputError where the disk has no room for the decoded sound.
        """
        if frames < 1:
            raise ValueError(f"a block must have at least 1 frame, not {frames}")
        if self._started:
            raise ValueError("the sound track has been decoded already; use read()")
        self._started = True
        if remembered_s and self._azimuths_deg is not None and not isinstance(self._track, PcmTrack):
            self._recent = Recent(frames + round(remembered_s * self.rate_hz))
        start = 0
        for samples in in_blocks(self._mixed_pieces(sides=sides, kept_sides=kept_sides), frames):
            yield self._clip(samples, start)
            start += samples.shape[0]
        if start == 0:
            raise SoundtrackError(f"{self._path}: holds no sound")
        self._frames = start

    @property
    def expected_s(self) -> float | None:
        """Return how long the track is, as it says or else as its size suggests; None where neither tells."""
        return self._track.facts.guessed_s if self.expected_frames is None else self.expected_frames / self.rate_hz

    def read_approximately(self, start_s: float, length_s: float, *, sides: bool = False) -> Samples:
        """Return the mixed sound of at least about that time, for a rough look before the track is decoded.

        With `sides`, a film that has any has them as one column more. A film has to be opened anew to be decoded.
        Raises SoundtrackError where it cannot be read there.
        """
        self._started = True
        with naming(self._path):
            frames = max(1, round(length_s * self.rate_hz))
            raw = self._track.read_approximately(start_s, frames)
            mend = not self._track.facts.is_integer
            whole = (mended(piece).samples if mend else piece for piece in raw)
            pieces = [self._mixed(samples, sides=sides) for samples in whole]
        columns = self.columns + (sides and self.has_sides)
        return np.concatenate([np.zeros((0, columns), np.float32), *pieces])

    def read(self, span: Span, *, sides: bool = False) -> Clip:
        """Return the exact samples of a span inside the track, float64, once all blocks have been taken.

        With `sides`, those that the film has come with it, if the file can be read twice, if the film is a pair, or if
        `blocks` was asked to keep them. Raises ValueError where the span leaves the track, SoundtrackError where a file
        that is read twice has changed.
        """
        if self._frames is None or span.start < 0 or span.stop > self._frames:
            raise ValueError(f"{span} is not inside what was decoded: {self._frames} frames")
        if isinstance(self._track, PcmTrack):
            columns = self._mixed(self._read(self._track, span), sides=sides)
        else:
            if self._spool is None:
                raise ValueError("a compressed film that is to be read again has to be opened as `rereadable`")
            columns = self._spool.read(span)
            columns = columns if sides else columns[:, : self.columns]
        return self._clip(columns.astype(np.float64), span.start)

    def release_recent(self) -> None:
        """Let go of what `blocks` was asked to remember."""
        self._recent = None

    def source(self) -> Source:
        """Return what was read, with the digest of the whole file, once all blocks have been taken.

        Raises SoundtrackError where the file is no longer what was opened: the digest would be of another sound; and
        where so many samples are no numbers that what is left is no sound.
        """
        if self._frames is None:
            raise ValueError("the source is known once all blocks have been taken")
        with naming(self._path):
            self._condition.require_usable()
            require_unchanged(self._path, self._opened)
            with self._path.open("rb") as file:
                digest = hashlib.file_digest(file, "sha256").hexdigest()
            require_unchanged(self._path, self._opened)
        warnings = (*self._track.warnings(), *uncounted(self.describe()), *self._condition.warnings())
        return self.describe(sha256=digest, frames=self._frames, warnings=warnings)

    def close(self) -> None:
        """Release the file and the spool."""
        self._track.close()
        if self._spool is not None:
            self._spool.close()

    def __enter__(self) -> Self:
        """Return the sound track."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self.close()

    def _read(self, track: PcmTrack, span: Span) -> Samples:
        with naming(self._path):
            require_unchanged(self._path, self._opened)
            raw = track.read(span.start, len(span))
        return raw if track.facts.is_integer else mended(raw).samples

    def _channels(self, span: Span) -> Samples | None:
        if isinstance(self._track, PcmTrack):
            return self._read(self._track, span)
        return None if self._recent is None else self._recent.read(span)

    def _mixed_pieces(self, *, sides: bool, kept_sides: bool) -> Iterator[Samples]:
        heard_beside = (sides or kept_sides) and self.has_sides
        kept_sides = (kept_sides or self.is_pair) and self._spool is not None
        given = self.columns + (sides and self.has_sides)
        with naming(self._path):
            for raw in self._track.pieces():
                samples = self._condition.usable(raw)
                columns = self._mixed(samples, sides=sides or kept_sides)
                self._condition.hear(samples, columns[:, : self.columns], sides=heard_beside)
                if self._spool is not None:
                    self._spool.append(np.ascontiguousarray(columns if kept_sides else columns[:, : self.columns]))
                if self._recent is not None:
                    self._recent.append(samples)
                yield columns[:, :given]
        if self._spool is not None:
            self._spool.finish()

    def _mixed(self, samples: Samples, *, sides: bool) -> Samples:
        """Return the columns of the mix; with sides, where the film has any, these are a further one."""
        columns = mixed(samples, self._matrix, self._order)
        if self._sides is None or not sides:
            return columns
        return np.column_stack([columns, mixed(samples, self._sides, self._order)])

    def _clip(self, columns: NDArray[np.floating], start: int) -> Clip:
        """Return the columns as a clip; what is beyond those of the mix are the sides."""
        mix, beside = columns[:, : self.columns], columns[:, self.columns :]
        return Clip(mix, self.rate_hz, start, beside[:, 0] if beside.shape[1] else None)

    def describe(self, *, sha256: str = "", frames: int = 0, warnings: tuple[str, ...] = ()) -> Source:
        """Return what is known before the sound is decoded, with what is given."""
        facts = self._track.facts
        source = Source(
            name=self._path.name,
            sha256=sha256,
            sample_rate_hz=facts.rate_hz,
            frames=frames,
            channels=facts.channels,
            start_timecode=facts.start_timecode,
            has_picture=facts.has_picture,
            frame_rate=facts.frame_rate,
            start_offset_s=facts.start_offset_s,
            stream=facts.stream,
            mix=self._mix,
            warnings=warnings,
        )
        return with_timebase(source, self._timebase)

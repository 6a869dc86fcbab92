"""Where decoded frames belong: counted one after the other, with silence where the file lost some.

Time stamps are rounded (to 1 ms in Matroska) and may be missing for a while after damage, so samples are placed by
counting; time stamps only tell that something is missing. FFmpeg's FLAC reader, for one, hands over what it can of a
damaged stretch without stamps, and then resumes:

    stamps     0   4096     -     -    20480  24576
    frames   [ A ][ B ] [ C ] [ D ]    [ F ]  [ G ]     F is 4096 samples later than counted, and so is G:
    placed   [ A ][ B ] [ C ] [ D ][..][ F ]  [ G ]     a gap of one frame before F

A gap is believed once a second frame confirms it, a long one once a second of sound does, so that one wild stamp moves
nothing: in a transport stream it may be that of all frames of a packet.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Generic, Protocol, TypeVar

MAX_HELD_S = 2.0
"""How much sound is held back at most until a gap before it is confirmed."""

_TOLERANCE_S = 0.002

_LONG_GAP_S, _CONFIRMED_BY_S = 2.0, 1.0
"""A gap longer than the first is confirmed by so much sound that is as late."""


class Stamped(Protocol):
    """What placement looks at in a frame."""

    @property
    def samples(self) -> int:
        """Return how many samples per channel it has."""

    @property
    def pts(self) -> int | None:
        """Return its time stamp, in units of `time_base`."""

    @property
    def time_base(self) -> Fraction | None:
        """Return the seconds per unit."""


FrameT = TypeVar("FrameT", bound=Stamped)


@dataclass(frozen=True)
class Gap:
    """Samples that the file has lost, to be replaced by silence."""

    samples: int


@dataclass
class Placement(Generic[FrameT]):
    """Places the frames of one track.

    `origin` is the time of sample 0 in seconds, taken from the first stamped frame where it is None. No gap may push
    the sound beyond `max_frames`: a stamp that asks for it is wrong. `gaps` and `jumps` collect (sample, samples) of
    what was filled, and of what the stamps wanted but did not get.
    """

    rate_hz: int
    max_frames: int
    origin: Fraction | None = None
    gaps: list[tuple[int, int]] = field(default_factory=list)
    jumps: list[tuple[int, int]] = field(default_factory=list)
    _position: int = 0
    _held: list[FrameT] = field(default_factory=list)
    _held_samples: int = 0
    _suspected: int = 0
    _usual: int = 0
    _tick: int = 1
    _scale: float | None = None
    _zero: float = 0.0

    def place(self, frames: Iterable[FrameT]) -> Iterator[FrameT | Gap]:
        """Yield all frames in order, and a gap before the frame where sound is missing."""
        for frame in frames:
            drift = self._drift(frame)
            tolerance = max(int(_TOLERANCE_S * self.rate_hz), self._tick)
            if (drift is None and not self._held) or (drift is not None and abs(drift) <= tolerance):
                self._suspected = 0
                yield from self._release()
                yield self._passed(frame)
                continue
            if drift is not None and self._suspected:
                if abs(drift - self._suspected) <= tolerance:
                    if self._is_witnessed():
                        yield from self._resolve()
                        yield self._passed(frame)
                        continue
                elif drift > self._suspected > 0:  # more was lost in between
                    yield from self._resolve()
                    drift = self._drift(frame)
            self._hold(frame)
            self._suspected = drift if drift is not None else self._suspected
            if self._held_samples > MAX_HELD_S * self.rate_hz:
                yield from self._resolve()
        yield from self._resolve()

    def _drift(self, frame: FrameT) -> int | None:
        """Return how much later the frame's stamp is than its place by counting."""
        stamp = frame.pts
        if stamp is None:
            return None
        counted = self._position + self._held_samples
        if self._scale is None:
            # a track keeps its time base; asking every frame for it would cost more than decoding does
            if not (time_base := frame.time_base):
                return None
            if self.origin is None:
                self.origin = stamp * time_base - Fraction(counted, self.rate_hz)
            self._scale, self._tick = float(time_base * self.rate_hz), int(time_base * self.rate_hz) + 1
            self._zero = float(self.origin * self.rate_hz)
        return round(stamp * self._scale - self._zero) - counted

    def _is_witnessed(self) -> bool:
        """Return whether one more frame is enough to confirm the suspected gap."""
        is_long = abs(self._suspected) > _LONG_GAP_S * self.rate_hz
        return not is_long or self._held_samples >= _CONFIRMED_BY_S * self.rate_hz

    def _hold(self, frame: FrameT) -> None:
        self._held.append(frame)
        self._held_samples += frame.samples

    def _passed(self, frame: FrameT) -> FrameT:
        self._position += frame.samples
        self._usual = frame.samples or self._usual
        return frame

    def _release(self) -> Iterator[FrameT]:
        held, self._held, self._held_samples = self._held, [], 0
        for frame in held:
            yield self._passed(frame)

    def _resolve(self) -> Iterator[FrameT | Gap]:
        """Put the suspected gap before the held frames; stamps that step back or run wild are overruled."""
        gap, self._suspected = self._whole_frames(self._suspected), 0
        if gap and 0 < gap <= self.max_frames - self._position:
            self.gaps.append((self._position, gap))
            self._position += gap
            yield Gap(gap)
        elif gap:
            self.jumps.append((self._position, gap))
            self._zero += gap
        yield from self._release()

    def _whole_frames(self, gap: int) -> int:
        """Return the gap as a whole number of the codec's frames where the stamps are too coarse to tell."""
        lost = round(gap / self._usual) if self._usual else 0
        return lost * self._usual if lost > 0 and abs(gap - lost * self._usual) <= self._tick else gap


def origin_by_others(frames: Sequence[Stamped], rate_hz: int) -> Fraction | None:
    """Return the time of sample 0 by the stamps of most of these frames, the first ones of a track.

    None where the first frame agrees with them, where they do not agree with one another, or where any has no stamp.
    """
    origins, counted = [], 0
    for frame in frames:
        if frame.pts is None or not frame.time_base:
            return None
        origins.append(frame.pts * frame.time_base - Fraction(counted, rate_hz))
        counted += frame.samples
    if len(origins) < 3 or not (time_base := frames[0].time_base):
        return None
    tolerance = max(Fraction(_TOLERANCE_S), 2 * time_base)
    # one stamp may be that of several frames, so more than the first one may be wrong
    wrong = next((k for k, origin in enumerate(origins) if abs(origin - origins[-1]) <= tolerance), 0)
    others = origins[wrong:]
    agreed = max(others) - min(others) <= tolerance and len(others) > max(wrong, 1)
    return others[0] if wrong and agreed else None

"""Where decoded frames belong: counted one after the other, and corrected where the stamps say so for long.

Time stamps are rounded (to 1 ms in Matroska), wobble (by 10 ms on a DVD with LPCM, by 30 in captures) and may be
missing for a while after damage, so samples are placed by counting. FFmpeg's FLAC reader, for one, hands over what it
can of a damaged stretch without stamps, and then resumes:

    stamps     0   4096     -     -    20480  24576
    frames   [ A ][ B ] [ C ] [ D ]    [ F ]  [ G ]     F is 4096 samples later than counted, and so is G:
    placed   [ A ][ B ] [ C ] [ D ][..][ F ]  [ G ]     a gap of one frame before F

What does not fit is held back for two seconds, or to the end of the track. A single stamp among those that fits again
refutes the rest: they wobbled, or ran wild (in a transport stream, for all frames of a packet), and nothing moves.

- **Late** for so long: silence is filled in, as much as the least late of them asks for. What is filled in is never
  forgotten, so stamps that go to and fro are never paid for twice: no sound is farther from where it belongs than some
  stamp is.
- **Early** for so long, by more than 30 ms or a frame, or by just some whole frames: part of the sound came before. A
  block of the file is there twice, the sound's clock is slow, or pieces that an edit list strings together reach over
  their ends. So much is cut off the front of what follows, as players do. What is early by less stays: FFmpeg rounds
  the pieces of an edit list to whole frames, and stamps the next one as if it had not.
- **Jumped**: stamps that step back by more than a second, or to the beginning of the track, are those of another file
  joined to this one, or of a clock that was set anew, as are those that lead out of the film. The sound is kept in one
  piece, and the stamps are counted anew from there; in the end also where they do not run on with the sound.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Generic

from ..errors import SoundtrackError
from .stamped import FrameT, Gap, Overlap

MAX_HELD_S = 2.0
"""How much sound is held back at most until its stamps are believed."""

TOLERANCE_S = 0.002
"""What is off by no more than this, or than stamps are rounded, is not off at all."""

_MAX_SILENCE_S = 24 * 3600
"""No film has so much silence in its gaps: a header that is damaged makes days of any sound."""

_EARLY_S = 0.03
"""What is early by no more than this, or than a frame, stays where it is, but for whole frames of a certain length."""

_LEAST_AGAIN_S = 0.01
_MAX_OVERLAP_S = 1.0
_MAX_SLOWNESS = 0.1
"""By what share of their time stamps may fall behind the sound, and still tell what is there twice."""


@dataclass
class Placement(Generic[FrameT]):
    """Places the frames of one track.

    `origin` is the time of sample 0 in seconds, taken from the first stamped frame where it is None. No gap may push
    the sound beyond `max_frames`: a stamp that asks for it is wrong. `gaps`, `overlaps` and `jumps` collect
    (sample, samples) of what was filled, of what was dropped, and of what the stamps wanted but did not get.
    """

    rate_hz: int
    max_frames: int
    origin: Fraction | None = None
    gaps: list[tuple[int, int]] = field(default_factory=list)
    overlaps: list[tuple[int, int]] = field(default_factory=list)
    jumps: list[tuple[int, int]] = field(default_factory=list)
    _position: int = 0
    _held: list[tuple[FrameT, int | None]] = field(default_factory=list)
    """Frames, the first of which does not fit, and how much later than counted their stamps are."""
    _held_samples: int = 0
    _filled: int = 0
    _usual: int = 0
    _tick: int = 1
    _tolerance: int = 0
    _wobble: int = 0
    """The most that was refuted so far, of what may be a wobble."""
    _scale: float | None = None
    _zero: float = 0.0

    @property
    def sound(self) -> int:
        """Return how many samples of sound were placed so far."""
        return self._position - self._filled

    def place(self, frames: Iterable[FrameT]) -> Iterator[FrameT | Gap | Overlap]:
        """Yield the frames in order, a gap before one where sound is missing, an overlap before one to be cut.

        Raises SoundtrackError where the gaps are longer than any film has silence.
        """
        self._tolerance = int(TOLERANCE_S * self.rate_hz)
        for frame in frames:
            late = self._late(frame)
            if not self._held and (late is None or self._fits(late)):
                yield self._passed(frame)
                continue
            self._held.append((frame, late))
            self._held_samples += frame.samples
            if late is not None and self._refutes(late):
                yield from self._refuted(len(self._held) - 1)
            elif not self._ended():
                yield from self._resolve()
        while self._held:
            idle = self._ended() and self._says_little()
            yield from self._release(len(self._held)) if idle else self._resolve()

    def _late(self, frame: FrameT) -> int | None:
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
            self._tolerance = max(self._tolerance, self._tick)
        return round(stamp * self._scale - self._zero) - counted

    def _fits(self, late: int) -> bool:
        """Return whether a frame may stay where counting puts it."""
        if late >= -2 * self._tolerance:
            return late <= self._tolerance
        # of shorter frames, any wobble is so many
        return -late <= self._slack() and not (self._usual > _LEAST_AGAIN_S * self.rate_hz and self._is_whole(-late))

    def _slack(self) -> int:
        return max(int(_EARLY_S * self.rate_hz), self._usual)

    def _refutes(self, late: int) -> bool:
        """Return whether a frame shows that the first one held is no later, or no earlier, for long."""
        if self._fits(late):
            return True
        far, first = int(_MAX_OVERLAP_S * self.rate_hz), self._held[0][1] or 0
        # a stamp that is far off on the other side is wild itself, or of a file that was joined
        return -far <= late < 0 if first > 0 else 0 < late <= far

    def _passed(self, frame: FrameT) -> FrameT:
        self._position += frame.samples
        self._usual = frame.samples or self._usual
        return frame

    def _says_little(self) -> bool:
        """Return whether the held are no farther off than what was refuted before, or only one is, and early."""
        stamps = [late for _, late in self._held if late is not None]
        is_known = all(abs(late) <= self._wobble + self._tolerance for late in stamps)
        return is_known or (len(stamps) == 1 and stamps[0] < 0)

    def _refuted(self, count: int) -> Iterator[FrameT]:
        """Yield so many of the frames held and more, as they are."""
        off = abs(self._held[0][1] or 0)
        self._wobble = max(self._wobble, off if off <= self._slack() else 0)
        return self._release(count)

    def _release(self, least: int) -> Iterator[FrameT]:
        """Yield so many of the frames held, more of them up to the last one that fits, and those without a stamp."""
        count = least
        for k in range(len(self._held), least, -1):
            late = self._held[k - 1][1]
            if late is not None and self._fits(late):
                count = k
                break
        while count < len(self._held) and self._held[count][1] is None:
            count += 1
        released, self._held = self._held[:count], self._held[count:]
        for frame, _ in released:
            self._held_samples -= frame.samples
            yield self._passed(frame)

    def _resolve(self) -> Iterator[FrameT | Gap | Overlap]:
        """Believe the stamps of the frames held, or overrule them."""
        far = int(_MAX_OVERLAP_S * self.rate_hz)
        for k, (_, late) in enumerate(self._held):
            if k and late is not None and self._refutes(late):
                yield from self._refuted(k)
                return
        stamps = [late for _, late in self._held if late is not None]
        first = stamps[0]
        near = [late for late in stamps if (late >= -far or first < -far) and (late <= far or first > 0)]
        gap, early = (self._whole_frames(min(near)), 0) if first > 0 else (0, -max(near))
        if len(near) == 1 < len(stamps):  # nothing confirms it
            yield from self._release(1)
            return
        if 0 < gap <= self.max_frames - self._position:
            self._require_film(gap)
            self.gaps.append((self._position, gap))
            self._count_from(gap)
            self._position += gap
            self._filled += gap
            yield Gap(gap)
        elif gap or early > far or self._starts_over(first):
            self.jumps.append((self._position, stamps[-1]))
            self._count_from(stamps[-1])
            self._zero += stamps[-1]
        elif len(near) > 1 and -early - stamps[-1] <= max(self._slack(), _MAX_SLOWNESS * self._held_samples):
            overlap = min(self._whole_frames(early), self._held_samples)
            self.overlaps.append((self._position, overlap))
            self._count_from(-overlap)
            self._position -= overlap
            yield from self._drop(overlap)
        else:  # stamps that do not run on: what comes may tell, if anything does
            share = 1 if self._ended() else 100
            yield from self._release(-(-len(self._held) // share))
            return
        yield from self._release(0)

    def _require_film(self, gap: int) -> None:
        """Raise SoundtrackError where one gap more would make the silence longer than any film."""
        asked, sound = (self._filled + gap) / self.rate_hz, self.sound / self.rate_hz
        if asked > _MAX_SILENCE_S:
            raise SoundtrackError(
                f"its time stamps ask for {asked:.0f} s of silence in the first {sound:.3f} s of sound; "
                f"expected no more than {_MAX_SILENCE_S} s: its header or its time stamps are damaged"
            )

    def _ended(self) -> bool:
        """Return whether so little is held that, where it is judged, nothing follows."""
        return self._held_samples <= MAX_HELD_S * self.rate_hz

    def _starts_over(self, late: int) -> bool:
        """Return whether a stamp is that of the beginning of the track, and not within the first half second."""
        return self._position > self.rate_hz // 2 and abs(self._position + late) <= self._tolerance

    def _drop(self, samples: int) -> Iterator[FrameT | Overlap]:
        """Drop so many samples of those held: whole frames, and then the first part of one."""
        while self._held and samples >= self._held[0][0].samples:
            frame, _ = self._held.pop(0)
            self._held_samples -= frame.samples
            samples -= self._passed(frame).samples
        if samples:
            yield Overlap(samples)
            yield from self._release(1)

    def _count_from(self, samples: int) -> None:
        """Count the frames held from so much later on."""
        self._held = [(frame, None if late is None else late - samples) for frame, late in self._held]

    def _is_whole(self, samples: int) -> bool:
        """Return whether so much is some whole frames of the codec, as far as the stamps can tell."""
        frames = round(samples / self._usual) if self._usual else 0
        return frames > 0 and abs(samples - frames * self._usual) <= self._tick

    def _whole_frames(self, samples: int) -> int:
        """Return a length as a whole number of the codec's frames where the stamps are too coarse to tell."""
        return round(samples / self._usual) * self._usual if self._is_whole(samples) else samples

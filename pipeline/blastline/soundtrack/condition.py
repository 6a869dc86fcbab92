"""In which condition the samples of a track were found, block by block: what had to be set to 0, and what sounds."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..errors import SoundtrackError
from ..streams import streams_text
from .cancelling import Cancelling
from .coded import first_burst
from .dropouts import Dropouts
from .lengths import length_warnings
from .repair import LOUD, Mended, loud_warning, mended, repair_warning, require_usable
from .track import Samples, TrackFacts

_SILENT = 10.0**-4.5
"""What strays no further from its first sample, -90 dBFS, is silent: decoders of AC-3 fill silence with noise."""

_SEARCHED_FIRST, _SEARCHED_EVERY = 16, 8
"""So many blocks are searched for coded data, then one in so many: bursts go on, and to search all costs a third of
reading a film. Data that begins late may be seen some seconds later, and a few seconds of it not at all."""


class Condition:
    """What has been seen of one track so far."""

    def __init__(self, facts: TrackFacts, mix: str, matrix: NDArray[np.float32]) -> None:
        """Begin before the first sample of a track that is heard as the mix of that name and matrix."""
        self._facts, self._mix, self._heard = facts, mix, np.asarray(np.any(matrix, axis=1))
        self._mixed_channels = np.count_nonzero(matrix[:, 0])
        self._cancelling = Cancelling(matrix[:, 0], facts.rate_hz)
        self._frames, self._blocks, self._mended, self._first_mended = 0, 0, 0, 0
        self._mix_sounds, self._track_sounds = False, False
        self._still: tuple[Samples, np.floating] | None = None
        self._peak, self._first_loud = 0.0, 0
        self._dropouts = Dropouts(facts.rate_hz, facts.stored)

    @property
    def damaged_samples(self) -> int:
        """Return how many samples were no number, or beyond any sound."""
        return self._mended

    def usable(self, raw: Samples) -> Samples:
        """Return the next samples, shape (frames, channels), with those set to 0 that are no sound.

        Raises SoundtrackError where they are coded data: read as sound, they are noise at full scale.
        """
        if self._blocks < _SEARCHED_FIRST or self._blocks % _SEARCHED_EVERY == 0:
            self._require_sound(raw)
        self._blocks += 1
        if self._facts.is_integer:
            samples = raw
        else:
            found = mended(raw)
            samples = found.samples
            if found.count and not self._mended:
                self._first_mended = self._frames + found.first
            self._mended += found.count
            self._measure(found)
        self._frames += raw.shape[0]
        return samples

    def hear(self, samples: Samples, mix: Samples, *, sides: bool) -> None:
        """Note whether the track sounds, and what drives, the last column of the mix.

        With `sides`, what a pair plays against each other is heard in them.
        """
        if self._facts.is_pcm:  # decoders of what is compressed tell what they lack, and have it silent
            self._dropouts.hear(samples)
        if self._mixed_channels > 2 or (self._mixed_channels == 2 and not sides):
            self._cancelling.hear(samples, mix[:, 0])
        if self._still is None and len(samples):
            self._still = samples[0].copy(), mix[0, -1].copy()
        if self._still is not None:  # a constant is no sound
            self._mix_sounds = self._mix_sounds or _strays(mix[:, -1], self._still[1])
            self._track_sounds = self._track_sounds or self._mix_sounds or _strays(samples, self._still[0])

    def require_usable(self) -> None:
        """Raise SoundtrackError where so many samples are no numbers that what is left is no sound."""
        require_usable(self._mended, self._frames * self._facts.channels)

    def warnings(self) -> Iterator[str]:
        """Yield what a user has to know, a line each, once all samples have been seen."""
        if self._mended:
            yield repair_warning(self._mended, self._first_mended)
        if self._peak > LOUD:
            yield loud_warning(self._peak, self._first_loud)
        if self._frames and not self._track_sounds:
            yield f"sound stream {streams_text(self._facts.stream)} is silent from beginning to end{self._others()}"
        elif self._frames and not self._mix_sounds:
            yield f"the mix {self._mix} is silent, though the film is not: its channels cancel, or others sound"
        elif self._cancelling.lost_s:
            lost_s, first_s = self._cancelling.lost_s, self._cancelling.first_s
            yield (
                f"the channels of the mix {self._mix} cancel for {lost_s:.2f} s, first at {first_s:.2f} s: what they "
                "play against each other there is not heard; --mix with the numbers of some channels hears those alone"
            )
        yield from self._dropouts.warnings()
        yield from length_warnings(self._facts, self._frames)

    def _measure(self, found: Mended) -> None:
        """Note how large the samples that follow are, and where the first of those is that are too large for a mix."""
        if found.peak > LOUD >= self._peak:
            self._first_loud = self._frames + int(np.argmax(np.any(np.abs(found.samples) > LOUD, axis=1)))
        self._peak = max(self._peak, found.peak)

    def _require_sound(self, raw: Samples) -> None:
        """Raise SoundtrackError where samples hold bursts of coded data in what is heard."""
        found = first_burst(raw, self._heard)
        if found is not None:
            others = ("; --mix chooses other channels" if self._facts.channels > 2 else "") + self._others()
            of, at_s = streams_text(self._facts.stream), (self._frames + found.frame) / self._facts.rate_hz
            raise SoundtrackError(
                f"sound stream {of} holds coded data ({found.kind}) at {at_s:.3f} s; expected PCM sound{others}"
            )

    def _others(self) -> str:
        """Return what could be heard in the place of this stream, to be added to a line."""
        beside = "; ".join(self._facts.beside)
        return f"; --stream chooses another: {beside}" if beside else ""


def _strays(samples: NDArray[np.floating], still: NDArray[np.floating] | np.floating) -> bool:
    """Return whether samples are more than silence around a constant."""
    return bool((np.abs(samples - still) > _SILENT).any())

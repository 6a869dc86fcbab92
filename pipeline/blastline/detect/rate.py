"""The rate at which detection listens: it has learnt at 48 kHz, so a film at another rate is heard at this one.

    film      |  |  |  |  |  |  |  |  |       clips ──► resampled ──► shots ──► in_film
    listened  |    |    |    |    |           places go to the film's nearest sample, i / 48 kHz ──► i rate / 48 kHz

Below 48 kHz this makes nothing new: what the film's rate cannot hold is as silent as in any film that was low-passed.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import chain

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..model import Clip, Reflection, Rejection, Shot, Span
from ..units import rescaled, samples_from_ms

LISTENING_HZ = 48_000

_QUALITY = "HQ"
_TAIL_MS = 20.0
"""The last sample is held so long, or else the filter would hear the film fall to zero; longer than any filter here."""


def resampled(clips: Iterable[Clip], rate_hz: int) -> Iterator[Clip]:
    """Yield what is heard of a film of that rate, and its sides, at `LISTENING_HZ`; as it is where that is its rate.

    The film begins and ends at rest, at its first and its last level. The last sample lies within the film, and so does
    the film's nearest one.
    """
    if rate_hz == LISTENING_HZ:
        yield from clips
        return
    from soxr import ResampleStream

    sounding = (clip for clip in clips if clip.samples.shape[0])
    first = next(sounding, None)
    if first is None:
        return
    last = rest = _columns(first.slice(Span(first.start, first.start + 1)))
    stream = ResampleStream(rate_hz, LISTENING_HZ, rest.shape[1], dtype="float32", quality=_QUALITY)
    frames = start = 0
    for clip in chain([first], sounding):
        columns = _columns(clip)
        columns -= rest
        last = columns[-1:]
        frames += columns.shape[0]
        made = stream.resample_chunk(columns)
        yield _clip(made, start)
        start += made.shape[0]
    tail = np.repeat(last, samples_from_ms(_TAIL_MS, rate_hz), axis=0)
    yield _clip(stream.resample_chunk(tail, last=True)[: _frames_within(frames, rate_hz) - start], start)


def in_film(shots: Iterable[Shot], refused: Iterable[Rejection], rate_hz: int) -> tuple[list[Shot], list[Rejection]]:
    """Return what was found at `LISTENING_HZ` with its places in the samples of a film of that rate."""
    place = partial(film_sample, rate_hz=rate_hz)
    return [shot_in_film(shot, place) for shot in shots], [
        msgspec.structs.replace(each, at_sample=place(each.at_sample)) for each in refused
    ]


def film_sample(sample: int, rate_hz: int) -> int:
    """Return the sample of a film of that rate that is nearest to one at `LISTENING_HZ`, to the end of any film.

    >>> film_sample(160, 44_100), film_sample(160, 96_000)
    (147, 320)
    """
    return rescaled(sample, LISTENING_HZ, rate_hz)


def shot_in_film(shot: Shot, place: Callable[[int], int]) -> Shot:
    """Return a shot that was found at `LISTENING_HZ` where `place` says that its samples are in the film."""
    return msgspec.structs.replace(
        shot,
        onset=place(shot.onset),
        blast=_span(shot.blast, place),
        reflections=tuple(_reflection(each, place) for each in shot.reflections),
        span=_span(shot.span, place),
    )


def _columns(clip: Clip) -> NDArray[np.float32]:
    heard = (clip.heard,) if clip.sides is None else (clip.heard, clip.sides)
    return np.stack([np.asarray(column, np.float32) for column in heard], axis=1)


def _clip(columns: NDArray[np.float32], start: int) -> Clip:
    sides = columns[:, 1] if columns.shape[1] > 1 else None
    return Clip(columns[:, :1], LISTENING_HZ, start, sides)


def _frames_within(frames: int, rate_hz: int) -> int:
    """Return how many samples begin no later than the film's last one, and end no later than the film; at least one."""
    return max(1, min((frames - 1) * LISTENING_HZ // rate_hz + 1, frames * LISTENING_HZ // rate_hz))


def _span(span: Span, place: Callable[[int], int]) -> Span:
    start = place(span.start)
    return Span(start, max(place(span.stop), start + bool(span)))


def _reflection(echo: Reflection, place: Callable[[int], int]) -> Reflection:
    span = _span(echo.span, place)
    return msgspec.structs.replace(echo, start=span.start, stop=span.stop)

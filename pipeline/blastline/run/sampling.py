"""A sample of a film: a few seconds from every part of it in one short file, and what reading the film takes."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import numpy as np
from numpy.typing import NDArray

from .. import dsp
from ..errors import SoundtrackError
from ..model import Source
from ..soundtrack import Soundtrack, write_excerpt
from ..units import samples_from_ms
from .listening import BLOCK

STRETCH_FRAMES = 12 * BLOCK
"""What is taken from one place: a scene rather than a moment, since shots come in company."""

TIMED_FRAMES = 4 * BLOCK
TIMED_SHARE, TIMED_S = 0.1, 72.0
"""Each tier is timed over a tenth of the film, but no more than 72 s, in pieces of a few seconds from all over it."""

COUNTED_S, LEAST_COUNTED_S, LONG_S = 720.0, 360.0, 2400.0
"""What a run costs depends most on how many shots there are: they are counted, once, in 720 s of a film.

In one of 40 minutes and more, which has more of them, 360 s tell as well."""

LEAST_S = 12.0

_JOIN_MS = 20.0
_HASHED_BYTES = 8 << 20


@dataclass(frozen=True)
class Sampled:
    """A sample of a film of `film_s` seconds: stretches of it in one file of so many `seconds`.

    `has_sides` says that the film is listened to twice where a tier asks for it, and the sample is not.
    Every `stride`th few seconds of it make a shorter sample. `source` is the film's; `loudest` the sample's loudest
    frame; `decode_per_s` the CPU seconds that decoding a second of the film takes, `hash_s` those of its digest.
    """

    path: Path
    seconds: float
    stride: int
    loudest: int
    film_s: float
    source: Source
    has_sides: bool
    decode_per_s: float
    hash_s: float


def timed_s(film_s: float) -> float:
    """Return over how many seconds of a film each tier is timed.

    >>> [round(timed_s(minutes * 60.0)) for minutes in (0.1, 1, 10, 120)]
    [6, 12, 60, 72]
    """
    return min(film_s, max(LEAST_S, min(TIMED_S, TIMED_SHARE * film_s)))


def counted_s(film_s: float) -> float:
    """Return in how many seconds of a film its shots are counted.

    >>> [round(counted_s(minutes * 60.0)) for minutes in (1, 10, 20, 30, 120)]
    [60, 600, 720, 480, 360]
    """
    shorter_s = COUNTED_S * min(1.0, 0.5 * LONG_S / film_s)
    return min(film_s, max(LEAST_COUNTED_S, shorter_s))


def sampled(film: Path, track: Soundtrack, path: Path, *, counted: bool) -> Sampled:
    """Take stretches from the middle of equal parts of the film, enough to time or also to count, and write them.

    Raises SoundtrackError for a film that cannot be read, or whose length nothing tells.
    """
    film_s = track.expected_s
    if not film_s:
        raise SoundtrackError(f"{film}: does not say how long it is, so no budget can be kept; give a --quality")
    frames = STRETCH_FRAMES if counted else TIMED_FRAMES
    stretch_s = frames / track.rate_hz
    wanted_s = counted_s(film_s) if counted else timed_s(film_s)
    parts = max(1, round(wanted_s / stretch_s))
    track.near(0.0, stretch_s)  # whatever is imported or set up on the way
    began = process_time()
    stretches = [
        track.near(max(0.0, (part + 0.5) * film_s / parts - stretch_s / 2.0), stretch_s)[:frames, 0]
        for part in range(parts)
    ]
    decode_s = process_time() - began
    samples = _joined([stretch for stretch in stretches if stretch.size], track.rate_hz)
    if not samples.size:
        raise SoundtrackError(f"{film}: no sound could be read at any of {parts} places; give a --quality")
    seconds = samples.size / track.rate_hz
    write_excerpt(path, samples, track.rate_hz)
    return Sampled(
        path,
        seconds,
        stride=max(1, round(seconds / timed_s(film_s))),
        loudest=int(np.argmax(np.abs(samples))),
        film_s=film_s,
        source=track.described(),
        has_sides=track.has_sides,
        decode_per_s=decode_s / seconds,
        hash_s=_cpu_of_hashing(film),
    )


def _joined(stretches: Sequence[NDArray[np.float32]], rate_hz: int) -> NDArray[np.float32]:
    """Return the stretches one after the other, faded where they meet, so that no step is taken for a sound."""
    fade = dsp.fade(samples_from_ms(_JOIN_MS, rate_hz)).astype(np.float32)
    joined = np.concatenate([np.zeros(0, np.float32), *stretches])
    ends = np.cumsum([stretch.size for stretch in stretches])[:-1]
    for end in ends[(ends >= fade.size) & (ends + fade.size <= joined.size)]:
        joined[end - fade.size : end] *= fade[::-1]
        joined[end : end + fade.size] *= fade
    return np.asarray(joined, np.float32)


def _cpu_of_hashing(film: Path) -> float:
    """Return what the digest of the whole file takes, from that of its beginning."""
    began = process_time()
    with film.open("rb") as file:
        start = file.read(_HASHED_BYTES)
    hashlib.sha256(start).digest()
    return (process_time() - began) * film.stat().st_size / max(1, len(start))

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
from ..model import Clip, Source
from ..soundtrack import Soundtrack, write_drive
from ..units import samples_from_ms
from .listening import BLOCK

STRETCH_FRAMES = 4 * BLOCK
"""What is taken from one place: what a decoder is asked for at a time, and long enough for a shot and its decay."""

TIMED_SHARE, TIMED_S = 0.1, 72.0
"""Each tier is timed over a tenth of the film, but no more than 72 s."""

COUNTED_SHARE, COUNTED_S = 0.5, 480.0
"""What a run costs depends most on how many shots there are: they are counted, once, in half of the film or 480 s."""

LEAST_S = 12.0

_JOIN_MS = 20.0
_HASHED_BYTES = 8 << 20


@dataclass(frozen=True)
class Sampled:
    """A sample of a film of `film_s` seconds: stretches of it in one file of so many `seconds`.

    Every `stride`th of the stretches makes a shorter sample. `source` is the film's; `loudest` the sample's loudest
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


def sample_s(film_s: float, *, counted: bool) -> float:
    """Return how many seconds of a film are sampled, for timing or also for counting its shots.

    >>> [round(sample_s(minutes * 60.0, counted=False)) for minutes in (0.1, 1, 10, 120)]
    [6, 12, 60, 72]
    """
    share, most_s = (COUNTED_SHARE, COUNTED_S) if counted else (TIMED_SHARE, TIMED_S)
    return min(film_s, max(LEAST_S, min(most_s, share * film_s)))


def sampled(film: Path, track: Soundtrack, path: Path, *, counted: bool) -> Sampled:
    """Take stretches from the middle of equal parts of the film and write them to `path`.

    Raises SoundtrackError for a film that cannot be read, or whose length nothing tells.
    """
    film_s = track.expected_s
    if not film_s:
        raise SoundtrackError(f"{film}: does not say how long it is, so no budget can be kept; give a --quality")
    stretch_s = STRETCH_FRAMES / track.rate_hz
    parts, timed = (max(1, round(sample_s(film_s, counted=each) / stretch_s)) for each in (counted, False))
    track.near(0.0, stretch_s)  # whatever is imported or set up on the way
    began = process_time()
    stretches = [
        track.near(max(0.0, (part + 0.5) * film_s / parts - stretch_s / 2.0), stretch_s)[:STRETCH_FRAMES, 0]
        for part in range(parts)
    ]
    decode_s = process_time() - began
    samples = _joined([stretch for stretch in stretches if stretch.size], track.rate_hz)
    if not samples.size:
        raise SoundtrackError(f"{film}: no sound could be read at any of {parts} places; give a --quality")
    seconds = samples.size / track.rate_hz
    write_drive(path, [Clip(samples[:, None], track.rate_hz)], rate_hz=track.rate_hz, frames=samples.size)
    return Sampled(
        path,
        seconds,
        stride=-(-parts // timed),
        loudest=int(np.argmax(np.abs(samples))),
        film_s=film_s,
        source=track.described(),
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
    return np.asarray(np.clip(joined, -1.0, 1.0), np.float32)


def _cpu_of_hashing(film: Path) -> float:
    """Return what the digest of the whole file takes, from that of its beginning."""
    began = process_time()
    with film.open("rb") as file:
        start = file.read(_HASHED_BYTES)
    hashlib.sha256(start).digest()
    return (process_time() - began) * film.stat().st_size / max(1, len(start))

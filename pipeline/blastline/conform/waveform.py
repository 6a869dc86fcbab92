"""Pieces of the two films as waveforms that can be laid over each other.

Both come at `WORK_HZ`, whatever their sample rates and speeds are: a piece of the old film is resampled by as much as
the new one runs faster.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..correlate import match_template
from ..model import HeardIn, Span
from .film import Film

WORK_HZ = 16_000
"""Shots reach higher, but codecs and dubs are not to be trusted there; a parabola finds 0.01 samples of it."""

EXACT_S = 4e-6
"""A piece that lies no further than this from where it was looked for lies there: to measure it is no more exact."""

_MARGIN_S = 0.005
_SHAPE = np.convolve([1.0, -1.0], [1.0, 4.0, 6.0, 4.0, 1.0])
"""A band around 3 kHz: lower, shots and music are loud but not sharp; higher, a parabola through samples is no peak.
Nothing of a constant is in it: a transfer with an offset sounds as one without."""

Samples = NDArray[np.float64]


@dataclass(frozen=True)
class Found:
    """How much later, in seconds of the new film, a piece lies than it was looked for, and how alike it is there.

    `likeness` is 1 for the same waveform, whichever way up.
    """

    late_s: float
    likeness: float


def piece(
    film: Film, start_s: float, length_s: float, *, scale: float = 1.0, mix: HeardIn = "mains"
) -> tuple[Samples, float]:
    """Return a piece at `WORK_HZ`, in the band that is compared, and how much later than `start_s` its first sample is.

    With `scale` the piece, and the lateness, are in the time of a film that is so much longer; `start_s` and
    `length_s` are in the time of the film that is read. What lies outside the film, or is not in the mix, is silence.
    """
    import soxr

    rate_hz = film.rate_hz
    margin = math.ceil(_MARGIN_S * rate_hz)
    first = round(start_s * rate_hz)  # not below it: whole samples apart, two films are to begin whole samples apart
    wanted = Span(first - margin, first + math.ceil(length_s * rate_hz) + 2 + margin)
    inside = wanted & Span(0, film.frames)
    samples = np.zeros(len(wanted))
    heard = film.read(inside, sides=mix == "sides").heard_in(mix) if inside else None
    if heard is not None:
        samples[inside.start - wanted.start : inside.stop - wanted.start] = heard
    # one step of the resampled piece is 1 / WORK_HZ of the new film's time
    resampled = np.asarray(soxr.resample(samples, rate_hz / scale, WORK_HZ), np.float64)
    skipped = math.floor(margin / rate_hz * scale * WORK_HZ)
    kept = resampled[skipped : skipped + math.floor(length_s * scale * WORK_HZ) + len(_SHAPE) - 1]
    begins_s = (wanted.start / rate_hz) * scale + skipped / WORK_HZ
    return np.convolve(kept, _SHAPE, "valid"), begins_s - start_s * scale


def look(
    old: Film,
    new: Film,
    *,
    old_s: float,
    new_s: float,
    before_s: float,
    after_s: float,
    scale: float,
    search_s: float,
    mix: HeardIn = "mains",
) -> Found:
    """Look in the new film, around `new_s`, for the sound from `before_s` before `old_s` to `after_s` after it.

    Lengths are in the new film's time; the old film is resampled by `scale`, and heard in a mix of its own.
    """
    pattern, ours_s = piece(old, old_s - before_s / scale, (before_s + after_s) / scale, scale=scale, mix=mix)
    around, theirs_s = piece(new, new_s - before_s - search_s, before_s + after_s + 2.0 * search_s)
    search = (len(around) - len(pattern)) // 2
    around = around[: len(pattern) + 2 * search]
    match = match_template(pattern, around)
    # sample `search` of the surroundings stands where the pattern's first sample was looked for, but for fractions
    shift_s = theirs_s - search_s + search / WORK_HZ - ours_s
    return Found(match.lag / WORK_HZ + shift_s, abs(match.correlation))

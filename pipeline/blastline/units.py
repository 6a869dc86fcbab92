"""Conversions between the units of people (seconds, decibels) and of the code (samples, gains).

The times of rules, options and timelines become samples through `samples_from_s`, so that they are rounded in one way.
"""

import math
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

SILENCE_DB = -240.0
"""What a level of exactly zero is called: below the quietest step of 32-bit audio, and finite, so JSON holds it."""

_ALL_DIGITS = 17
"""So many tell any number from every other."""


def samples_from_s(duration_s: float, rate_hz: int) -> int:
    """Return the nearest whole number of samples, halves upwards (Python's `round` goes to even).

    >>> samples_from_s(0.5, 3), samples_from_s(-0.5, 3)
    (2, -1)
    """
    return math.floor(duration_s * rate_hz + 0.5)


def nearest(value: Fraction) -> int:
    """Return the nearest whole number, halves upwards.

    >>> nearest(Fraction(1, 2)), nearest(Fraction(-1, 2))
    (1, 0)
    """
    return math.floor(value + Fraction(1, 2))


def rescaled(sample: int, from_hz: int, to_hz: int) -> int:
    """Return the sample at another rate that is nearest to one, halves upwards; whole numbers, exact in any film.

    >>> rescaled(160, 48_000, 44_100), rescaled(160, 48_000, 96_000)
    (147, 320)
    """
    return (2 * sample * to_hz + from_hz) // (2 * from_hz)


def rescaled_all(samples: NDArray[np.int64], from_hz: int, to_hz: int) -> NDArray[np.int64]:
    """Return each sample as `rescaled` does one."""
    return (2 * to_hz * samples + from_hz) // (2 * from_hz)


def samples_from_ms(duration_ms: float, rate_hz: int) -> int:
    """Return the nearest whole number of samples.

    >>> samples_from_ms(1.0, 44_100)
    44
    """
    return samples_from_s(duration_ms / 1000.0, rate_hz)


def ms_from_samples(samples: float, rate_hz: int) -> float:
    """Return the duration in milliseconds.

    >>> ms_from_samples(48, 48_000)
    1.0
    """
    return samples * 1000.0 / rate_hz


def gain_from_db(level_db: float) -> float:
    """Return the amplitude ratio of a level.

    >>> gain_from_db(20.0)
    10.0
    """
    return float(10.0 ** (level_db / 20.0))


def db_from_gain(gain: float) -> float:
    """Return the level of an amplitude ratio; zero gives `SILENCE_DB`, NaN itself.

    >>> db_from_gain(10.0), db_from_gain(0.0)
    (20.0, -240.0)
    """
    return SILENCE_DB if gain <= 0.0 else max(20.0 * math.log10(gain), SILENCE_DB)


def levels_db(gains: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the level of each amplitude ratio, as `db_from_gain` does for one."""
    return np.asarray(20.0 * np.log10(np.maximum(gains, gain_from_db(SILENCE_DB))), dtype=np.float64)


def gains_from_db(levels: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the amplitude ratio of each level, as `gain_from_db` does for one."""
    return np.asarray(10.0 ** (levels / 20.0), dtype=np.float64)


def share_text(peak: float) -> str:
    """Return a share of the limit, with as many digits as it takes to see that it is more than all of it.

    >>> share_text(4.1812), share_text(0.9996), share_text(1.0004)
    ('4.18', '1', '1.0004')
    """
    texts = (f"{peak:.{digits}g}" for digits in range(3, _ALL_DIGITS))
    return next((text for text in texts if peak <= 1.0 or float(text) > 1.0), f"{peak:.{_ALL_DIGITS}g}")

"""Which reflections of a shot count: looked for where what sounds after the blast leaves room for any."""

import numpy as np
from numpy.typing import NDArray

from ..ruleset import SegmentRules
from ..units import db_from_gain, samples_from_ms
from .reflections import discrete_reflections

_LOUDEST_DB = 3.0  # what is louder is no echo of this blast, were it clipped
_DULL_LAG_MS = 1.0 / 6.0  # hears 1 to 5 kHz best


def counting_echoes(
    wave: NDArray[np.float64], still: NDArray[np.float64], blast: int, *, rate_hz: int, rules: SegmentRules
) -> tuple[float | None, list[tuple[int, float]]]:
    """Return how loud an echo can be at most, and the lags in samples and levels in dB of those that count.

    They are looked for only where there is room for one that would; None and none where the rules do without.
    """
    least_db = rules.reflection_level_db
    if least_db is None:
        return None, []
    room_db = _echo_room_db(wave, blast, rate_hz=rate_hz, rules=rules)
    if room_db < least_db:
        return room_db, []
    found = discrete_reflections(wave, still, rate_hz=rate_hz, rules=rules)
    return room_db, _strong_enough(found, least_db, room_db)


def _echo_room_db(wave: NDArray[np.float64], blast: int, *, rate_hz: int, rules: SegmentRules) -> float:
    """Return how loud the loudest later stretch is that is as long as the blast, against the blast.

    In the difference over a sample or over a sixth of a millisecond, whichever gives more: an echo off something soft
    has lost its edge. Neither hears the slow roar that outlasts a blast.
    """
    from scipy.ndimage import uniform_filter1d

    earliest = max(blast, samples_from_ms(rules.earliest_reflection_ms, rate_hz))
    late = wave[: samples_from_ms(rules.latest_reflection_ms, rate_hz) + blast]
    room = 0.0
    for lag in (1, max(1, samples_from_ms(_DULL_LAG_MS, rate_hz))):
        heard = late.copy()
        heard[lag:] -= late[:-lag]
        power = np.square(heard, out=heard)
        first = float(power[:blast].mean())
        if power.shape[0] >= earliest + blast and first > 0.0:
            means = uniform_filter1d(power[earliest:], blast)
            inside = means[blast // 2 : blast // 2 + power.shape[0] - earliest - blast + 1]
            room = max(room, float(np.sqrt(max(0.0, inside.max()) / first)))
    return db_from_gain(room)


def _strong_enough(
    found: tuple[NDArray[np.intp], NDArray[np.float64]], least_db: float, room_db: float
) -> list[tuple[int, float]]:
    """Return the lags in samples and the levels in dB of the reflections that are strong enough to count.

    None is louder than all that sounds for as long as the blast.
    """
    levels = [(int(lag), min(db_from_gain(float(gain)), room_db)) for lag, gain in zip(*found, strict=True)]
    return [(lag, level_db) for lag, level_db in levels if least_db <= level_db <= _LOUDEST_DB]

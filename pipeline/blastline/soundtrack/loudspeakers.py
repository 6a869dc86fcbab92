"""Where the loudspeaker of each channel stands: ITU-R BS.775 and BS.2051, and for what they lack the cinema's habit.

0 in front, 90 on the right, 180 behind, -90 on the left; heights are seen from above
"""

from collections.abc import Sequence

from .mix import names_of

Azimuths = tuple[float | None, ...]

_FIXED_DEG = {
    "FL": -30.0,
    "FR": 30.0,
    "FC": 0.0,
    "FLC": -15.0,
    "FRC": 15.0,
    "BC": 180.0,
    "WL": -60.0,
    "WR": 60.0,
    "TFL": -45.0,
    "TFC": 0.0,
    "TFR": 45.0,
    "TSL": -90.0,
    "TSR": 90.0,
    "TBL": -135.0,
    "TBC": 180.0,
    "TBR": 135.0,
}
_ONE_PAIR_DEG = {"SL": -110.0, "SR": 110.0, "BL": -110.0, "BR": 110.0}
_TWO_PAIRS_DEG = {"SL": -90.0, "SR": 90.0, "BL": -135.0, "BR": 135.0}
_FEWEST = 2


def azimuths(layout: Sequence[str] | None, channels: int) -> Azimuths | None:
    """Return each channel's azimuth in degrees, None for one that has none, such as the low-frequency channel's.

    Surrounds stand at 110 degrees where there is one pair, at 90 and 135 where there are two. The whole is None where
    nothing tells what the channels are, or fewer than two have a place.
    """
    names = names_of(layout, channels)
    both = {"SL", "BL"} <= set(names) or {"SR", "BR"} <= set(names)
    places = {**_FIXED_DEG, **(_TWO_PAIRS_DEG if both else _ONE_PAIR_DEG)}
    found = tuple(places.get(name) for name in names)
    return found if sum(each is not None for each in found) >= _FEWEST else None

"""The best path along lanes, each of which is there for some steps (Viterbi).

    V(t, lane) = gain(t, lane) + max( V(t - 1, lane), max over all of V(t - 1, other) - cost of a cut )

Along no lane the gain is 0, and to leave one for none costs nothing. At each step only the lanes that are there are
looked at, usually one or two, so plain numbers are quicker than arrays, and the memory is that of the lanes.
"""

from array import array
from collections.abc import Sequence
from math import inf

import numpy as np
from numpy.typing import NDArray

NO_LINE = -1


def best_states(
    firsts: Sequence[int], gains: Sequence[NDArray[np.float32]], steps: int, *, cost: float
) -> NDArray[np.int16]:
    """Return for each step the number of the lane that the best path runs along, or `NO_LINE`.

    `gains` are of the lanes, at their steps from `firsts` on; a lane is never taken where its gain is below -`cost`.
    """
    starting: dict[int, list[int]] = {}
    for number, first in enumerate(firsts):
        starting.setdefault(first, []).append(number)
    came = [array("h", bytes(2 * len(gain))) for gain in gains]
    came_to_none = array("h", bytes(2 * steps))
    plain = [array("f", gain.astype(np.float32).tobytes()) for gain in gains]
    values: dict[int, float] = {}
    none = 0.0
    for step in range(steps):
        best, top = NO_LINE, none
        for number, value in values.items():
            if value > top or (value == top and best == NO_LINE):
                best, top = number, value
        if step in starting:
            values = dict(sorted([*values.items(), *((number, -inf) for number in starting[step])]))
        floor = top - cost
        gone = []
        for number, value in values.items():
            place = step - firsts[number]
            if place == len(plain[number]):
                gone.append(number)
                continue
            stays = value >= floor
            came[number][place] = number if stays else best
            values[number] = (value if stays else floor) + plain[number][place]
        for number in gone:
            del values[number]
        came_to_none[step] = NO_LINE if none >= top else best
        none = top
    return _followed_back(
        firsts, came, came_to_none, max(values, key=values.__getitem__, default=NO_LINE), values, none
    )


def _followed_back(
    firsts: Sequence[int],
    came: Sequence[Sequence[int]],
    came_to_none: Sequence[int],
    best: int,
    values: dict[int, float],
    none: float,
) -> NDArray[np.int16]:
    """Return the path from its last step back."""
    state = best if best != NO_LINE and values[best] >= none else NO_LINE
    path = np.empty(len(came_to_none), np.int16)
    for step in range(len(path) - 1, -1, -1):
        path[step] = state
        state = came_to_none[step] if state == NO_LINE else came[state][step - firsts[state]]
    return path

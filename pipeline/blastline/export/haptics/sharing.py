"""Pulses that sound together share the room there is: a group is weakened as a whole, so that its order stays."""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence


def together(positions: Sequence[int], position: int, length: int) -> slice:
    """Return which pulses sound at a position; `positions` are in order, a pulse lasts `length` after its own."""
    return slice(bisect_left(positions, position - length), bisect_right(positions, position))


def shared(positions: Sequence[int], amplitudes: Sequence[int], *, length: int, room: int) -> list[int]:
    """Return the amplitudes of pulses with every group scaled by one factor, so that none exceeds `room` together.

    A group is what exceeds it together, directly or through others. Scaled amplitudes are rounded down, never to 0.
    """
    groups: list[tuple[slice, int]] = []
    for position in dict.fromkeys(positions):
        group = together(positions, position, length)
        most = sum(amplitudes[group])
        if most <= room:
            continue
        if groups and group.start < groups[-1][0].stop:
            before, others = groups.pop()
            group, most = slice(before.start, group.stop), max(most, others)
        groups.append((group, most))
    kept = list(amplitudes)
    for group, most in groups:
        kept[group] = [max(1, amplitude * room // most) for amplitude in amplitudes[group]]
    return kept

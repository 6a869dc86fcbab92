"""Which sound streams of a film are heard, one or several of one channel each that are joined; how to write that.

3          the fourth stream
0-5        six streams, each of which is a channel of one sound
0-2,5,3-4  the same streams, as channels in another order
"""

import re
from collections.abc import Sequence

from .errors import RuleError

Streams = int | tuple[int, ...]

_PART = re.compile(r"(\d{1,4})(?:-(\d{1,4}))?", re.ASCII)


def parse_streams(text: str | None) -> Streams | None:
    """Return what a user wrote as the number of a stream, or those of several in order.

    Raises RuleError where that is no list of numbers, or names a stream twice.

    >>> parse_streams("0-2,5")
    (0, 1, 2, 5)
    """
    if text is None:
        return None
    numbers: list[int] = []
    for part in text.split(","):
        match = _PART.fullmatch(part.strip())
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
        if first > last:
            raise RuleError(
                f"--stream {text!r}: expected the number of a sound stream, from 0, or those of streams "
                "of one channel that are joined, such as 0-5 or 0,1"
            )
        numbers += range(first, last + 1)
    twice = next((number for number in numbers if numbers.count(number) > 1), None)
    if twice is not None:
        raise RuleError(f"--stream {text!r}: names sound stream {twice} twice")
    return numbers[0] if len(numbers) == 1 else tuple(numbers)


def streams_text(streams: int | Sequence[int]) -> str:
    """Return streams as a user writes them.

    >>> streams_text((0, 1, 2, 5))
    '0-2,5'
    """
    runs: list[list[int]] = []
    for number in [streams] if isinstance(streams, int) else streams:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ",".join(str(run[0]) if len(run) == 1 else f"{run[0]}-{run[-1]}" for run in runs)

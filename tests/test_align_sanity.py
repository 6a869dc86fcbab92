"""Whether a timeline makes sense by itself: windows that are disjoint, in the film, and hold their shots."""

from collections.abc import Sequence

import msgspec
import numpy as np
import pytest

from align_films import RATE_HZ, RULES, Held, figure
from blastline.align import check_timeline
from blastline.model import Event, Window
from timelines import SHOT, timeline

FRAMES = 96_000


def shot(number: int, onset: int, start: int, stop: int) -> Event:
    return msgspec.structs.replace(
        SHOT, id=f"shot-{number}", onset_sample=onset, onset_s=onset / RATE_HZ, window=Window(start, stop, 0, 0)
    )


FIRST = shot(1, 20_000, 19_000, 30_000)


@pytest.mark.parametrize(
    ("events", "faults"),
    [
        ([FIRST, shot(2, 40_000, 30_001, 50_000)], 0),
        ([FIRST, shot(2, 40_000, 30_000, 50_000)], 0),
        ([FIRST, shot(2, 40_000, 29_999, 50_000)], 1),
        ([FIRST, shot(2, 40_000, 19_001, 50_000)], 1),
        ([FIRST, shot(2, 25_000, 19_000, 30_000)], 0),
        ([shot(2, 25_000, 19_000, 30_000), FIRST], 1),
        ([FIRST, shot(2, 90_000, 80_000, FRAMES)], 0),
        ([FIRST, shot(2, 90_000, 80_000, FRAMES + 1)], 1),
        ([FIRST, shot(2, 40_000, 40_000, 40_001)], 0),
        ([FIRST, shot(2, 40_000, 40_001, 50_000)], 1),
        ([FIRST, shot(2, 50_000, 40_000, 50_000)], 1),
        ([FIRST, shot(1, 50_000, 40_000, 60_000)], 1),
    ],
)
def test_every_sample_that_windows_share_or_that_leaves_the_film_is_a_fault(
    events: Sequence[Event], faults: int
) -> None:
    whole = timeline(*events)
    whole = msgspec.structs.replace(whole, source=msgspec.structs.replace(whole.source, frames=FRAMES))
    checks = check_timeline(whole, audio=Held(np.zeros(FRAMES), RATE_HZ), rules=RULES)
    assert figure(checks, "timeline_order") == faults
    assert [check.passed for check in checks if check.name == "timeline_order"] == [faults == 0]

"""Frames are placed by counting; what the stamps say is missing is filled, and nothing else."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from blastline.errors import SoundtrackError
from blastline.soundtrack.corrections import correction_warnings
from blastline.soundtrack.first_stamp import origin_by_others
from blastline.soundtrack.placement import Placement
from blastline.soundtrack.stamped import Gap, Overlap

RATE_HZ = 48_000
FRAME = 1024
FOREVER = 10**9
MS = Fraction(1, 1000)
SAMPLE = Fraction(1, RATE_HZ)


@dataclass(frozen=True)
class Frame:
    number: int
    pts: int | None
    samples: int = FRAME
    time_base: Fraction | None = SAMPLE


def stamped(numbers: Iterable[int], *, time_base: Fraction = SAMPLE, start: int = 0) -> list[Frame]:
    """Return the frames of these numbers, with the time stamps that a container of this time base gives them."""
    return [
        Frame(number, round((start + number * FRAME) * SAMPLE / time_base), time_base=time_base) for number in numbers
    ]


def placed(
    frames: Iterable[Frame], *, max_frames: int = FOREVER, origin: Fraction | None = None
) -> tuple[dict[int, int], Placement[Frame]]:
    """Return the sample at which each frame was put."""
    placement: Placement[Frame] = Placement(RATE_HZ, max_frames, origin)
    places, position = {}, 0
    for item in placement.place(frames):
        if isinstance(item, Frame):
            places[item.number] = position
        # what is cut off the front of a frame would have lain before its place
        position += -item.samples if isinstance(item, Overlap) else item.samples
    return places, placement


def unstamped(frames: list[Frame], numbers: Iterable[int]) -> list[Frame]:
    without = set(numbers)
    return [Frame(f.number, None if f.number in without else f.pts, time_base=f.time_base) for f in frames]


@pytest.mark.parametrize("time_base", [SAMPLE, MS, Fraction(1, 90_000)])
@given(lost=st.sets(st.integers(1, 97), max_size=20), start=st.integers(0, 10**7))
def test_every_frame_stays_in_its_place_whatever_is_lost(time_base: Fraction, lost: set[int], start: int) -> None:
    there = [number for number in range(100) if number not in lost]
    places, placement = placed(stamped(there, time_base=time_base, start=start))
    assert places == {number: number * FRAME for number in there}
    assert sum(gap for _, gap in placement.gaps) == len(lost) * FRAME
    assert not placement.jumps


@pytest.mark.parametrize("time_base", [SAMPLE, MS])
def test_frames_without_a_stamp_follow_and_the_loss_is_filled_where_the_stamps_resume(time_base: Fraction) -> None:
    there = [number for number in range(30) if number != 14]
    places, placement = placed(unstamped(stamped(there, time_base=time_base), [11, 12, 13]))
    assert places == {number: number * FRAME for number in there}
    assert placement.gaps == [(14 * FRAME, FRAME)]


def test_the_frame_that_confirms_a_gap_may_come_after_some_without_a_stamp() -> None:
    there = [number for number in range(30) if number != 14]
    places, placement = placed(unstamped(stamped(there), [16, 17, 18]))
    assert places == {number: number * FRAME for number in there}
    assert placement.gaps == [(14 * FRAME, FRAME)]


def test_rounded_stamps_never_add_up() -> None:
    places, placement = placed(stamped(range(20_000), time_base=MS))
    assert places == {number: number * FRAME for number in range(20_000)}
    assert not placement.gaps
    assert not placement.jumps


def test_frames_without_any_stamp_follow_one_another() -> None:
    places, placement = placed(unstamped(stamped(range(500)), range(500)))
    assert places == {number: number * FRAME for number in range(500)}
    assert not placement.gaps


@pytest.mark.parametrize("wild", [10**7, -(10**7), 300])
def test_one_wild_stamp_moves_nothing(wild: int) -> None:
    frames = stamped(range(50))
    frames[20] = Frame(20, 20 * FRAME + wild)
    places, placement = placed(frames)
    assert places == {number: number * FRAME for number in range(50)}
    assert not placement.gaps
    assert not placement.jumps


@pytest.mark.parametrize("time_base", [SAMPLE, MS, Fraction(1, 90_000)])
@pytest.mark.parametrize("wild_s", [1491, 3, -3, -1491])
def test_the_wild_stamp_of_several_frames_moves_nothing(time_base: Fraction, wild_s: int) -> None:
    """In a transport stream it may be that of half a second of sound."""
    frames = stamped(range(200), time_base=time_base)
    for number in range(20, 43):
        frames[number] = replace(frames[number], pts=(frames[number].pts or 0) + round(wild_s / time_base))
    places, placement = placed(frames)
    assert places == {number: number * FRAME for number in range(200)}
    assert (placement.gaps, placement.jumps) == ([], [])


@pytest.mark.parametrize("time_base", [SAMPLE, MS])
def test_a_long_gap_is_filled_where_a_second_of_sound_confirms_it(time_base: Fraction) -> None:
    lost = range(20, 20 + 60 * RATE_HZ // FRAME)
    there = [*range(20), *range(lost.stop, lost.stop + 200)]
    places, placement = placed(stamped(there, time_base=time_base))
    assert places == {number: number * FRAME for number in there}
    assert placement.gaps == [(20 * FRAME, len(lost) * FRAME)]


def test_a_gap_of_no_whole_frame_is_taken_as_the_stamps_say() -> None:
    frames = stamped(range(10)) + [Frame(f.number, (f.pts or 0) + 500) for f in stamped(range(10, 20))]
    places, placement = placed(frames)
    assert places[19] == 19 * FRAME + 500
    assert placement.gaps == [(10 * FRAME, 500)]


@pytest.mark.parametrize("hours", [1, 23])
def test_a_header_that_makes_days_of_any_sound_is_refused_within_a_day(hours: int) -> None:
    """As of an AVI or CAF, whose stamps are counted by what its header says of a packet."""
    late = hours * 3600 * RATE_HZ
    frames = stamped(range(2)) + [Frame(f.number, (f.pts or 0) + late) for f in stamped(range(2, 200))]
    assert placed(frames, max_frames=10**12)[1].gaps == [(2 * FRAME, late)]
    damaged = [Frame(f.number, (f.pts or 0) + f.number * late) for f in stamped(range(2000))]
    placement: Placement[Frame] = Placement(RATE_HZ, 10**12)
    given: list[Frame | Gap | Overlap] = []
    with pytest.raises(SoundtrackError, match=r"of silence in the first .* s of sound; expected no more"):
        given.extend(placement.place(damaged))
    assert sum(item.samples for item in given if isinstance(item, Gap)) <= 24 * 3600 * RATE_HZ


@pytest.mark.parametrize(("shift", "max_frames"), [(-5 * RATE_HZ, FOREVER), (10**7, 100_000)])
def test_stamps_that_step_back_or_leave_the_film_are_overruled_once(shift: int, max_frames: int) -> None:
    frames = stamped(range(10)) + [Frame(f.number, (f.pts or 0) + shift) for f in stamped(range(10, 40))]
    places, placement = placed(frames, max_frames=max_frames)
    assert places == {number: number * FRAME for number in range(40)}
    assert placement.jumps == [(10 * FRAME, shift)]
    assert not placement.gaps


@pytest.mark.parametrize("count", [1, 2, 4])
def test_all_jumps_are_told_in_a_line_with_their_sum(count: int) -> None:
    frames = [
        Frame(f.number, (f.pts or 0) - 5 * RATE_HZ * min(f.number // 100, count))
        for f in stamped(range(100 * (count + 2)))
    ]
    [told] = correction_warnings(placed(frames)[1], 0.0, is_stamped=True)
    assert told.startswith(f"the time stamps jump by -5.000 s at {100 * FRAME / RATE_HZ:.3f} s")
    assert (
        re.findall(r", and (once|\d+ times) more, by (\S+) s in all", told)
        == {
            1: [],
            2: [("once", "-10.000")],
            4: [("3 times", "-20.000")],
        }[count]
    )


@pytest.mark.parametrize(("times", "is_wrong"), [(1.5, False), (1.9, False), (2.2, True), (100.0, True)])
def test_more_silence_than_sound_is_told_to_be_unlikely(times: float, *, is_wrong: bool) -> None:
    """As where the damaged header of an AVI or CAF has each packet last that many times as long."""
    frames = [Frame(f.number, round((f.pts or 0) * times)) for f in stamped(range(1000))]
    [told] = correction_warnings(placed(frames)[1], 0.0, is_stamped=True)
    assert " were filled with silence, " in told
    assert told.endswith("its time stamps are damaged, and no shot is in its place") == is_wrong


def test_what_was_lost_before_the_first_frame_is_filled_too() -> None:
    places, placement = placed(stamped(range(3, 10), start=700), origin=700 * SAMPLE)
    assert places == {number: number * FRAME for number in range(3, 10)}
    assert placement.gaps == [(0, 3 * FRAME)]


def test_a_gap_before_the_last_frame_needs_no_second_witness() -> None:
    assert placed(stamped([0, 1, 2, 5]))[0][5] == 5 * FRAME


def test_little_is_held_back() -> None:
    taken = 0

    def frames() -> Iterable[Frame]:
        nonlocal taken
        suspect = Frame(5, 5 * FRAME + 10**6)
        for frame in [*stamped(range(5)), suspect, *unstamped(stamped(range(6, 2000)), range(2000))]:
            taken += 1
            yield frame

    placement: Placement[Frame] = Placement(RATE_HZ, FOREVER)
    for given_back, item in enumerate(placement.place(frames())):
        assert taken - given_back < 3 * RATE_HZ / FRAME
        assert not isinstance(item, Gap) or item.samples == 10**6


@pytest.mark.parametrize("time_base", [SAMPLE, MS, Fraction(1, 90_000)])
@pytest.mark.parametrize("wild", [1, 5])
@pytest.mark.parametrize("off_s", [-3600, -1, 1, 95_443])
def test_the_first_stamps_are_overruled_by_most(time_base: Fraction, wild: int, off_s: int) -> None:
    frames = stamped(range(24), time_base=time_base, start=RATE_HZ)
    assert origin_by_others(frames, RATE_HZ) is None
    first = [Frame(f.number, (f.pts or 0) + round(off_s / time_base), time_base=time_base) for f in frames[:wild]]
    found = origin_by_others([*first, *frames[wild:]], RATE_HZ)
    assert found is not None
    assert abs(found - 1) <= time_base
    assert origin_by_others([*first, *frames[wild : 2 * wild]], RATE_HZ) is None  # one against one
    assert origin_by_others(unstamped([*first, *frames[wild:]], [20]), RATE_HZ) is None

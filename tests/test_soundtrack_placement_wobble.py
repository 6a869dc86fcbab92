"""Stamps that wobble, drift, come twice or are rounded to frames: sound stays where most of them say, and whole."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from blastline.soundtrack.placement import Placement
from blastline.soundtrack.stamped import Gap, Overlap

RATE_HZ = 48_000
MS = Fraction(1, 1000)
SAMPLE = Fraction(1, RATE_HZ)
TICKS = Fraction(1, 90_000)
TIME_BASES = [SAMPLE, MS, TICKS]
MARGIN_S = 0.002


@dataclass(frozen=True)
class Frame:
    """A frame whose sound belongs at sample `start`."""

    start: int
    samples: int
    pts: int | None
    time_base: Fraction | None = SAMPLE


@dataclass(frozen=True)
class Placed:
    """Where the sound lies: (sample, where it belongs, samples) of each frame, and what was done about it."""

    pieces: list[tuple[int, int, int]]
    placement: Placement[Frame]

    def worst_s(self, *, after: int = 0) -> float:
        """Return how far from where it belongs the sound is at most, of what belongs behind sample `after`."""
        return max(abs(place - start) for place, start, _ in self.pieces if start >= after) / RATE_HZ

    def untouched(self) -> bool:
        told = self.placement
        return not (told.gaps or told.overlaps or told.jumps)


def placed(frames: Iterable[Frame]) -> Placed:
    placement: Placement[Frame] = Placement(RATE_HZ, 10**9)
    pieces, position, cut = [], 0, 0
    for item in placement.place(frames):
        if isinstance(item, Overlap):
            cut = item.samples
            continue
        if isinstance(item, Frame):
            assert cut < item.samples
            pieces.append((position, item.start + cut, item.samples - cut))
        else:
            assert not cut
        position += item.samples - cut
        cut = 0
    return Placed(pieces, placement)


def frames_of(
    late_s: Callable[[float], float], *, seconds: float, samples: int = 1024, time_base: Fraction = SAMPLE
) -> list[Frame]:
    """Return frames in one piece whose stamps are late by what a function says of their time."""
    starts = range(0, int(seconds * RATE_HZ), samples)
    return [
        Frame(start, samples, round((start / RATE_HZ + late_s(start / RATE_HZ)) / float(time_base)), time_base)
        for start in starts
    ]


def joined(pieces: Sequence[Sequence[Frame]]) -> list[Frame]:
    return [frame for piece in pieces for frame in piece]


def step(amount_s: float, every_s: float) -> Callable[[float], float]:
    return lambda time_s: amount_s * (int(time_s / every_s) % 2)


@pytest.mark.parametrize("time_base", TIME_BASES)
@pytest.mark.parametrize("amount_s", [0.0024, 0.003, 0.005, 0.0104, 0.03, -0.003, -0.03])
@pytest.mark.parametrize("every_s", [0.05, 0.4, 1.0])
@pytest.mark.parametrize("samples", [160, 1024])
def test_stamps_that_go_to_and_fro_within_two_seconds_change_nothing(
    time_base: Fraction, amount_s: float, every_s: float, samples: int
) -> None:
    done = placed(frames_of(step(amount_s, every_s), seconds=9, samples=samples, time_base=time_base))
    assert done.untouched()
    assert done.worst_s() == 0


@pytest.mark.parametrize("amount_s", [0.005, 0.0104, 0.03])
@pytest.mark.parametrize("samples", [160, 1024])
def test_stamps_that_go_to_and_fro_slowly_are_filled_for_once(amount_s: float, samples: int) -> None:
    done = placed(frames_of(step(amount_s, 5), seconds=50, samples=samples))
    assert [gap for _, gap in done.placement.gaps] == [round(amount_s * RATE_HZ)]
    assert not done.placement.overlaps
    assert not done.placement.jumps


@given(
    wobble=st.lists(st.integers(-1000, 1000), min_size=1, max_size=60),
    most_ms=st.sampled_from([1, 3, 10, 30, 100, 240]),
    stretch=st.integers(1, 200),
    samples=st.sampled_from([160, 1024, 1536, 4608]),
    time_base=st.sampled_from(TIME_BASES),
)
@example(wobble=[0, 1000], most_ms=30, stretch=150, samples=1024, time_base=SAMPLE)
def test_no_frame_is_farther_from_its_time_than_its_stamps_wobble(
    wobble: list[int], most_ms: int, stretch: int, samples: int, time_base: Fraction
) -> None:
    """At any length: each amount lasts for some frames, and all of them come again and again."""
    frames = [
        Frame(
            number * samples,
            samples,
            round(
                (Fraction(number * samples, RATE_HZ) + MS * most_ms * wobble[number // stretch % len(wobble)] / 1000)
                / time_base
            ),
            time_base,
        )
        for number in range(1500)
    ]
    done = placed(frames)
    first_s = float((frames[0].pts or 0) * time_base)  # from where the film counts
    assert max(abs(place / RATE_HZ + first_s - start / RATE_HZ) for place, start, _ in done.pieces) <= (
        most_ms / 1000 + MARGIN_S
    )
    assert not done.placement.jumps


@pytest.mark.parametrize("time_base", TIME_BASES)
@pytest.mark.parametrize("samples", [160, 1024])
@pytest.mark.parametrize(("ppm", "most_s"), [(100, 0.005), (1000, 0.006), (-100, 0.036), (-1000, 0.036)])
def test_a_clock_that_is_slow_or_fast_stays_by_its_stamps(
    time_base: Fraction, samples: int, ppm: int, most_s: float
) -> None:
    frames = frames_of(lambda time_s: time_s * ppm * 1e-6, seconds=100, samples=samples, time_base=time_base)
    done = placed(frames)
    assert max(abs(place - start * (1 + ppm * 1e-6)) for place, start, _ in done.pieces) <= most_s * RATE_HZ
    assert not done.placement.jumps


def edited(pieces: Sequence[tuple[int, int]], *, samples: int, time_base: Fraction) -> list[Frame]:
    """Return the frames of an edit list of (first sample, samples), with the stamps that FFmpeg gives them.

    It hands over whole frames, those that begin within a piece, and stamps the first with the beginning of the piece.
    """
    frames, begin = [], 0
    for start, length in pieces:
        first = -(-start // samples) * samples
        for number, place in enumerate(range(first, start + length, samples)):
            stamp = round((begin + number * samples) * SAMPLE / time_base)
            frames.append(Frame(begin + place - start, samples, stamp, time_base))
        begin += length
    return frames


@given(
    lengths=st.lists(st.integers(5_000, 60_000), min_size=2, max_size=100),
    samples=st.sampled_from([1024, 2048, 4096]),
    time_base=st.sampled_from([SAMPLE, TICKS]),
)
def test_an_edit_list_that_plays_the_film_unchanged_changes_nothing(
    lengths: list[int], samples: int, time_base: Fraction
) -> None:
    pieces, start = [], 0
    for length in lengths:
        pieces.append((start, length))
        start += length
    done = placed(edited(pieces, samples=samples, time_base=time_base))
    assert done.worst_s() <= (samples + 4) / RATE_HZ
    short = [length for length in lengths if length < 2 * samples]
    assert short or not done.placement.jumps


@pytest.mark.parametrize("samples", [1024, 1536])
def test_the_pieces_of_an_unchanged_film_stay_in_one_piece(samples: int) -> None:
    pieces = [(24_000 * number, 24_000) for number in range(200)]
    done = placed(edited(pieces, samples=samples, time_base=SAMPLE))
    assert done.untouched()
    assert done.worst_s() == 0


@pytest.mark.parametrize("samples", [1024, 1536])
def test_the_cuts_of_an_edit_list_never_add_up(samples: int) -> None:
    pieces = [(57_600 * number, 48_000) for number in range(150)]
    done = placed(edited(pieces, samples=samples, time_base=SAMPLE))
    assert done.worst_s() <= 0.032 + MARGIN_S
    assert done.placement.overlaps
    assert not done.placement.jumps


@pytest.mark.parametrize("time_base", TIME_BASES)
@pytest.mark.parametrize("samples", [512, 1024, 1536, 4608])
@pytest.mark.parametrize("again", [1, 2, 5, 8])
@pytest.mark.parametrize("places", [[100], [100, 400, 790]])
def test_a_block_that_is_there_again_is_dropped(
    time_base: Fraction, samples: int, again: int, places: list[int]
) -> None:
    frames = frames_of(lambda _: 0.0, seconds=800 * samples / RATE_HZ, samples=samples, time_base=time_base)
    bounds = [0, *places, 800]
    doubled = joined([frames[max(0, a - again if a else 0) : b] for a, b in pairwise(bounds)])
    done = placed(doubled)
    assert [start for _, start, _ in done.pieces] == [frame.start for frame in frames]
    assert done.worst_s() == 0
    assert [overlap for _, overlap in done.placement.overlaps] == [again * samples] * len(places)
    assert not done.placement.gaps
    assert not done.placement.jumps


@pytest.mark.parametrize("samples", [512, 1024])
@pytest.mark.parametrize("again_s", [0.1, 0.3, 0.45])
def test_a_block_that_a_film_begins_with_twice_is_dropped(samples: int, again_s: float) -> None:
    """So early it is no file that another was joined to."""
    frames = frames_of(lambda _: 0.0, seconds=10, samples=samples)
    done = placed([*frames[: int(again_s * RATE_HZ / samples)], *frames])
    assert [start for _, start, _ in done.pieces] == [frame.start for frame in frames]
    assert done.worst_s() == 0
    assert not done.placement.jumps


@pytest.mark.parametrize("off", [2000, 4567, 20_001])
def test_an_overlap_is_dropped_to_the_sample(off: int) -> None:
    frames = frames_of(lambda _: 0.0, seconds=5)
    moved = [Frame(frame.start - off, frame.samples, (frame.pts or 0) - off) for frame in frames]
    done = placed([*frames[:100], *moved[100:]])
    assert done.worst_s() == 0
    assert done.placement.overlaps == [(100 * 1024, off)]
    ends = [(place + samples) for place, _, samples in done.pieces]
    assert [place for place, _, _ in done.pieces][1:] == ends[:-1]


@pytest.mark.parametrize("length_s", [0.6, 1.5, 60.0])
def test_a_file_joined_to_another_is_kept_in_one_piece(length_s: float) -> None:
    first = frames_of(lambda _: 0.0, seconds=length_s)
    second = frames_of(lambda _: 0.0, seconds=10)
    done = placed([*first, *second])
    assert len(done.pieces) == len(first) + len(second)
    assert done.placement.jumps == [(1024 * len(first), -1024 * len(first))]
    assert not done.placement.gaps
    assert not done.placement.overlaps


@pytest.mark.parametrize("speed", [0.0, 0.5])
def test_stamps_that_do_not_run_on_with_the_sound_drop_none_of_it(speed: float) -> None:
    frames = frames_of(lambda time_s: -time_s * (1 - speed), seconds=60)
    done = placed(frames)
    assert len(done.pieces) == len(frames)
    assert not done.placement.overlaps
    assert not done.placement.gaps


def test_a_gap_is_filled_behind_a_joined_file_and_before_one() -> None:
    frames = frames_of(lambda _: 0.0, seconds=40)
    done = placed([*frames[:800], *frames[805:810], *frames[:400], *frames[403:800]])
    assert done.placement.gaps == [(800 * 1024, 5 * 1024), (1210 * 1024, 3 * 1024)]
    assert [jump for _, jump in done.placement.jumps] == [-810 * 1024]


@pytest.mark.parametrize("seconds", [0.1, 1.0, 20.0])
def test_a_gap_among_stamps_that_wobble_is_filled_within_their_wobble(seconds: float) -> None:
    wobbling = frames_of(step(0.008, 0.3), seconds=60)
    lost = int(seconds * RATE_HZ / 1024)
    done = placed([*wobbling[:700], *wobbling[700 + lost :]])
    assert done.worst_s() <= 0.008 + MARGIN_S
    gaps = done.placement.gaps
    assert abs(sum(gap for _, gap in gaps) - lost * 1024) <= 0.008 * RATE_HZ
    assert all(-0.3 * RATE_HZ <= position - 700 * 1024 <= 0.008 * RATE_HZ for position, _ in gaps)
    assert not done.placement.jumps


@pytest.mark.parametrize("early_s", [0.3, 5.0, 9.984])
def test_one_early_stamp_at_the_very_end_drops_and_tells_nothing(early_s: float) -> None:
    frames = frames_of(lambda time_s: -early_s if time_s > 9.98 else 0.0, seconds=10)
    assert frames[-1].pts != frames[-1].start
    assert frames[-2].pts == frames[-2].start
    done = placed(frames)
    assert len(done.pieces) == len(frames)
    assert done.untouched()


def ending(wobbles: Sequence[int], last: Sequence[int]) -> Placed:
    """Return what is placed where the stamps of three frames were late by each wobble, and then the last ones are."""
    late = {100 * count + number: wobble for count, wobble in enumerate(wobbles, start=1) for number in range(3)}
    late |= {800 - len(last) + number: off for number, off in enumerate(last)}
    return placed([Frame(number * 1024, 1024, number * 1024 + late.get(number, 0)) for number in range(800)])


@pytest.mark.parametrize("wobbles", [[480], [480, 240], [240_000, 480]])
@pytest.mark.parametrize(("last", "filled"), [(480, 0), (480 + 96, 0), (480 + 97, 480 + 97), (2 * 480, 2 * 480)])
def test_the_last_stamps_are_believed_where_they_are_off_by_more_than_stamps_were_before(
    wobbles: list[int], last: int, filled: int
) -> None:
    """To the tolerance of 2 ms, which is 96 samples; what was off so far that it was wild is no measure."""
    done = ending(wobbles, [last])
    assert sum(gap for _, gap in done.placement.gaps) == filled
    assert not done.placement.overlaps
    assert not done.placement.jumps


def test_two_early_stamps_at_the_very_end_are_believed() -> None:
    done = ending([], [-1_500, -1_500])
    assert [overlap for _, overlap in done.placement.overlaps] == [1_500]


def test_the_last_stamp_is_believed_though_the_one_before_it_wobbles() -> None:
    done = ending([480], [480, 3_000])
    assert sum(gap for _, gap in done.placement.gaps) == 3_000


def test_a_gap_keeps_its_samples_whatever_follows() -> None:
    placement: Placement[Frame] = Placement(RATE_HZ, 10**9)
    items = list(placement.place(frames_of(step(0.1, 5), seconds=10)))
    assert [item.samples for item in items if isinstance(item, Gap)] == [4800]


def test_silence_is_as_long_as_the_least_late_stamp_asks_for_and_overlaps_as_the_least_early_one() -> None:
    """So that a wobble on top of what is missing, or there twice, costs nothing."""
    late = placed(frames_of(lambda time_s: 0.0 if time_s < 5 else 0.03 if time_s < 6 else 0.005, seconds=20))
    assert [gap for _, gap in late.placement.gaps] == [240]
    assert not late.placement.overlaps
    early = placed(frames_of(lambda time_s: 0.0 if time_s < 5 else -0.1 if time_s < 6 else -0.06, seconds=20))
    assert [overlap for _, overlap in early.placement.overlaps] == [2880]
    assert not early.placement.gaps


@pytest.mark.parametrize("late", [312, -3_000, 40_000])
def test_the_last_stamp_before_a_joined_file_moves_nothing_alone(late: int) -> None:
    """The last page of an Ogg file tells where the film ends, which may be within its last frame."""
    frames = frames_of(lambda _: 0.0, seconds=20)
    last = Frame(frames[-1].start, 1024, (frames[-1].pts or 0) + late)
    done = placed([*frames[:-1], last, *frames])
    assert not done.placement.gaps
    assert not done.placement.overlaps
    assert done.placement.jumps == [(len(frames) * 1024, -len(frames) * 1024)]

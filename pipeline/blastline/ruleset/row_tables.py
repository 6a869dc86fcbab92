"""The tables of a tier on what comes again: bursts, even rows and loops, the beat of music."""

from typing import Annotated

from msgspec import Meta

from .table import Count, Difference, Ratio, Table, ascending


class BurstRules(Table, frozen=True):
    """Which shots belong together as automatic fire, and how near each other two shots can be at all.

    A burst has `fewest_shots` or more, each within `longest_gap_ms` of the one before; of two nearer each other than
    `shortest_gap_ms` one is not told. What copies an earlier shot, and is weaker by `echo_drop_db` or more, is that
    shot's echo: what lies where one of its reflections was found and has a waveform that is `echo_likeness` like its
    own, or comes up to `latest_copy_ms` after it and is `copy_likeness` like it. A row of even fire has `fewest_even`
    sounds or more, each gap within `unevenness` of the one before, peaks within `echo_drop_db` of the first; from
    `fewest_as_one` on it is believed as a whole or not at all. From `fewest_sustained` on, a row may be sustained fire
    (`sustained_threshold`), and then peaks lie within `sustained_within_db` of the first. Of an even run of more than
    `most_unsure`, half have to be sure by themselves or sustained fire. Of `fewest_even` sounds in a row and more,
    those that the mains hear as well are not judged in the sides.
    """

    shortest_gap_ms: Annotated[float, Meta(ge=2.0, le=1000.0)]
    longest_gap_ms: Annotated[float, Meta(ge=5.0, le=2000.0)]
    echo_drop_db: Difference
    latest_copy_ms: Annotated[float, Meta(ge=0.0, le=5000.0)]
    copy_likeness: Ratio
    echo_likeness: Ratio
    fewest_shots: Annotated[int, Meta(ge=2, le=10_000)]
    fewest_even: Annotated[int, Meta(ge=3, le=10_000)]
    fewest_as_one: Annotated[int, Meta(ge=3, le=10_000)]
    unevenness: Ratio
    most_unsure: Annotated[Count, Meta(le=100_000)]
    fewest_sustained: Annotated[int, Meta(ge=3, le=10_000)]
    sustained_within_db: Difference

    def __post_init__(self) -> None:
        """Refuse gaps between shots that no burst can have."""
        ascending(self, "shortest_gap_ms", "longest_gap_ms")


class RowRules(Table, frozen=True):
    """What an even row is: `fewest` sounds or more, each gap within `unevenness` of the one before.

    The gaps are `shortest_gap_ms` to `longest_gap_ms`. Steps, hammers and drums come so. A row of which fewer than half
    are sure, by themselves or as even fire, has no shots. Nor has a loop: what comes `fewest_turns` times, each time
    after the same time of up to `longest_loop_s` and with the same before it, up to `backdrop_bits` of 50, tells how
    long it is. All that turns with it is its, peaks within `loop_level_db` and sounds, in the mean, within
    `loop_sound_db`.
    """

    fewest: Annotated[int, Meta(ge=3, le=10_000)]
    shortest_gap_ms: Annotated[float, Meta(ge=2.0, le=10_000.0)]
    longest_gap_ms: Annotated[float, Meta(ge=5.0, le=30_000.0)]
    unevenness: Ratio
    fewest_turns: Annotated[int, Meta(ge=3, le=50)]
    longest_loop_s: Annotated[float, Meta(gt=0.0, le=60.0)]
    backdrop_bits: Annotated[int, Meta(ge=0, le=20)]
    loop_level_db: Difference
    loop_sound_db: Difference

    def __post_init__(self) -> None:
        """Refuse gaps that no row can have, and loops that are none: what turns faster than a row's pace is a row."""
        ascending(self, "shortest_gap_ms", "longest_gap_ms")
        if self.longest_loop_s < self.longest_gap_ms / 1000.0:
            raise ValueError(
                f"longest_loop_s = {self.longest_loop_s}: expected at least longest_gap_ms = {self.longest_gap_ms}"
            )


class BeatRules(Table, frozen=True):
    """What keeps the beat of music: no shot, however much it sounds like one.

    A beat is a grid of `shortest_ms` to `longest_ms`, on which, within `window_s`, `fewest_apart` or more lie of the
    sounds that no other one precedes as fast as a gun fires, more of them than any one even row has: those beside it
    lie there with a chance of `by_chance` at most. What lies on it to `within_ms` keeps the beat where `fewest` sounds
    or more do, and `share` or more of all that were looked at and of those apart.

    Where the phases of n sounds, without those that go on at the pace of the two before, have a resultant of R on the
    grid, with n R^2 of `alike_resultant` or more, what lies on it to `alike_within_ms` keeps the beat where those that
    are alike do: peaks within `alike_level_db` and sounds, in the mean, within `alike_sound_db`, so many of them on the
    grid that `by_chance` is their chance at most.
    """

    window_s: Annotated[float, Meta(ge=2.0, le=120.0)]
    shortest_ms: Annotated[float, Meta(ge=50.0, le=1000.0)]
    longest_ms: Annotated[float, Meta(ge=50.0, le=1000.0)]
    within_ms: Annotated[float, Meta(gt=0.0, le=20.0)]
    fewest: Annotated[int, Meta(ge=4, le=10_000)]
    fewest_apart: Annotated[int, Meta(ge=4, le=10_000)]
    share: Ratio
    alike_resultant: Annotated[float, Meta(ge=1.0, le=1000.0)]
    alike_within_ms: Annotated[float, Meta(gt=0.0, le=50.0)]
    alike_level_db: Difference
    alike_sound_db: Difference
    by_chance: Ratio

    def __post_init__(self) -> None:
        """Refuse a range of grids that is empty."""
        ascending(self, "shortest_ms", "longest_ms")

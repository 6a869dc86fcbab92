"""One struct for each table of a tier and of `scenes.toml`: its keys, units (as suffix) and allowed ranges."""

from typing import Annotated, Literal

from msgspec import Meta

from .row_tables import BeatRules, BurstRules, RowRules
from .table import Count, Positive, Ratio, Table, ascending, not_falling

LARGEST_LEVEL_DB = 40.0
"""How far the sound may be raised or lowered before it becomes vibration."""

LONGEST_DECAY_MS = 3000.0
"""How long a shot may be.

Detection keeps 3.07 s after the last place where a shot may begin, and listens for 50 ms more than a shot may last.
"""

Speed = Annotated[float, Meta(ge=0.5, le=2.0)]
"""How many times as fast as it is. Beyond an octave either way nothing was trained."""

Decay = Annotated[float, Meta(gt=0.0, le=LONGEST_DECAY_MS)]


class ScanRules(Table, frozen=True):
    """The cheap pass over the whole film that names the candidates.

    A candidate is a step of a millisecond that rises over everything in the past `history_ms`: by `jump_db` in the
    waveform's peak, by `difference_jump_db` in that of its first difference, or by `band_jump_db` in the mean of the
    two bands that rise most; a track without a jump is not looked at. In a row as even as automatic fire, `row_jump_db`
    in peak or difference is enough, if there is such a rule. Of candidates within `separation_ms` the steepest stays,
    and a lesser one 4 ms and more after it. What peaks below `floor_dbfs`, or `range_db` under the loudest within two
    seconds, is silence.
    """

    history_ms: Annotated[float, Meta(ge=5.0, le=200.0)]
    jump_db: Annotated[float, Meta(ge=1.0, le=40.0)]
    separation_ms: Annotated[float, Meta(ge=2.0, le=100.0)]
    floor_dbfs: Annotated[float, Meta(ge=-140.0, le=-20.0)]
    range_db: Annotated[float, Meta(ge=20.0, le=140.0)]
    difference_jump_db: Annotated[float, Meta(ge=1.0, le=40.0)] | None = None
    band_jump_db: Annotated[float, Meta(ge=1.0, le=40.0)] | None = None
    row_jump_db: Annotated[float, Meta(ge=0.5, le=40.0)] | None = None


class OnsetRules(Table, frozen=True):
    """Where in the waveform a candidate starts: the first sample of its rise.

    The peak is the largest sample within `search_ms` of the guess; the sound from `noise_ms` before to `after_ms` after
    it is parted in two. What lies below `floor_ratio` of the peak counts as silence.
    """

    search_ms: Annotated[float, Meta(ge=1.0, le=20.0)]
    noise_ms: Annotated[float, Meta(ge=3.0, le=50.0)]
    after_ms: Annotated[float, Meta(ge=0.5, le=10.0)]
    floor_ratio: Annotated[float, Meta(gt=0.0, lt=0.5)]


class VerifyRules(Table, frozen=True):
    """Which model tells shots from everything else, and from which probability on it is believed.

    `model` is a file in `verifier/`; so many of its `networks` judge together, and where all leave room for doubt once
    more as if the film ran at other `speeds`. What the model's gate gives less than `gate_from` is dropped; without
    that, what it gives less than the model asks. What the screen gives less than `look_from` is not looked at more
    closely, unless it makes a row of even fire with what is, and the screen gives it `row_from`, or without that as
    much as the model asks.

    A candidate is a shot from `threshold` on, or from `company_threshold` on where a shot of the first kind lies within
    `company_s`: films fire in scenes. [bursts] says how fast a gun fires: a run that fast, each of its shots reaching
    `burst_threshold`, is sure as a whole. A row of even fire is judged as one, by its odds in the mean: believed where
    they reach `even_threshold`, or those by the networks alone `even_networks_threshold`; a slower one where the
    latter reach `threshold`, from the pace of steps on, or what lies between. A fast row of `fewest_sustained` or more
    is fire, too, where they reach `report_from`, and `sustained_threshold` if each is taken for one of a burst; one of
    more than `most_unsure` only so. Two shots that fast take along their burst's other rounds, if about as loud, from
    `round_threshold` on; one that is sure by itself takes along what lies within `pair_ms` of it and is that loud from
    `pair_threshold` (and `round_threshold`) on, as the other one of a double shot.
    From `report_from` on a candidate is at least listed among the rejections. What falls by less than `least_fall_db`
    for a second is none, unless it is a round of even fire or a likely round follows: it goes on, as after a cut to
    another scene.
    """

    model: str
    networks: Annotated[int, Meta(ge=1, le=8)]
    speeds: Annotated[tuple[Speed, ...], Meta(max_length=8)]
    look_from: Ratio
    threshold: Ratio
    company_threshold: Ratio
    company_s: Annotated[float, Meta(ge=0.0, le=86_400.0)]
    burst_threshold: Ratio
    even_threshold: Ratio
    even_networks_threshold: Ratio
    round_threshold: Ratio
    pair_threshold: Ratio
    pair_ms: Annotated[float, Meta(ge=0.0, le=10_000.0)]
    report_from: Ratio
    sustained_threshold: Ratio
    least_fall_db: Annotated[float, Meta(ge=0.0, le=60.0)]
    gate_from: Ratio | None = None
    row_from: Ratio | None = None

    def __post_init__(self) -> None:
        """Refuse thresholds out of order."""
        not_falling(self, "report_from", "round_threshold", "company_threshold", "burst_threshold", "threshold")
        not_falling(self, "round_threshold", "even_threshold", "burst_threshold")


class ChannelRules(Table, frozen=True):
    """What the channels of a film tell beyond its mix.

    A shot's azimuth compares the `azimuth_ms` before its onset with as much after it, and is not told where the energy
    of no channel rises by `azimuth_rise_db`. With `sides`, what the mains of a film hold beside their middle is
    listened to as well. What is only heard there is a shot from `sides_threshold` on, or from `sides_company_threshold`
    on in company, which [verify] explains.
    """

    azimuth_ms: Annotated[float, Meta(ge=1.0, le=100.0)]
    azimuth_rise_db: Annotated[float, Meta(ge=0.0, le=60.0)]
    sides: bool
    sides_threshold: Ratio
    sides_company_threshold: Ratio

    def __post_init__(self) -> None:
        """Refuse thresholds out of order."""
        not_falling(self, "sides_company_threshold", "sides_threshold")


class SegmentRules(Table, frozen=True):
    """Where the blast ends, what counts as a reflection, and when the decay is over.

    The blast lasts until it has fallen by `blast_decay_db`, `longest_blast_ms` at most. A reflection is a copy of it
    from `earliest_reflection_ms` to `latest_reflection_ms` later, of `reflection_level_db` against it or more, that is
    `reflection_prominence` times as clear as what is around it; without that level none are looked for. The decay,
    which the window follows unless a reflection is over later, ends when the level has fallen by `decay_db`, come down
    to the background or risen again, between `shortest_ms` and `longest_ms` after the onset. All ends within 3 s:
    beyond it, a shot's parts would depend on where in the film it lies.
    """

    longest_blast_ms: Decay
    blast_decay_db: Annotated[float, Meta(gt=0.0, le=60.0)]
    earliest_reflection_ms: Positive
    latest_reflection_ms: Decay
    reflection_prominence: Annotated[float, Meta(ge=1.0, le=20.0)]
    decay_db: Annotated[float, Meta(gt=0.0, le=80.0)]
    shortest_ms: Positive
    longest_ms: Decay
    reflection_level_db: Annotated[float, Meta(ge=-60.0, le=0.0)] | None = None

    def __post_init__(self) -> None:
        """Refuse ranges that are empty."""
        ascending(self, "earliest_reflection_ms", "latest_reflection_ms")
        ascending(self, "shortest_ms", "longest_ms")


class WindowRules(Table, frozen=True):
    """How a shot's window lies around it.

    It opens over `fade_in_ms`, is whole from `guard_ms` before the onset on, and closes over the last `fade_out_ms`.
    """

    fade_in_ms: Annotated[float, Meta(ge=0.0, le=10_000.0)]
    guard_ms: Annotated[float, Meta(ge=0.0, le=10_000.0)]
    fade_out_ms: Annotated[float, Meta(ge=0.0, le=10_000.0)]


class RenderRules(Table, frozen=True):
    """How the drive is computed inside a window.

    The filters start `preroll_ms` before it, and earlier in proportion where their slowest time constant is more than
    50 ms. The sound is raised by `level_db`; what of it lies in the band of vibration is to be felt. The constrained
    drive of a shot may begin `lead_ms` before its onset, if its window is open by then. It is solved at
    `solver_rate_hz` or up to twice that, higher where the actuator answers above the band, lower where it rings on for
    very many corners, never above the soundtrack's rate, in at most `iterations` steps, until no more than `tolerance`
    of the explained energy can be gained, then at the full rate with at most `polish_iterations`; with more, 300 at
    most, where so few corners tell too little, or a window has no room for enough.
    """

    preroll_ms: Annotated[float, Meta(ge=0.0, le=60_000.0)]
    lead_ms: Annotated[float, Meta(ge=0.0, le=1000.0)]
    level_db: Annotated[float, Meta(ge=-LARGEST_LEVEL_DB, le=LARGEST_LEVEL_DB)]
    solver_rate_hz: Annotated[int, Meta(ge=4000, le=1_000_000)]
    iterations: Annotated[Count, Meta(le=10_000)]
    polish_iterations: Annotated[int, Meta(ge=0, le=10_000)]
    tolerance: Annotated[float, Meta(ge=1e-12, lt=1.0)]


class QualityRules(Table, frozen=True):
    """`quality/*.toml`: the detection and rendering settings of a tier."""

    schema: Literal[1]
    scan: ScanRules
    onset: OnsetRules
    verify: VerifyRules
    channels: ChannelRules
    segment: SegmentRules
    bursts: BurstRules
    rows: RowRules
    beat: BeatRules
    windows: WindowRules
    render: RenderRules


class SceneRules(Table, frozen=True):
    """`scenes.toml`: what a scene requires, hence which drive model `--drive auto` takes.

    Direct conversion is enough where its predicted perceived level is within `direct_level_db` of the target and its
    waveform correlates by `direct_fidelity`; the filter is enough where its peak stays within the limit.
    """

    schema: Literal[1]
    direct_level_db: Annotated[float, Meta(ge=0.0, le=200.0)]
    direct_fidelity: Ratio

"""The rules by which drive and film count as aligned."""

from typing import Annotated, Literal

from msgspec import Meta

from .table import Level, NonNegative, Positive, Ratio, Table


class AlignRules(Table, frozen=True):
    """`align.toml`: what an alignment check's figure has to stay within.

    A shot is searched for in the drive by at most `longest_ms` from its onset on, within `search_ms`. What
    is felt lags what is heard by `lag_causal_ms` at most, `lag_zero_samples` with `--phase zero`; it begins within
    `onset_error_ms` of where it is due, and no earlier than that before the lead that [render] gives the drive.

    A drive that does not compensate has to reach `correlation` with its sound; any other the fidelity that was
    predicted when it was rendered, less `correlation_loss`, and at least `least_correlation`; where less was predicted,
    its figures are listed without a limit. One that reaches its fidelity within `fidelity_error` where it is due is
    there. Its level is within `level_error_db` of that recorded, its peak within `peak_error_db`. In no stretch of
    10 ms does it depart from what is due by more than `departure` of that, `departure_solved` where it is the best
    within the limit. Of that, what lies above the band beside the compensator's drive is at most `above_band` of it in
    a stretch far from the limit. Before the shot, up to `preecho_guard_ms` before its onset, nothing is felt over
    `preecho_db` of its peak or, if more, `preecho_margin_db` over what is due there. No sample exceeds `peak`, 1 being
    the actuator's limit.

    Without a drive, the film's sound has to rise by `rise_db` at a shot that was found and is the first of its window;
    with one, a shot set by hand is held to its sound where that rises by `hand_rise_db`. From the first shot to the
    last the drive is within `shift_samples` of its place, and drifts by no more than `drift_samples`.
    """

    schema: Literal[1]
    longest_ms: Annotated[float, Meta(ge=20.0, le=2000.0)]
    search_ms: Annotated[float, Meta(ge=2.0, le=100.0)]
    onset_error_ms: Positive
    lag_causal_ms: Positive
    lag_zero_samples: Positive
    correlation: Ratio
    correlation_loss: Ratio
    least_correlation: Ratio
    fidelity_error: Ratio
    level_error_db: Positive
    peak_error_db: Positive
    departure: Positive
    departure_solved: Positive
    above_band: Positive
    preecho_db: Level
    preecho_margin_db: NonNegative
    preecho_guard_ms: Annotated[float, Meta(ge=0.0, le=1000.0)]
    peak: Positive
    rise_db: NonNegative
    hand_rise_db: NonNegative
    shift_samples: NonNegative
    drift_samples: NonNegative

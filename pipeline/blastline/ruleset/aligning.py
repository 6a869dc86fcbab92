"""The rules by which drive and film count as aligned."""

from typing import Annotated, Literal

from msgspec import Meta

from .tables import Level, NonNegative, Positive, Ratio, Table


class AlignRules(Table, frozen=True):
    """`align.toml`: what an alignment check's figure has to stay within.

    A shot is compared over at most `longest_ms` from its onset, and searched for in the drive within `search_ms`. A
    drive that does not compensate has to reach `correlation` with its sound; any other the fidelity that was predicted
    when it was rendered, less `correlation_loss`, and at least `least_correlation`.
    """

    schema: Literal[1]
    longest_ms: Annotated[float, Meta(ge=20.0, le=2000.0)]
    search_ms: Annotated[float, Meta(ge=2.0, le=100.0)]
    lead_ms: NonNegative
    onset_error_ms: Positive
    lag_causal_ms: Positive
    lag_zero_samples: Positive
    correlation: Ratio
    correlation_loss: Ratio
    least_correlation: Ratio
    level_error_db: Positive
    preecho_db: Level
    preecho_margin_db: NonNegative
    preecho_guard_ms: NonNegative
    peak: Positive
    rise_db: NonNegative
    hand_rise_db: NonNegative
    shift_samples: NonNegative
    drift_samples: NonNegative

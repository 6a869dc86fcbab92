"""The rules by which a shot counts as heard in a new cut of its film."""

from typing import Annotated, Literal

from msgspec import Meta

from .table import Positive, Ratio, Table


class ConformRules(Table, frozen=True):
    """`conform.toml`.

    A shot is compared from `before_ms` before its onset to `after_ms` after it, `close_ms` around its course, then
    `far_ms` around it. It has to reach `least`; `least_parted` where its course is far, `least_short` where less than
    `shortest_ms` are compared, `least_far` off the course. Where the pitch was kept at another speed, its first
    `attack_ms` are looked for within `kept_pitch_ms`, have to reach `least_kept_pitch`, and nothing further off than
    `rival_ms` may be alike by less than `rival_less` less. Shots up to `reach_s` outside a stretch are tried on it.
    """

    schema: Literal[1]
    before_ms: Annotated[float, Meta(ge=0.0, le=100.0)]
    after_ms: Annotated[float, Meta(ge=20.0, le=2000.0)]
    shortest_ms: Annotated[float, Meta(ge=10.0, le=500.0)]
    attack_ms: Annotated[float, Meta(ge=5.0, le=100.0)]
    close_ms: Annotated[float, Meta(gt=0.0, le=10.0)]
    far_ms: Annotated[float, Meta(gt=0.0, le=100.0)]
    least: Ratio
    least_parted: Ratio
    least_short: Ratio
    least_far: Ratio
    kept_pitch_ms: Annotated[float, Meta(ge=2.0, le=100.0)]
    least_kept_pitch: Ratio
    rival_ms: Positive
    rival_less: Ratio
    reach_s: Annotated[float, Meta(ge=0.0, le=10.0)]

    def __post_init__(self) -> None:
        """Refuse a rival nearer than any that is looked for."""
        if self.rival_ms >= self.kept_pitch_ms:
            raise ValueError(f"rival_ms = {self.rival_ms:g}: expected less than kept_pitch_ms = {self.kept_pitch_ms:g}")

"""A table of a rule file: what every one has, the ranges that keys have in common, and how keys are compared.

Every table carries `source`, which says where its numbers come from: a paper, a measurement or a study run.
"""

from typing import Annotated

import msgspec
from msgspec import Meta

_LARGEST = 1e6  # more of anything that a rule counts in is a slip of the keyboard
Positive = Annotated[float, Meta(gt=0.0, le=_LARGEST)]
NonNegative = Annotated[float, Meta(ge=0.0, le=_LARGEST)]
Ratio = Annotated[float, Meta(ge=0.0, le=1.0)]
Level = Annotated[float, Meta(ge=-200.0, le=200.0)]
Difference = Annotated[float, Meta(ge=0.1, le=60.0)]
Count = Annotated[int, Meta(ge=1)]
LEAST_SOURCE = 3
Source = Annotated[str, Meta(min_length=LEAST_SOURCE)]


class Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A table of a rule file: unknown and missing keys are errors."""

    source: Source


def ascending(table: Table, low: str, high: str) -> None:
    """Refuse a table of which one key is not less than another; ValueError, of which the reader tells the place."""
    if getattr(table, low) >= getattr(table, high):
        raise ValueError(f"{low} = {getattr(table, low)}: expected less than {high} = {getattr(table, high)}")


def not_falling(table: Table, *names: str) -> None:
    """Refuse a table whose keys are not in ascending order; ValueError."""
    values = [getattr(table, name) for name in names]
    if values != sorted(values):
        raise ValueError(f"{', '.join(names)} = {', '.join(map(str, values))}: expected ascending values")

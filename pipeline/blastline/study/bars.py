"""A measured figure beside the bar that it is held to, as the studies print it."""

from collections.abc import Callable
from typing import Literal, SupportsFloat

import msgspec

from ..errors import BlastlineError, OutputError

Better = Literal["below", "above", "equal"]


class Bar(msgspec.Struct, frozen=True):
    """A measured figure and the limit it is held to: at most, at least, or exactly."""

    name: str
    measured: float
    limit: float
    unit: str = ""
    better: Better = "below"

    @property
    def margin(self) -> float:
        """Return how far on the right side of the limit the figure lies; negative where it fails."""
        if self.better == "equal":
            return -abs(self.measured - self.limit)
        return self.limit - self.measured if self.better == "below" else self.measured - self.limit

    @property
    def met(self) -> bool:
        """Return whether the bar is met; by a NaN never."""
        return self.margin >= 0.0

    def __str__(self) -> str:
        """Return a line of a table: name, measured, limit, margin, unit, and whether the bar is met."""
        sign = {"below": "<=", "above": ">=", "equal": "= "}[self.better]
        figures = f"{self.measured:11.4g} {sign} {self.limit:<8.4g} {self.margin + 0.0:10.3g}"
        return f"{self.name:<66} {figures} {self.unit:<13} {'met' if self.met else 'MISSED'}"


def exact(name: str, wrong: SupportsFloat, unit: str = "samples") -> Bar:
    """Return a bar on what is wrong, where nothing may be."""
    return Bar(name, float(wrong), 0.0, unit, "equal")


def refused(name: str, ask: Callable[[], object], kind: type[Exception] = BlastlineError) -> Bar:
    """Return whether an input ends in an error of its kind, in a single line. Raises OutputError for a full disk."""
    try:
        ask()
    except OutputError:  # says nothing of the input
        raise
    except kind as error:
        return exact(f"refused: {name}", int(len(str(error).splitlines()) != 1), "missing")
    return exact(f"refused: {name}", 1, "missing")

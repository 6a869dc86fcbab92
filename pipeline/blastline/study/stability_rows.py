"""One row of the stability table, and what it takes to hold."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, SupportsFloat

from ..errors import BlastlineError

Better = Literal["below", "above", "equal"]


@dataclass(frozen=True)
class Row:
    """A measured figure and the bar it is held to: at most, at least, or exactly."""

    name: str
    measured: float
    bar: float
    unit: str = ""
    better: Better = "below"

    @property
    def margin(self) -> float:
        """Return how far on the right side of the bar the figure lies; negative where it fails."""
        if self.better == "equal":
            return -abs(self.measured - self.bar)
        return self.bar - self.measured if self.better == "below" else self.measured - self.bar

    @property
    def ok(self) -> bool:
        """Return whether the row holds; a NaN never does."""
        return self.margin >= 0.0


def exact(name: str, wrong: SupportsFloat, unit: str = "samples") -> Row:
    """Return a row that counts what is wrong where nothing may be."""
    return Row(name, float(wrong), 0.0, unit, "equal")


def refused(name: str, ask: Callable[[], object], kind: type[Exception] = BlastlineError) -> Row:
    """Return whether an input ends in an error of its kind, in a single line."""
    try:
        ask()
    except kind as error:
        return exact(f"refused: {name}", int(len(str(error).splitlines()) != 1), "missing")
    return exact(f"refused: {name}", 1, "missing")

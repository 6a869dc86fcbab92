"""What a tier takes of the CPU: the parts of which a prediction is made up."""

from dataclasses import dataclass

from ..report import MAX_FIGURES
from .listening import HeardFilm


@dataclass(frozen=True)
class FilmCost:
    """The CPU seconds of a tier: fixed, per second of film, per shot, per picture of the report; and how many shots."""

    fixed_s: float
    per_second: float
    per_shot: float = 0.0
    per_picture: float = 0.0
    shots_per_s: float = 0.0

    def of(self, film_s: float) -> float:
        """Return the CPU seconds for a film of so many seconds."""
        shots = self.shots_per_s * film_s
        pictures = min(shots, MAX_FIGURES)
        return self.fixed_s + self.per_second * film_s + self.per_shot * shots + self.per_picture * pictures


@dataclass(frozen=True)
class AfterDetection:
    """The CPU seconds of what follows detection: the drive, its checks and the timeline's files, and the report."""

    drive_s: float
    checks_s: float
    report_s: float

    @property
    def made_s(self) -> float:
        """Return what all of it takes but the report."""
        return self.drive_s + self.checks_s


@dataclass(frozen=True)
class LinearCost:
    """The CPU seconds that something takes once, and for each of what it is done to."""

    fixed_s: float
    each_s: float


@dataclass(frozen=True, eq=False)
class SharedCosts:
    """What is the same for all tiers: what is heard, and the CPU seconds of a film without shots and of pictures.

    The first picture takes `axes_s` more than the others.
    """

    heard: HeardFilm
    empty: AfterDetection
    axes_s: float
    picture_s: float

"""Choosing the quality by what may be spent: the most accurate tier that fits a budget of CPU time.

`--budget 2min` or `--max-cost 0.01`  ->  excerpts of the film, run through each tier (`gauge`)  ->  the tier
"""

import math
import re
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from .. import model
from ..errors import RuleError
from ..model import Quality
from ..progress import Progress, no_progress
from .costs import FilmCost
from .gauge import open_gauge
from .options import RenderOptions

BEST_FIRST: tuple[Quality, ...] = ("reference", "standard", "draft")

RESERVE = 1.1
"""What a tier is predicted to take, times this, has to fit: predictions are off either way; see docs/scene.md."""

_LARGEST = 1e9
"""More CPU time than that, 32 years, or so much for a second of film, is a slip of the keyboard."""

_TOLD = 40  # characters of an option that a message repeats

_UNITS_S = {"": 1.0, "s": 1.0, "min": 60.0, "h": 3600.0}


@dataclass(frozen=True)
class Allowance:
    """What may be spent: CPU seconds for the film, or for each second of it; `asked` is the option as it was given."""

    asked: str
    cpu_s: float | None = None
    cpu_per_s: float | None = None

    def of(self, film_s: float) -> float:
        """Return the CPU seconds for a film of so many seconds."""
        return self.cpu_s if self.cpu_s is not None else (self.cpu_per_s or 0.0) * film_s

    def in_words(self, cpu_s: float, film_s: float) -> str:
        """Return the option that would allow so many CPU seconds, rounded up to two digits."""
        if self.cpu_s is not None:
            return f"--budget {_up(cpu_s):g}s"
        return f"--max-cost {_up(cpu_s / film_s):g}"


def allowance(*, budget: str | None, max_cost: float | None, quality: Quality | None) -> Allowance | None:
    """Return what the options allow, None where neither is given; RuleError where they make no sense, or not together.

    >>> allowance(budget="1.5min", max_cost=None, quality=None).cpu_s
    90.0
    """
    given = [name for name, value in (("--budget", budget), ("--max-cost", max_cost)) if value is not None]
    if not given:
        return None
    if len(given) == 2:
        raise RuleError("--budget and --max-cost: expected one of them, not both")
    if quality is not None:
        raise RuleError(f"--quality {quality} and {given[0]}: expected one of them; a budget chooses the quality")
    if budget is not None:
        return Allowance(f"--budget {budget}", cpu_s=_seconds(budget))
    if max_cost is None or not 0.0 < max_cost <= _LARGEST:
        raise RuleError(
            f"--max-cost {max_cost:g}: expected CPU seconds per second of film, more than 0, up to {_LARGEST:g}, "
            "such as 0.01"
        )
    return Allowance(f"--max-cost {max_cost:g}", cpu_per_s=max_cost)


def _seconds(text: str) -> float:
    found = re.fullmatch(r"\s*(\d+\.?\d*|\.\d+)\s*(s|min|h|)\s*", text, re.ASCII)
    seconds = float(found[1]) * _UNITS_S[found[2]] if found else 0.0
    if not 0.0 < seconds <= _LARGEST:
        raise RuleError(
            f"--budget {text[:_TOLD]}: expected a CPU time of more than 0, up to {_LARGEST:.0f} s, such as 90s or 1.5h"
        )
    return seconds


def choose_quality(
    film: Path,
    allowed: Allowance,
    options: RenderOptions,
    *,
    drives: bool = True,
    since_cpu_s: float | None = None,
    progress: Progress = no_progress,
) -> RenderOptions:
    """Return the options with the most accurate quality that fits the budget, and with how it was chosen.

    Each tier, the most accurate first, is run over excerpts of the film on this machine, and its CPU time for the whole
    film predicted from that, until the budget is spent: then the fastest is, to tell what would do. `drives` says
    whether the film will be rendered or its shots only found; the budget counts from the process's CPU time
    `since_cpu_s` on, now where it is None. Raises RuleError where no quality fits.
    """
    if options.timeline is not None:
        raise RuleError(f"{allowed.asked} with --timeline {options.timeline}: nothing is detected; give a --quality")
    began = time.process_time() if since_cpu_s is None else since_cpu_s
    predicted: dict[Quality, float] = {}
    with open_gauge(film, options, drives=drives, progress=progress) as gauge:
        allowed_s = allowed.of(gauge.film_s)

        def spent_s() -> float:
            return time.process_time() - began

        def predict(quality: Quality) -> float:
            cost: FilmCost = gauge.cost(quality)
            predicted[quality] = spent_s() + cost.of(gauge.film_s)
            return predicted[quality]

        picked = pick(predict, allowed_s, spent_s)
        if picked is None:
            raise RuleError(_too_little(allowed, predicted, film, film_s=gauge.film_s, spent_s=spent_s()))
    note = chosen(allowed, allowed_s, picked, predicted)
    return replace(options, quality=picked, budget=model.Budget(allowed.asked, allowed_s, predicted, note))


def pick(predict: Callable[[Quality], float], allowed_s: float, spent_s: Callable[[], float]) -> Quality | None:
    """Return the most accurate quality whose prediction, with the reserve, fits; None where none does.

    Predictions are asked for from the most accurate quality on, and no further than needed: where predicting has
    already spent what is allowed, only for the fastest, to tell what would do.
    """
    for quality in BEST_FIRST:
        if quality != BEST_FIRST[-1] and RESERVE * spent_s() > allowed_s:
            continue
        if RESERVE * predict(quality) <= allowed_s:
            return quality
    return None


def chosen(allowed: Allowance, allowed_s: float, picked: Quality, predicted: dict[Quality, float]) -> str:
    """Return in one line what was picked, what it is expected to take, and what was given up for it."""
    line = f"{allowed.asked}: quality {picked}, about {said(predicted[picked])} of the {said(allowed_s)} of CPU allowed"
    dearer = [quality for quality in reversed(BEST_FIRST) if quality in predicted and quality != picked]
    if not dearer:
        return f"{line}; nothing more accurate was given up"
    return f"{line}; given up: " + ", ".join(f"{quality}, about {said(predicted[quality])}" for quality in dearer)


def _too_little(
    allowed: Allowance, predicted: dict[Quality, float], film: Path, *, film_s: float, spent_s: float
) -> str:
    """Return in a line that no quality fits, by how much, and which option would do."""
    needed = allowed.in_words(RESERVE * predicted["draft"], film_s)
    if len(predicted) < len(BEST_FIRST):
        needed += ", and what measuring the other qualities takes,"
    return (
        f"{allowed.asked}: allows {said(allowed.of(film_s))} of CPU for the {_length(film_s)} of {film}, but "
        f"draft, the fastest quality, takes about {said(predicted['draft'])}, of which measuring this was "
        f"{said(spent_s)}, and a tenth is kept in reserve; {needed} would do, and --quality draft measures nothing"
    )


def said(seconds: float) -> str:
    """Return a CPU time for people.

    >>> said(0.25), said(12.34), said(90.0), said(5400.0)
    ('0.25 s', '12.3 s', '1.5 min', '1.5 h')
    """
    for unit, length in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 1.5 * length:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds:.3g} s"


def _length(seconds: float) -> str:
    return f"{seconds / 60.0:.3g} minutes" if seconds >= 90.0 else f"{seconds:.3g} seconds"


def _up(value: float) -> float:
    """Return a number rounded up to two digits.

    >>> _up(121.0), _up(0.0302), _up(9.0)
    (130.0, 0.031, 9.0)
    """
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.ceil(value / step) * step:.6g}")

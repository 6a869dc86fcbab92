"""Numbers at the extremes: each row is measured against an independent reference and held to a bar.

    filters       the response of the rounded sections, and what they do to samples, against mpmath
    signals       amplitudes, denormals, silence, DC, impulses, a full-scale square
    windows       one sample, touching, overlapping, past the ends; blocks of any size
    files         NaN and infinity, a day of stream, counters beyond 2^31
    solver        nothing to follow, and far more than the limit
    measurements  an actuator's response as measured: empty, notched, noisy, uncorrelated
    refusals      what has no meaningful answer, refused in one line

A family is a function that makes its rows, and may use a folder for its files; to add one, name it in `families`.
"""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path

import msgspec

from ..errors import RuleError
from .bars import Bar

Family = Callable[[Path], Iterator[Bar]]


def families() -> dict[str, Family]:
    """Return the families of rows by name, in the order of the table."""
    from .stability_files import file_rows
    from .stability_filters import filter_rows
    from .stability_measurements import measurement_rows
    from .stability_refusals import refusal_rows
    from .stability_signals import signal_rows
    from .stability_solver import solver_rows
    from .stability_windows import window_rows

    return {
        "filters": filter_rows,
        "signals": signal_rows,
        "windows": window_rows,
        "files": file_rows,
        "solver": solver_rows,
        "measurements": measurement_rows,
        "refusals": refusal_rows,
    }


def measure_stability() -> Iterator[tuple[str, Bar]]:
    """Yield every row with the name of its family, each as soon as it has been measured.

    Raises RuleError where mpmath, the reference, is not installed.
    """
    if find_spec("mpmath") is None:
        raise RuleError("study stability: needs mpmath as its reference; pip install 'blastline[study]'")
    for name, family in families().items():
        with tempfile.TemporaryDirectory(prefix="blastline-") as folder:
            for row in family(Path(folder)):
                yield name, row


def stability_json(bars: Sequence[tuple[str, Bar]]) -> bytes:
    """Return the table as JSON; a figure that is no number is null."""
    plain = [
        {"family": family, **msgspec.structs.asdict(bar), "margin": bar.margin, "met": bar.met} for family, bar in bars
    ]
    return msgspec.json.format(msgspec.json.encode(plain), indent=1) + b"\n"

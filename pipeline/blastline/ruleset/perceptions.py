"""Finding and reading curves of what the skin perceives: built in, in the user's rules, or a table of their own."""

from pathlib import Path

from ..errors import RuleError
from ..plurals import counted
from .columns import FREQUENCY, read_columns
from .files import builtin, convert, read_toml, rules_path
from .folder import require_folder
from .measuring import PerceptionCurve
from .table import LEAST_SOURCE

_KINDS = (".toml", ".csv")
_FEWEST_ROWS = 2


def perception_names(overlay: Path | None = None) -> list[str]:
    """Return the names of the curves that `load_perception` knows."""
    require_folder(overlay)
    folders = [builtin()] + ([overlay] if overlay else [])
    return sorted({file.stem for folder in folders for kind in _KINDS for file in folder.glob(f"perception/*{kind}")})


def load_perception(name: str, overlay: Path | None = None) -> PerceptionCurve:
    """Return a curve, by name or by the path of its .toml or .csv file.

    Raises RuleError where it does not exist or does not fit.
    """
    require_folder(overlay)
    if name.lower().endswith(_KINDS):
        path = Path(name)
    else:
        path = (overlay and own_curve(name, overlay)) or rules_path(f"perception/{name}.toml")
    if not path.is_file():
        known = ", ".join(perception_names(overlay))
        raise RuleError(f"{name}: no such perception curve; expected none, a .toml or .csv file, or one of: {known}")
    return read_curve(path)


def own_curve(name: str, overlay: Path) -> Path | None:
    """Return the user's file of a curve, None where there is none; RuleError where there are two of that name."""
    there = [path for kind in _KINDS if (path := overlay / f"perception/{name}{kind}").is_file()]
    if len(there) > 1:
        raise RuleError(f"{there[0]}: there is {there[1].name} as well; expected one file for a curve's name")
    return there[0] if there else None


def read_curve(path: Path) -> PerceptionCurve:
    """Return the curve of a file, which exists; RuleError where it does not fit.

    A CSV has the columns `frequency_hz, threshold_db`.
    """
    if path.suffix.lower() != ".csv":
        return convert(read_toml(path), PerceptionCurve, path)
    read = read_columns(path, needed=(FREQUENCY, "threshold_db"))
    rows = len(read.values[FREQUENCY])
    if rows < _FEWEST_ROWS:
        raise RuleError(f"{path}: holds {counted(rows, 'row')}; expected at least {_FEWEST_ROWS}")
    source = read.notes.get("source") or f"the user's table {path.name}"
    if len(source) < LEAST_SOURCE:
        raise RuleError(f"{path}: # source: {source!r}: expected at least {LEAST_SOURCE} characters, or no such note")
    plain = {
        "schema": 1,
        "source": source,
        "name": path.stem,
        "frequencies_hz": read.values[FREQUENCY].tolist(),
        "threshold_db": read.values["threshold_db"].tolist(),
    }
    return convert(plain, PerceptionCurve, path)

"""The floors of the house: who may import whom, who may open media, and what must not slow down the start."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

import blastline

PACKAGE = Path(blastline.__file__).parent

GROUND = {
    "__version__",
    "abandoned",
    "moving",
    "progress",
    "correlate",
    "dsp",
    "errors",
    "interruption",
    "medians",
    "misfits",
    "model",
    "plurals",
    "ruleset",
    "staging",
    "streams",
    "timebase",
    "timecode",
    "units",
}
STAGES = {"actuator", "soundtrack", "detect", "render", "align", "conform", "scene", "export", "report", "synth"}
MAY_IMPORT = (
    dict.fromkeys(GROUND, GROUND)
    | {stage: GROUND | {stage} for stage in STAGES}
    | {
        "study": GROUND | STAGES | {"study"},
        "run": GROUND | STAGES | {"run"},
        "cli": {"cli", "run", "study", "ruleset", "model", "errors", "interruption", "progress", "staging", "streams"}
        | {"plurals", "timebase", "timecode", "__version__"},
        "__main__": {"cli"},
        "__init__": set(),
    }
)
OPENS_MEDIA = {"av", "soundfile"}
MAY_OPEN_MEDIA = {"soundtrack", "study", "synth"}
HEAVY = OPENS_MEDIA | {
    "librosa",
    "matplotlib",
    "mido",
    "numba",
    "opentimelineio",
    "pandas",
    "rich",
    "scipy",
    "sklearn",
    "soxr",
    "typer",
}
HEAVY_ALLOWED = {"cli": {"typer"}}


@dataclass(frozen=True)
class Import:
    """One imported name, in full, and whether importing the file imports it."""

    name: str
    line: int
    at_start: bool


def imports(file: Path, root: Path) -> Iterator[Import]:
    """Yield every import of a file, with relative ones made absolute; `root` is the package's folder."""
    package = ["blastline", *file.relative_to(root).parent.parts]

    def visit(node: ast.AST, at_start: bool) -> Iterator[Import]:
        if isinstance(node, ast.Import):
            yield from (Import(alias.name, node.lineno, at_start) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            prefix = ".".join([*base, *([node.module] if node.module else [])])
            yield from (Import(f"{prefix}.{alias.name}", node.lineno, at_start) for alias in node.names)
        in_function = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        for_types = isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")
        for child in ast.iter_child_nodes(node):
            yield from visit(child, at_start and not in_function and not for_types)

    yield from visit(ast.parse(file.read_text(encoding="utf-8")), True)


def breaches(root: Path) -> list[str]:
    """Return a line for each import under `root` that breaks a rule."""
    return [
        f"{file.relative_to(root)}:{each.line}: {complaint}"
        for file in sorted(root.rglob("*.py"))
        for each in imports(file, root)
        for complaint in _complaints(file.relative_to(root).with_suffix("").parts[0], each)
    ]


def _complaints(layer: str, each: Import) -> Iterator[str]:
    top, *rest = each.name.split(".")
    if top == "pipeline":
        yield f"imports {each.name}: the package is blastline; under two names its types would not be the same"
    if top == "blastline" and rest and rest[0] not in MAY_IMPORT.get(layer, set()):
        yield f"{layer} imports {rest[0]}; it may import only {sorted(MAY_IMPORT.get(layer, set()))}"
    if top in OPENS_MEDIA and layer not in MAY_OPEN_MEDIA:
        yield f"{layer} imports {top}; only {sorted(MAY_OPEN_MEDIA)} open media"
    if each.at_start and top in HEAVY - HEAVY_ALLOWED.get(layer, set()):
        yield f"imports {top} at the start; it must be imported in the function that uses it"


def test_every_import_keeps_to_its_floor() -> None:
    assert len(list(PACKAGE.rglob("*.py"))) > 20
    assert breaches(PACKAGE) == []


def test_every_module_belongs_to_a_known_layer() -> None:
    found = {
        path.stem for path in PACKAGE.iterdir() if path.suffix == ".py" or (path.is_dir() and [*path.glob("*.py")])
    }
    assert found - set(MAY_IMPORT) == set()


@pytest.mark.parametrize(
    ("file", "line", "complaint"),
    [
        ("detect/scan.py", "from ..soundtrack import open_soundtrack", "detect imports soundtrack"),
        ("detect/scan.py", "from .. import render", "detect imports render"),
        ("detect/scan.py", "def f():\n    import blastline.align.checks", "detect imports align"),
        ("model.py", "from .render import compose", "model imports render"),
        ("cli/film.py", "from ..dsp import fade", "cli imports dsp"),
        ("run.py", "from .cli import main", "run imports cli"),
        (
            "render/mix.py",
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from ..detect import x",
            "imports detect",
        ),
        ("report/page.py", "def f():\n    import av", "only ['soundtrack', 'study', 'synth'] open media"),
        ("units.py", "import scipy.signal", "imports scipy at the start"),
        ("units.py", "class A:\n    from pandas import DataFrame", "imports pandas at the start"),
        ("units.py", "try:\n    import rich\nexcept ImportError:\n    pass", "imports rich at the start"),
        ("scene.py", "from pipeline.blastline.model import Span", "the package is blastline"),
    ],
)
def test_a_breach_is_seen(tmp_path: Path, file: str, line: str, complaint: str) -> None:
    (tmp_path / file).parent.mkdir(exist_ok=True)
    (tmp_path / file).write_text(f"{line}\n")
    [breach] = breaches(tmp_path)
    assert complaint in breach


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("detect/scan.py", "from ..dsp import fade\nfrom .envelope import x\nfrom . import features"),
        ("detect/sub/scan.py", "from ...dsp import fade\nfrom ..envelope import x"),
        ("soundtrack/reader.py", "def f():\n    import av"),
        ("cli/app.py", "import typer\nfrom .. import __version__\ndef f():\n    from .. import run"),
        ("units.py", "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import pandas"),
    ],
)
def test_what_is_allowed_is_no_breach(tmp_path: Path, file: str, line: str) -> None:
    (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / file).write_text(f"{line}\n")
    assert breaches(tmp_path) == []

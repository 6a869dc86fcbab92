"""Put a study of the trade into README.md: `python benchmarks/readme.py build/study`.

Takes what `blastline study pareto -o build/study` wrote: the picture becomes docs/pareto.svg, the tables go between the
two marks of README.md. `make study` does both.
"""

import re
import shutil
import sys
from argparse import ArgumentParser
from pathlib import Path

BLOCK = re.compile(r"(<!-- study -->\n).*?(<!-- /study -->)", re.DOTALL)


def put(study: Path, root: Path) -> None:
    """Put what is in a study's folder into the project at `root`."""
    readme = root / "README.md"
    table = (study / "pareto.md").read_text(encoding="utf-8")
    text, found = BLOCK.subn(lambda marks: f"{marks[1]}{table}{marks[2]}", readme.read_text(encoding="utf-8"))
    if found != 1:
        sys.exit(f"{readme}: expected one block between <!-- study --> and <!-- /study -->, found {found}")
    readme.write_text(text, encoding="utf-8")
    shutil.copyfile(study / "pareto.svg", root / "docs" / "pareto.svg")


def main() -> None:
    """Put a study into this project."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("study", type=Path, metavar="DIR", help="what `blastline study pareto -o DIR` wrote")
    put(parser.parse_args().study, Path(__file__).parents[1])


if __name__ == "__main__":
    main()

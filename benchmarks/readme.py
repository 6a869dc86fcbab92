"""Put a study of the trade into README.md: `python benchmarks/readme.py build/study`.

Takes what `blastline study pareto -o build/study` wrote: the picture becomes docs/pareto.svg, the tables go between the
two marks of README.md. `make study` does both.
"""

import re
import shutil
import sys
from pathlib import Path

BLOCK = re.compile(r"(<!-- study -->\n).*?(<!-- /study -->)", re.DOTALL)


def main(study: Path, root: Path) -> None:
    readme = root / "README.md"
    table = (study / "pareto.md").read_text(encoding="utf-8")
    text, found = BLOCK.subn(lambda marks: f"{marks[1]}{table}{marks[2]}", readme.read_text(encoding="utf-8"))
    if found != 1:
        sys.exit(f"{readme}: expected one block between <!-- study --> and <!-- /study -->, found {found}")
    readme.write_text(text, encoding="utf-8")
    shutil.copyfile(study / "pareto.svg", root / "docs" / "pareto.svg")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(__file__).parents[1])

"""Train the verifier: `python -m blastline.study.train --corpus DIR [--corpus DIR ...] -o rules/verifier/shots.json`.

Some films, and with `--hold-out` a part of the sources of recordings, are held out; what the file scores on them is
written into it. With `--more` the networks also learn from lessons of other seeds, with `--again` from augmented copies
of each; gate and screen need fewer. With `--further` the networks of a file are fine-tuned on the new lessons; gate and
screen are fitted anew. `verifier` does the work.
"""

import argparse
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from ..detect.verify import read_model
from .datasets import FOLDS, datasets
from .lesson_files import SeededDatasets
from .networks import SIZES, named_size
from .verifier import train

NETWORKS = ("small", "large", "large")
"""As many as the reference tier asks: the first stands for itself, the others judge what it doubts."""


@dataclass(frozen=True)
class _Lot:
    """How many lessons of a seed there are to be: synthetic films of a minute, and mixes of recordings."""

    seed: int
    synthetic: int
    recorded: int

    def seeded(self, corpus: Sequence[Path], hold_out: int | None) -> SeededDatasets:
        """Return the datasets of these lessons; the recordings come from the folders of `corpus`."""
        made = datasets(corpus, synthetic=self.synthetic, recorded=self.recorded, seed=self.seed, hold_out=hold_out)
        return SeededDatasets(self.seed, made)


def main() -> None:
    """Run from the command line."""
    parser = _parser()
    options = parser.parse_args()
    lots = [_Lot(options.seed, options.synthetic, options.recorded), *options.more]
    seeded = [lot.seeded(options.corpus, options.hold_out) for lot in lots]
    before = read_model(options.further) if options.further else None
    known = tuple(named_size(network) for network in before.networks) if before else ()
    sizes = options.networks or known or NETWORKS
    if sizes[: len(known)] != known:
        parser.error(f"--networks {','.join(sizes)}: expected {','.join(known)} first, as in {options.further}")
    with tempfile.TemporaryDirectory(prefix="blastline-") as made:
        work = options.work or Path(made)
        model = train(seeded, work, networks=sizes, jobs=options.jobs, copies=options.again, before=before)
    options.output.write_bytes(msgspec.json.encode(model) + b"\n")


def _parser() -> argparse.ArgumentParser:
    """Return what reads the command line."""
    parser = argparse.ArgumentParser(prog="python -m blastline.study.train", description="Train the verifier.")
    parser.add_argument("--corpus", type=Path, action="append", default=[], help="a folder with annotations.csv")
    parser.add_argument("--synthetic", type=int, default=600, help="synthetic films of a minute (default: %(default)s)")
    parser.add_argument("--recorded", type=int, default=240, help="mixes of recordings (default: %(default)s)")
    parser.add_argument(
        "--networks",
        type=_sizes,
        metavar="SIZES",
        help=f"their sizes ({', '.join(SIZES)}) in order (default: {','.join(NETWORKS)}, or those of --further)",
    )
    parser.add_argument(
        "--more",
        type=_lot_of,
        action="append",
        default=[],
        metavar="SEED,SYNTHETIC,RECORDED",
        help="lessons of another seed, for the networks alone",
    )
    parser.add_argument("--again", type=int, default=0, help="hear each lesson so many times more, each time changed")
    parser.add_argument("--further", type=Path, metavar="MODEL", help="teach the networks of this file further")
    parser.add_argument("--hold-out", type=int, choices=range(FOLDS), help="test on this fold of the sources")
    parser.add_argument("--work", type=Path, help="keep the lessons in this folder, and use what it has")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("-o", "--output", type=Path, required=True)
    return parser


def _lot_of(text: str) -> _Lot:
    """Return what SEED,SYNTHETIC,RECORDED says; an error of which argparse tells where it is anything else."""
    try:
        seed, synthetic, recorded = (int(part) for part in text.split(","))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r}: expected three whole numbers, SEED,SYNTHETIC,RECORDED") from error
    return _Lot(seed, synthetic, recorded)


def _sizes(text: str) -> tuple[str, ...]:
    """Return the sizes that are named; ValueError, of which argparse tells, for one that there is not."""
    sizes = tuple(text.split(","))
    if not set(sizes) <= set(SIZES):
        raise ValueError(text)
    return sizes


if __name__ == "__main__":
    main()

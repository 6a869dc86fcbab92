"""What exporting costs: `python benchmarks/exports.py [--events 3000] [--hours 2]`, CPU seconds and bytes per format.

The timeline is made up: shots at random samples, at 23.976 frames a second. Imports of the libraries
that a format needs are counted with the first format that needs them, as a user would wait for them.
"""

import argparse
import random
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from blastline.export import FORMATS, export_timeline
from films import Counting, film


def main() -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--events", type=int, default=3000)
    parser.add_argument("--hours", type=float, default=2.0)
    options = parser.parse_args()
    samples = range(round(options.hours * 3600 * 48_000))
    onsets = sorted(random.Random(1).sample(samples, options.events))
    timeline = film(Counting("24000/1001", "01:00:00:00"), onsets=onsets)
    total_s = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for name in FORMATS:
            started_s = time.process_time()
            [file] = export_timeline(timeline, Path(folder), formats=[name])
            spent_s = time.process_time() - started_s
            total_s += spent_s
            print(f"{name:<10} {spent_s:6.2f} s {file.stat().st_size:>10} bytes")
    print(f"{'all':<10} {total_s:6.2f} s")


if __name__ == "__main__":
    main()

"""False alarms in music: `python benchmarks/music.py DIR [--quality draft ...]`.

DIR holds packages of music, each unpacked into a folder of its name (of Debian 12: `dpkg-deb -x NAME_*.deb DIR/NAME`).
Every piece of 40 s and more is listened to as `detect` does, those in archives too; none has a gun, as far as its title
tells.
"""

import tempfile
from argparse import ArgumentParser
from collections import defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import get_args
from zipfile import ZipFile

from blastline import run
from blastline.errors import SoundtrackError
from blastline.model import Quality

KINDS, ARCHIVES = {".flac", ".mp3", ".oga", ".ogg", ".opus", ".wav"}, {".pk3"}
SHORTEST_S = 40.0


@dataclass(frozen=True)
class Heard:
    """A piece of music, how long it lasts, and how many shots were found in it."""

    package: str
    duration_s: float
    shots: int


def pieces(packages: Path, unpacked: Path) -> Iterator[tuple[str, Path]]:
    """Yield the pieces of each package, those of archives unpacked, with its name."""
    for package in sorted(each for each in packages.iterdir() if each.is_dir()):
        for path in sorted(each for each in package.rglob("*") if each.is_file()):
            if path.suffix.lower() in KINDS:
                yield package.name, path
            elif path.suffix.lower() in ARCHIVES:
                with ZipFile(path) as archive:
                    for name in sorted(archive.namelist()):
                        if Path(name).suffix.lower() in KINDS:
                            yield package.name, Path(archive.extract(name, unpacked / package.name))


def listen(quality: Quality, piece: tuple[str, Path]) -> Heard | None:
    """Return what is found in a piece; None where it is too short, or cannot be read."""
    package, path = piece
    try:
        timeline = run.detect(path, run.RenderOptions(quality=quality))
    except SoundtrackError:
        return None
    duration_s = timeline.source.frames / timeline.source.sample_rate_hz
    return Heard(package, duration_s, len(timeline.events)) if duration_s >= SHORTEST_S else None


def tell(quality: Quality, found: Sequence[Heard]) -> None:
    """Print the false alarms of each package and of all."""
    print(f"{quality:26} {'minutes':>8} {'pieces':>7} {'with some':>10} {'false':>6} {'an hour':>8}")
    by_package: dict[str, list[Heard]] = defaultdict(list)
    for each in found:
        by_package[each.package].append(each)
        by_package["all"].append(each)
    for package, heard in sorted(by_package.items(), key=lambda item: (item[0] == "all", item[0])):
        hours, false = sum(each.duration_s for each in heard) / 3600.0, sum(each.shots for each in heard)
        some = sum(each.shots > 0 for each in heard)
        print(f"{package:26} {60.0 * hours:8.0f} {len(heard):7} {some:10} {false:6} {false / hours:8.1f}")


def main() -> None:
    """Run from the command line."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("packages", type=Path, metavar="DIR", help="a folder with a folder for each unpacked package")
    parser.add_argument("--quality", nargs="+", choices=get_args(Quality), default=["standard"])
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as unpacked, ProcessPoolExecutor(options.jobs) as pool:
        music = list(pieces(options.packages, Path(unpacked)))
        for quality in options.quality:
            heard = pool.map(partial(listen, quality), music, chunksize=2)
            tell(quality, [each for each in heard if each is not None])


if __name__ == "__main__":
    main()

"""Two corpora of the sounds of free games and music programs: `python benchmarks/game_sounds.py DIR -o CORPUS`.

DIR holds packages of Debian 12, each unpacked into a folder of its name (`dpkg-deb -x NAME_*.deb DIR/NAME`); those
that are not there are left out. CORPUS/first and CORPUS/second share no source, so that one can be asked about what
has learnt from the other. `game_guns.csv` has the shots and where they begin: where a high-passed sound reaches a
tenth of its peak, each burst looked at in a picture. Their copyright files have the licences; none of it is here.
"""

import csv
import re
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import soundfile
import soxr
from numpy.typing import NDArray

Samples = NDArray[np.int16]

RATE_HZ, LONGEST_S, PEAK, FAINTEST = 48_000, 20, 0.95, 1e-4
COLUMNS = ("path", "source", "licence", "label", "sub_label", "duration_s", "onsets_s", "notes")
SOUNDS, ARCHIVES = {".wav", ".ogg", ".flac"}, {".pk3"}
HALVES = ("first", "second")
FIRST = {
    "ufoai-sound",
    "hydrogen-drumkits",
    "hydrogen-data",
    "lincity-ng-data",
    "minetest-data",
    "supertux-data",
    "torcs-data",
}
"""The packages of the first half."""

ARMED = re.compile("explo|tnt|cannon|gun|shot|blast|thunder|fire_|bomb|missile|rocket|/tech/", re.IGNORECASE)
"""What may be a gun, or an explosion, is no lesson in what is none."""


@dataclass(frozen=True)
class Others:
    """The sounds of a package that are no guns: paths that match, every n-th of them, and what they are."""

    package: str
    pattern: str
    every: int = 1
    kind: str = ""  # else the name of the folder they are in


OTHERS = (
    Others("ufoai-sound", r"/(doors|footsteps|impact|ambience)/|/misc/break"),
    Others("ufoai-sound", r"/weapons/(reload|melee)[^/]*$", kind="handling"),
    Others("hydrogen-drumkits", r"\.(flac|wav)$", every=3),
    Others("hydrogen-data", r"\.flac$", every=3),
    Others("lmms-common", r"/(drums|beats|effects|shapes|basses|bassloops|instruments)/"),
    Others("lincity-ng-data", r"\.wav$"),
    Others("megaglest-data", r"\.wav$", every=6),
    Others("searchandrescue-data", r"\.wav$", kind="machine"),
    Others("supertux-data", r"\.wav$", kind="game"),
    Others("minetest-data", r"\.ogg$"),
    Others("widelands-data", r"\.ogg$", every=3),
    Others("lugaru-data", r"\.(ogg|wav)$", kind="fight"),
    Others("torcs-data", r"\.wav$", kind="car"),
    Others("csmash-data", r"\.wav$", kind="ball"),
)


def sounds_of(folder: Path) -> Iterator[tuple[str, bytes]]:
    """Yield the sounds of an unpacked package, those in its archives too: their paths and what the files hold."""
    for path in sorted(each for each in folder.rglob("*") if each.is_file()):
        if path.suffix.lower() in SOUNDS:
            yield path.relative_to(folder).as_posix(), path.read_bytes()
        elif path.suffix.lower() in ARCHIVES:
            with ZipFile(path) as archive:
                for name in sorted(archive.namelist()):
                    if Path(name).suffix.lower() in SOUNDS:
                        yield name, archive.read(name)


def heard(data: bytes) -> Samples | None:
    """Return a sound's first channel as 16-bit samples at one rate and peak; None for silence and what is no sound."""
    try:
        samples, rate_hz = soundfile.read(BytesIO(data), always_2d=True)
    except soundfile.LibsndfileError:
        return None
    first = samples[:, 0] if rate_hz == RATE_HZ else soxr.resample(samples[:, 0], rate_hz, RATE_HZ)
    if not first.size or np.abs(first).max() < FAINTEST:
        return None
    return np.asarray(np.round(first / np.abs(first).max() * PEAK * 32767.0), np.int16)


def half_of(package: str) -> str:
    """Return the folder of a package's sounds."""
    return "first" if package in FIRST else "second"


def written(corpus: Path, package: str, path: str, samples: Samples, onsets_s: str, kind: str, notes: str) -> list[str]:
    """Write a sound into the half of its package and return its line of the table."""
    name = f"audio/{package}_{re.sub('[^A-Za-z0-9]+', '_', path.rpartition('.')[0])[-80:]}.flac"
    soundfile.write(corpus / half_of(package) / name, samples, RATE_HZ)
    label = "gunshot" if onsets_s else "negative"
    source = package if onsets_s else f"{package}, others"
    return [name, source, "see the package", label, kind, f"{samples.size / RATE_HZ:.4f}", onsets_s, notes]


def guns(unpacked: Path, corpus: Path) -> Iterator[list[str]]:
    """Yield the lines of the shots."""
    with Path(__file__).with_name("game_guns.csv").open(newline="") as file:
        wanted = {(row["package"], row["path"]): row for row in csv.DictReader(file)}
    for package in sorted({package for package, _ in wanted}):
        for path, data in sounds_of(unpacked / package):
            row, samples = wanted.get((package, path)), heard(data)
            if row is not None and samples is not None:
                yield written(corpus, package, path, samples, row["onsets_s"], "designed", row["notes"])


def others(unpacked: Path, corpus: Path) -> Iterator[list[str]]:
    """Yield the lines of the sounds that are no guns."""
    for each in OTHERS:
        matching = [sound for sound in sounds_of(unpacked / each.package) if re.search(each.pattern, sound[0])]
        for path, data in matching[:: each.every]:
            samples = None if ARMED.search(path) else heard(data)
            if samples is not None:
                kind = each.kind or Path(path).parent.name
                yield written(corpus, each.package, path, samples[: LONGEST_S * RATE_HZ], "", kind, "")


def tell(folder: Path, lines: Sequence[Sequence[str]]) -> None:
    """Write the table of a half, and say what it holds."""
    with (folder / "annotations.csv").open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(COLUMNS)
        table.writerows(lines)
    shots = sum(line[3] == "gunshot" for line in lines)
    print(f"{folder}: {shots} guns, {len(lines) - shots} other sounds, {len({line[1] for line in lines})} sources")


def main() -> None:
    """Run from the command line."""
    parser = ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("unpacked", type=Path, metavar="DIR", help="a folder with a folder for each unpacked package")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="CORPUS")
    options = parser.parse_args()
    for half in HALVES:
        (options.output / half / "audio").mkdir(parents=True, exist_ok=True)
    lines = [*guns(options.unpacked, options.output), *others(options.unpacked, options.output)]
    for half in HALVES:
        tell(options.output / half, [line for line in lines if half_of(line[1].partition(",")[0]) == half])


if __name__ == "__main__":
    main()

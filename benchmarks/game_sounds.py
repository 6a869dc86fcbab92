"""Corpora of the sounds of free games and music programs: `python benchmarks/game_sounds.py DIR -o CORPUS`.

DIR holds packages of Debian 12, each unpacked into a folder of its name (`dpkg-deb -x NAME_*.deb DIR/NAME`); those
that are not there are left out. CORPUS/first, second and third share no source, so that one can be asked about what
has learnt from the others; the shipped networks have heard the first and second. `game_guns.csv` has the shots and
where they begin: where a high-passed sound reaches a tenth of its peak, each burst looked at in a picture. Those of
the third were chosen by pictures alone. Their copyright files have the licences; none of it is here.
"""

import csv
import re
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
import soundfile
import soxr
from game_archives import sounds_of
from numpy.typing import NDArray

Samples = NDArray[np.int16]

RATE_HZ, LONGEST_S, PEAK, FAINTEST = 48_000, 20, 0.95, 1e-4
COLUMNS = ("path", "source", "licence", "label", "sub_label", "duration_s", "onsets_s", "notes")
PARTS = {
    "first": "ufoai-sound hydrogen-drumkits hydrogen-data lincity-ng-data minetest-data supertux-data torcs-data",
    "second": (
        "cube2-data openarena-data barrage lmms-common megaglest-data searchandrescue-data widelands-data lugaru-data "
        "csmash-data"
    ),
    "third": (
        "0ad-data boswars-data csound-soundfont dopewars-data fluid-soundfont-gm nexuiz-data timgm6mb-soundfont "
        "wordwarvi-sound bzflag-data extremetuxracer-data flightgear-data-base freedroidrpg-data freeorion-data "
        "hedgewars-data redeclipse-data scorched3d-data starfighter-data supertuxkart-data warmux-data "
        "warzone2100-data wesnoth-1.16-data"
    ),
}
"""Which packages each corpus has."""
PART_OF = {package: part for part, packages in PARTS.items() for package in packages.split()}

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
    Others("0ad-data", r"audio/(actor|ambient|resource)/(?!human/death)", every=2),
    Others("0ad-data", r"audio/attack/(weapon/(?!Musket)|impact/|fire/)", every=2, kind="fight"),
    Others("nexuiz-data", r"sound/(ambient|misc|plats|desertfactory|weather)/", kind="game"),
    Others("nexuiz-data", r"sound/weapons/(brass|casings|ric|tink|grenade_bounce|.*reload)", kind="handling"),
    Others("nexuiz-data", r"sound/player/.*/player/", every=4, kind="voice"),
    Others("warmux-data", r"default/misc/", kind="game"),
    Others("warmux-data", r"weapons/(airh|anv|base|const|grap|gnu|grenade_b|load|m16_c|ric|slap)", kind="handling"),
    Others("wesnoth-1.16-data", r"core/sounds/(?!lightning|dragonstick|cave-in)", every=2, kind="fight"),
    Others("freedroidrpg-data", r"sound/effects/(?!bullets)", every=2, kind="game"),
    Others("extremetuxracer-data", r"etr/sounds/", kind="game"),
    Others("supertuxkart-data", r"/data/sfx/(?!shoot|bowling_shoot)", kind="car"),
    Others("boswars-data", r"(select|select[a-z]+|action|completed)\.wav$", kind="game"),
    Others("hedgewars-data", r"Data/Sounds/(?!mortar|mineimpact|airmine|firepunch)[^/]+$", kind="game"),
    Others("redeclipse-data", r"sounds/(ambience|sfx|player)/", kind="game"),
    Others("redeclipse-data", r"weapons/.*(reload|switch|tink|thud|whizz|ricochet|notify)\d?\.ogg$", kind="handling"),
    Others("warzone2100-data", r"audio/sfx/(building|interfce|misc|vehicle)/|/weld|/build|/richet", kind="machine"),
    Others("flightgear-data-base", r"/Sounds/(?!gatling|crash)[^/]*\.wav$", kind="aircraft"),
    Others("scorched3d-data", r"wav/(misc|movement|shield)/", kind="game"),
    Others("starfighter-data", r"/sound/", kind="game"),
    Others("bzflag-data", r"/(?!fire|shock)[^/]*\.wav$", kind="game"),
    Others("freeorion-data", r"/sound/[^/]*\.ogg$", kind="game"),
)


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


def written(corpus: Path, package: str, path: str, samples: Samples, onsets_s: str, kind: str, notes: str) -> list[str]:
    """Write a sound into the part of its package and return its line of the table."""
    name = f"audio/{package}_{re.sub('[^A-Za-z0-9]+', '_', Path(path).with_suffix('').as_posix())[-80:]}.flac"
    soundfile.write(corpus / PART_OF[package] / name, samples, RATE_HZ)
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
    """Write the table of a part, and say what it holds."""
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
    for part in PARTS:
        (options.output / part / "audio").mkdir(parents=True, exist_ok=True)
    lines = [*guns(options.unpacked, options.output), *others(options.unpacked, options.output)]
    for part in PARTS:
        tell(options.output / part, [line for line in lines if PART_OF[line[1].partition(",")[0]] == part])


if __name__ == "__main__":
    main()

"""What a film's channels tell beyond its mix: `python benchmarks/channels.py [--quality standard] [--scenes 20]`.

Synthesises scenes in 5.1, 7.1 and stereo, finds their shots as `detect` does, once in the mains and once more in the
sides, and prints what was found and how far the azimuths are off. Three families:

    drowned   a minute of loud dialogue in the middle, shots 25 to 155 degrees aside (8 to 30 in stereo), 4 dB under to
              24 dB over the sound
    film      two minutes of changing beds, shots and other sounds anywhere
    no gun    three minutes of the same without shots
"""

import argparse
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import msgspec
import numpy as np

from blastline import run
from blastline.model import Quality, Timeline
from blastline.study.matching import Counts, count, match
from blastline.synth import Scene, Truth
from blastline.synth.files import write_scene
from blastline.synth.film import film_scene
from blastline.synth.negatives import NEGATIVE_KINDS
from blastline.synth.scene import BedItem, Layout, NegativeItem, ShotItem
from blastline.synth.spread import draw_negatives, draw_shots, spread

WINDOW_MS = 10.0

Item = TypeVar("Item", ShotItem, NegativeItem)


@dataclass
class Tally:
    """What was found in the scenes of a family."""

    counts: Counts = field(default_factory=lambda: Counts(0, 0, 0))
    minutes: float = 0.0
    off_deg: list[float] = field(default_factory=list)
    unplaced: int = 0

    def add(self, truth: Truth, found: Timeline) -> None:
        """Count one scene."""
        onsets_ms = np.array([event.onset_s * 1000.0 for event in found.events])
        places_ms = [tuple(at * 1000.0 / truth.rate_hz for at in shot.accept_samples) for shot in truth.shots]
        forgiven_ms = [each.at_s * 1000.0 for each in truth.negatives if each.kind == "explosion"]
        true_ms = np.array([shot.onset_s * 1000.0 for shot in truth.shots])
        self.counts += count(onsets_ms, true_ms, WINDOW_MS, alternatives_ms=places_ms, forgiven_ms=forgiven_ms)
        self.minutes += truth.frames / truth.rate_hz / 60.0
        for index, true in match(onsets_ms, true_ms, WINDOW_MS, places_ms):
            expected, told = truth.shots[true].azimuth_deg, found.events[index].azimuth_deg
            if expected is not None and told is None:
                self.unplaced += 1
            elif expected is not None and told is not None:
                self.off_deg.append(abs((told - expected + 180.0) % 360.0 - 180.0))

    def row(self) -> str:
        """Return the figures as cells of a table."""
        counts, off = self.counts, np.array(self.off_deg or [np.nan])
        shares = f"{counts.precision:.3f} | {counts.recall:.3f} | {counts.f1:.3f}" if counts.hits else "- | - | -"
        turned = f"{np.median(off):.1f} / {np.percentile(off, 90):.1f} | {self.unplaced}" if self.off_deg else "- | -"
        return f"{counts.hits + counts.missed} | {shares} | {counts.false} in {self.minutes:.0f} min | {turned}"


def drowned(seed: int, layout: Layout) -> Scene:
    """Return a minute of dialogue in the centre with shots aside and other sounds anywhere."""
    rng = np.random.default_rng(seed)
    beds = [
        BedItem(kind="ambience", level_dbfs=float(rng.uniform(-60.0, -44.0))),
        BedItem(kind="dialogue", level_dbfs=float(rng.uniform(-26.0, -16.0))),
    ]
    if rng.random() < 0.5:
        beds.append(BedItem(kind="music", level_dbfs=float(rng.uniform(-44.0, -28.0))))
    aside = (8.0, 30.0) if layout == "stereo" else (25.0, 155.0)
    shots = [
        msgspec.structs.replace(shot, azimuth_deg=float(rng.choice([-1.0, 1.0]) * rng.uniform(*aside)))
        for shot in draw_shots(rng, 10, (-4.0, 24.0))
    ]
    others = [anywhere(rng, each, layout) for each in draw_negatives(rng, 10, (-4.0, 30.0), kinds=NEGATIVE_KINDS)]
    shots, others = spread(rng, shots, others, start_s=1.0, stop_s=59.0, spacing_s=0.3)
    return Scene(
        schema=1,
        rate_hz=48_000,
        duration_s=60.0,
        seed=seed,
        layout=layout,
        beds=tuple(beds),
        shots=tuple(shots),
        negatives=tuple(others),
    )


def film(seed: int, layout: Layout, *, minutes: float, gun_free: bool = False) -> Scene:
    """Return a film whose sounds come from anywhere; every other one is crowded."""
    others = round((6 if seed % 2 else 25) * minutes)
    plain = film_scene(seed, 60.0 * minutes, round(8 * minutes), others, gun_free=gun_free)
    rng = np.random.default_rng(seed + 1)
    return msgspec.structs.replace(
        plain,
        layout=layout,
        shots=tuple(anywhere(rng, each, layout) for each in plain.shots),
        negatives=tuple(anywhere(rng, each, layout) for each in plain.negatives),
    )


def anywhere(rng: np.random.Generator, item: Item, layout: Layout) -> Item:
    """Return a sound from any side that the layout has, or, half of the time, somewhere in the picture."""
    if rng.random() < 0.5:
        return item
    widest_deg = 30.0 if layout == "stereo" else 180.0
    return msgspec.structs.replace(item, azimuth_deg=float(rng.uniform(-widest_deg, widest_deg)))


def measured(scenes: list[Scene], quality: Quality) -> dict[str, Tally]:
    """Return what is found in the scenes, heard once and twice."""
    tallies = {"once": Tally(), "twice": Tally()}
    for scene in scenes:
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            truth = write_scene(scene, folder)
            for heard, sides in (("once", "false"), ("twice", "true")):
                rules = folder / heard / "quality"
                rules.mkdir(parents=True)
                (rules / f"{quality}.toml").write_text(f"[channels]\nsides = {sides}\n", encoding="utf-8")
                found = run.detect(folder / f"{scene.name}.wav", run.RenderOptions(quality=quality, rules=rules.parent))
                tallies[heard].add(truth, found)
    return tallies


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quality", default="standard")
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--only", default="", help="the families with this in their names")
    options = parser.parse_args()
    seeds = range(options.scenes)
    half = seeds[: (len(seeds) + 1) // 2]
    families = {
        "drowned, 5.1": [drowned(8000 + seed, "5.1") for seed in seeds],
        "drowned, 7.1": [drowned(8030 + seed, "7.1") for seed in half],
        "film, 5.1": [film(8100 + seed, "5.1", minutes=2.0) for seed in seeds],
        "film, 7.1": [film(8130 + seed, "7.1", minutes=2.0) for seed in half],
        "no gun, 5.1": [film(8200 + seed, "5.1", minutes=3.0, gun_free=True) for seed in seeds],
        "drowned, stereo": [drowned(8300 + seed, "stereo") for seed in seeds],
        "film, stereo": [film(8330 + seed, "stereo", minutes=2.0) for seed in seeds],
        "no gun, stereo": [film(8360 + seed, "stereo", minutes=3.0, gun_free=True) for seed in seeds],
    }
    print("| scenes | heard | shots | precision | recall | F1 | false | azimuth off: median / 90 %, deg | not told |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for name, scenes in ((name, scenes) for name, scenes in families.items() if options.only in name):
        for heard, tally in measured(scenes, options.quality).items():
            print(f"| {name} | {heard} | {tally.row()} |", flush=True)


if __name__ == "__main__":
    main()

"""What four times as many shots cost: `python benchmarks/growth.py`, CPU of stages after detection, as ratios.

A battle without a pause is the worst case of each stage: all shots are one window, each has echoes where others fire,
and every other one is softer and may copy those before it. Work that grows with the shots has a ratio of about 4, work
that grows with their square one of 16.
"""

import sys
from argparse import ArgumentParser
from collections.abc import Callable, Sequence
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np

from blastline.detect.bursts import drop_claimed_reflections, suppress_non_maxima, without_echoes
from blastline.detect.copies import attack
from blastline.model import HeardIn, Reflection, Shot, ShotEvidence, Span
from blastline.render import plan_windows
from blastline.ruleset import load_rules

RATE_HZ, APART, TIMES = 48_000, 4_800, 4
TIER = load_rules("standard").tier
SURE: dict[HeardIn, float] = {"mains": TIER.verify.threshold, "sides": TIER.channels.sides_threshold}
STAGES: dict[str, Callable[[Sequence[Shot], int], object]] = {
    "suppress_non_maxima": lambda fire, _: suppress_non_maxima(fire, rate_hz=RATE_HZ, rules=TIER.bursts, sure=SURE),
    "without_echoes": lambda fire, _: without_echoes(fire, rate_hz=RATE_HZ, rules=TIER.bursts),
    "drop_claimed_reflections": lambda fire, _: drop_claimed_reflections(fire, rate_hz=RATE_HZ, rules=TIER.bursts),
    "plan_windows": lambda fire, frames: plan_windows(fire, frames=frames, rate_hz=RATE_HZ, rules=TIER.windows),
}


def battle(count: int) -> list[Shot]:
    """Return so many shots, ten in a second, each of which sounds until the next but three."""
    noise = np.random.default_rng(1).standard_normal((50, APART)).astype(np.float32)
    attacks = [attack(each, APART // 2, RATE_HZ) for each in noise]
    return [
        Shot(
            at,
            0.9,
            peak_dbfs=-6.0 * (number % 2),
            snr_db=20.0,
            blast=Span(at, at + 400),
            reflections=tuple(
                Reflection(at + late, at + late + 96, late * 1000.0 / RATE_HZ, -12.0)
                for late in range(APART // 2, 4 * APART, APART)
            ),
            span=Span(at, at + 4 * APART),
            evidence=ShotEvidence(0.9, 1, None, "fallen", attack=attacks[number % len(attacks)]),
        )
        for number, at in enumerate(range(0, count * APART, APART))
    ]


def spent_s(stage: Callable[[Sequence[Shot], int], object], count: int) -> float:
    """Return the CPU seconds that a stage takes for a battle of so many shots, the least of three."""
    fire, least_s = battle(count), float("inf")
    for _ in range(3):
        began = process_time()
        stage(fire, (count + 4) * APART)
        least_s = min(least_s, process_time() - began)
    return least_s


def main() -> None:
    """Write the table."""
    ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    count = 5000
    print(f"{'stage':<26}{count:>9} shots{TIMES * count:>9} shots   ratio")
    for name, stage in STAGES.items():
        few_s, many_s = (spent_s(stage, shots) for shots in (count, TIMES * count))
        print(f"{name:<26}{few_s:13.3f} s{many_s:13.3f} s{many_s / few_s:8.1f}")


if __name__ == "__main__":
    main()

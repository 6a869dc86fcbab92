"""What the haptic formats of a long film cost: `python benchmarks/haptics.py [--shots 3000] [--minutes 120]`.

Makes a timeline and a drive with noise that dies away in the 350 ms after each shot (kept in build/bench), exports them
to each haptic format, to those together, and to all formats that there are, each in a process of its own, and prints
CPU and wall time, the size of the files and the rounding that the export tells. Noise is the worst case: its amplitude
and frequency need more points than those of a shot.
"""

import argparse
import resource
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from blastline.export import FORMATS, HAPTIC_FORMATS
from blastline.model import (
    SCHEMA,
    ActuatorRef,
    Clip,
    Event,
    Reflection,
    Source,
    Span,
    Timeline,
    Window,
    encode,
)
from blastline.ruleset import DEFAULT_ACTUATOR, load_actuator
from blastline.soundtrack import write_drive

BENCH = Path("build/bench/haptics")
RATE_HZ = 48_000
LENGTH, LEAD = 350 * RATE_HZ // 1000, 6 * RATE_HZ // 1000


def event(index: int, onset: int) -> Event:
    echoes = tuple(Reflection(onset + late, onset + late + 240, late * 1e3 / RATE_HZ, -8.0) for late in (3000, 9000))
    window = Window(onset - LEAD, onset + LENGTH, 240, 1920)
    name, at_s = f"shot-{index + 1:04d}", onset / RATE_HZ
    return Event(name, onset, at_s, "", 1.0, None, None, -3.0, 30.0, Span(onset, onset + 240), echoes, window)


def drive(events: tuple[Event, ...]) -> Iterator[Clip]:
    decay = 0.3 * np.exp(-np.arange(LENGTH) / RATE_HZ / 0.06)
    for index, each in enumerate(events):
        noise = np.random.default_rng(index).standard_normal(LENGTH) * decay
        yield Clip(np.clip(noise, -1.0, 1.0)[:, None], RATE_HZ, each.onset_sample)


def make(shots: int, frames: int) -> Path:
    random = np.random.default_rng(0)
    places = np.sort(random.choice(np.arange(1, frames // (RATE_HZ // 2) - 1), shots, replace=False))
    onsets = places * (RATE_HZ // 2) + random.integers(0, RATE_HZ // 10, shots)
    events = tuple(event(index, int(onset)) for index, onset in enumerate(onsets))
    source = Source("film.wav", "0" * 64, RATE_HZ, frames, 1)
    profile, digest = load_actuator(DEFAULT_ACTUATOR)
    actuator = ActuatorRef(profile.name, digest)
    BENCH.mkdir(parents=True, exist_ok=True)
    timeline = Timeline(SCHEMA, "0", "standard", "0" * 64, source, actuator, events, (), ())
    (BENCH / "timeline.json").write_bytes(encode(timeline))
    write_drive(BENCH / "drive.wav", drive(events), rate_hz=RATE_HZ, frames=frames)
    return BENCH / "timeline.json"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--shots", type=int, default=3000)
    parser.add_argument("--minutes", type=float, default=120.0)
    options = parser.parse_args()
    timeline = make(options.shots, round(options.minutes * 60 * RATE_HZ))
    every = ",".join((*FORMATS, *HAPTIC_FORMATS))
    for formats in ("ahap", "haptic", "hjif", "ahap,haptic,hjif", every):
        out = BENCH / ("all" if formats == every else formats.replace(",", "-"))
        command = [sys.executable, "-m", "blastline", "export", str(timeline), "--format", formats, "-o", str(out)]
        command += ["--frame-rate", "23.976"]
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        told = subprocess.run([*command, "--overwrite"], check=True, capture_output=True, text=True).stderr
        used, wall_s = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter() - start
        cpu_s = used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime
        size = sum(path.stat().st_size for path in out.iterdir())
        print(f"{formats}: {cpu_s:.1f} s of CPU, {wall_s:.1f} s of wall time, {size / 1e6:.1f} MB")
        print(told, end="")


if __name__ == "__main__":
    main()

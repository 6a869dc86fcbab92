"""Running the command line in tests, and a film to run it on."""

import os
import signal
import subprocess
import sys
import wave
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

RATE_HZ = 48_000
COMMAND = [sys.executable, "-W", "error", "-m", "blastline"]


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    code: int
    out: str
    err: str

    @property
    def complaint(self) -> str:
        """Return the one line that told what was wrong with the input; nothing else may have been said."""
        assert (self.code, self.out) == (2, ""), self
        [line] = self.err.splitlines()
        assert line.startswith("blastline: ")
        return line.removeprefix("blastline: ")


def blastline(*arguments: str | Path, prepare: Callable[[], None] | None = None) -> Ended:
    """Run the command in a process of its own, as a user does; `prepare` runs in it beforehand."""
    done = subprocess.run(
        [*COMMAND, *map(str, arguments)],
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        preexec_fn=prepare,
        timeout=120,
        check=False,
    )
    return Ended(done.returncode, done.stdout, done.stderr)


def interrupted(*arguments: str | Path, number: signal.Signals) -> Ended:
    """Start the command, send it a signal when it has said that it is at work, and wait for its end."""
    with subprocess.Popen(
        [*COMMAND, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        first = process.stderr.readline()
        os.kill(process.pid, number)
        out, err = process.communicate(timeout=60)
    return Ended(process.returncode, out, first + err)


def write_film(path: Path, *, length_s: float, shots_s: tuple[float, ...] = (), seed: int = 7) -> Path:
    """Write a mono film of quiet noise with a bang at each of the given times; return its path."""
    random = np.random.default_rng(seed)
    samples = random.normal(0.0, 1e-3, round(length_s * RATE_HZ))
    for shot_s in shots_s:
        start = round(shot_s * RATE_HZ)
        time_s = np.arange(min(RATE_HZ // 2, len(samples) - start)) / RATE_HZ
        blast = (1.0 - time_s / 1e-3) * np.exp(-time_s / 1e-3) + 0.3 * np.exp(-time_s / 0.06) * random.normal(
            size=len(time_s)
        )
        samples[start : start + len(time_s)] += 0.6 * blast
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE_HZ)
        file.writeframes(np.round(np.clip(samples, -1.0, 1.0) * 32_767).astype("<i2").tobytes())
    return path

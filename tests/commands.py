"""Running the command line in tests, and a film to run it on."""

import contextlib
import io
import os
import signal
import subprocess
import sys
import wave
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from blastline.cli import main

RATE_HZ = 48_000
COMMAND = [sys.executable, "-W", "error", "-m", "blastline"]
BELIEVE = """
[verify]
threshold = 0.0
company_threshold = 0.0
burst_threshold = 0.0
even_threshold = 0.0
even_networks_threshold = 0.0
round_threshold = 0.0
pair_threshold = 0.0
least_fall_db = 0.0
report_from = 0.0
"""
"""A tier's rules that take every candidate for a shot, so that no test depends on what the verifier has learnt."""


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


def blastline(*arguments: str | Path, encoding: str = "utf-8") -> Ended:
    """Run the command in this process, which is quick; `encoding` is that of its standard output."""
    handlers = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    out, err = (io.TextIOWrapper(io.BytesIO(), encoding=name, newline="") for name in (encoding, "utf-8"))
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main([str(argument) for argument in arguments])
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
    return Ended(code, _text(out), _text(err))


def blastline_alone(*arguments: str | Path, prepare: Callable[[], None] | None = None) -> Ended:
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


def interrupted(*arguments: str | Path, number: signal.Signals, at: str) -> Ended:
    """Start the command, send it a signal when it says that it is at a stage, and wait for its end.

    What runs the tests in the background or without a terminal has them ignore some signals, which the command would
    inherit.
    """
    ours = signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
    try:
        process = subprocess.Popen(
            [*COMMAND, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
    finally:
        signal.signal(number, ours)
    with process:
        assert process.stderr is not None
        said = ""
        while at not in said:
            line = process.stderr.readline()
            assert line, f"ended before it came to {at}: {said}"
            said += line
        os.kill(process.pid, number)
        out, err = process.communicate(timeout=60)
    return Ended(process.returncode, out, said + err)


def _text(stream: io.TextIOWrapper) -> str:
    stream.flush()
    return cast("io.BytesIO", stream.buffer).getvalue().decode(stream.encoding)


def write_film(path: Path, *, length_s: float, shots_s: tuple[float, ...] = (), seed: int = 7) -> Path:
    """Write a mono film with a bang at each of the given times in noise that fades in; return its path."""
    random = np.random.default_rng(seed)
    samples = random.normal(0.0, 1e-3, round(length_s * RATE_HZ))
    samples[: RATE_HZ // 2] *= np.linspace(0.0, 1.0, RATE_HZ // 2)
    for shot_s in shots_s:
        start = round(shot_s * RATE_HZ)
        time_s = np.arange(min(RATE_HZ // 2, len(samples) - start)) / RATE_HZ
        blast = (1.0 - time_s / 1e-3) * np.exp(-time_s / 1e-3) + 0.3 * np.exp(-time_s / 0.06) * random.normal(
            size=len(time_s)
        )
        samples[start : start + len(time_s)] += 0.6 * blast
    return write_wave(path, samples)


def write_wave(path: Path, samples: NDArray[np.float64], *, rate_hz: int = RATE_HZ) -> Path:
    """Write mono samples as 16 bits, clipped to -1 and 1; return the path."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(rate_hz)
        file.writeframes(np.round(np.clip(samples, -1.0, 1.0) * 32_767).astype("<i2").tobytes())
    return path

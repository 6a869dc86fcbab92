"""What listening costs: processor time against reading the same file, and the memory of a process of its own."""

import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import msgspec

from ..detect import LATENCY_S, Detection, Verifier, find_shots, load_verifier
from ..ruleset import QualityRules
from ..soundtrack import open_soundtrack

_BLOCK = 65_536


class Asked(msgspec.Struct, frozen=True):
    """What a process that measures its own memory listens to, and how."""

    film: str
    verifier: str
    tier: QualityRules


@dataclass(frozen=True)
class Heard:
    """What was found in a film, its rate and length, and the processor time that took, all threads together."""

    detection: Detection
    rate_hz: int
    frames: int
    cpu_s: float


def listened(path: Path, tier: QualityRules, verifier: Verifier) -> Heard:
    """Find the shots of a film as a run does, from opening the file on."""
    began = time.process_time()
    with open_soundtrack(path) as track:
        blocks = track.blocks(sides=tier.channels.sides, remembered_s=LATENCY_S)
        found = find_shots(
            blocks, rate_hz=track.rate_hz, tier=tier, verifier=verifier, channels=track.channels_in_space
        )
        cpu_s = time.process_time() - began
        return Heard(found, track.rate_hz, track.source().frames, cpu_s)


def read_cpu_s(path: Path) -> float:
    """Return the processor time of soundfile reading a film in blocks as float32, the second time it does.

    Raises SoundtrackError where neither soundfile nor a decoder can read it.
    """
    _read(path)
    began = time.process_time()
    _read(path)
    return time.process_time() - began


def peak_memory_mb(path: Path, tier: QualityRules, verifier: Path) -> float | None:
    """Return the most memory that a process needs to find the shots of a film, interpreter and libraries included.

    None where the system does not tell.
    """
    asked = Asked(str(path), str(verifier), tier)
    done = subprocess.run(
        [sys.executable, "-m", "blastline.study.cost"],
        input=msgspec.json.encode(asked),
        capture_output=True,
        check=True,
    )
    return float(done.stdout) if done.stdout.strip() else None


def _read(path: Path) -> None:
    import soundfile

    try:
        with soundfile.SoundFile(path) as file:
            for _ in file.blocks(_BLOCK, dtype="float32"):
                pass
    except soundfile.LibsndfileError:  # a film container: the decoder alone is the floor
        with open_soundtrack(path) as track:
            for _ in track.blocks():
                pass


def _peak_mb() -> float | None:
    """Return the most memory that this process has had; None where the system does not tell."""
    status = Path("/proc/self/status")
    if status.is_file():
        (line,) = [row for row in status.read_text().splitlines() if row.startswith("VmHWM")]
        return float(line.split()[1]) / 1024.0
    try:
        import resource
    except ModuleNotFoundError:  # Windows
        return None
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2.0**20 if sys.platform == "darwin" else 1024.0)


def _measure() -> None:
    asked = msgspec.json.decode(sys.stdin.buffer.read(), type=Asked)
    verifier = load_verifier(Path(asked.verifier), networks=asked.tier.verify.networks)
    listened(Path(asked.film), asked.tier, verifier)
    peak_mb = _peak_mb()
    if peak_mb is not None:
        sys.stdout.write(f"{peak_mb:.1f}\n")


if __name__ == "__main__":
    _measure()

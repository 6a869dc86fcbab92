"""Scenes with their true shots: windows as a run would plan them if every onset had been found, to the sample."""

import tempfile
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ..detect import audio_around, shot_at
from ..errors import RuleError
from ..model import Shot
from ..render import PlannedWindow, plan_windows
from ..ruleset import QualityRules
from ..soundtrack import Soundtrack, open_soundtrack
from ..synth import Truth, load_scene, synthesise
from ..units import samples_from_s


@dataclass(frozen=True, eq=False)
class TrueScene:
    """A scene's track, heard once and ready to be read again, its true shots in order and their windows."""

    name: str
    path: Path
    track: Soundtrack
    frames: int
    shots: tuple[Shot, ...]
    windows: tuple[PlannedWindow, ...]


def true_scenes(folder: Path, tier: QualityRules, names: Collection[str] | None = None) -> Iterator[TrueScene]:
    """Yield each scene of a folder that has shots, or those of these names, synthesised into a temporary file.

    Onsets are those of the truth; where a shot has decayed is found as in a run. Raises RuleError where no scene
    of the folder has a shot.
    """
    for name, path, truth in synthesised(scenes_with_shots(folder, names)):
        with true_scene(name, path, [shot.onset_s for shot in truth.shots], tier) as scene:
            yield scene


def scenes_with_shots(folder: Path, names: Collection[str] | None = None) -> list[Path]:
    """Return the scene files of a folder that have shots, or those of these names; RuleError where there is none."""
    files = [
        file for file in sorted(folder.glob("*.toml")) if (names is None or file.stem in names) and _has_shots(file)
    ]
    if not files:
        raise RuleError(f"{folder}: no scene (*.toml) with shots in it")
    return files


@contextmanager
def true_scene(name: str, path: Path, onsets_s: Iterable[float], tier: QualityRules) -> Iterator[TrueScene]:
    """Open a film whose shots begin at these seconds, with their parts and windows; closed on leaving."""
    with open_soundtrack(path) as track:
        frames = sum(len(clip.span) for clip in track.blocks())
        onsets = [samples_from_s(onset_s, track.rate_hz) for onset_s in onsets_s]
        shots = tuple(_parted(track, frames, onset, tier) for onset in onsets)
        windows = plan_windows(shots, frames=frames, rate_hz=track.rate_hz, rules=tier.windows)
        yield TrueScene(name, path, track, frames, shots, windows)


def synthesised(files: Iterable[Path]) -> Iterator[tuple[str, Path, Truth]]:
    """Yield the name of each scene, its sound in a temporary file that lasts until the next one, and its truth."""
    for file in files:
        with tempfile.TemporaryDirectory(prefix="blastline-") as made:
            truth = synthesise(file, Path(made))
            yield file.stem, Path(made) / f"{truth.scene}.wav", truth


def _has_shots(file: Path) -> bool:
    scene = load_scene(file)
    return bool(scene.shots) or (scene.random is not None and scene.random.shots > 0)


def _parted(track: Soundtrack, frames: int, onset: int, tier: QualityRules) -> Shot:
    """Return a true shot with the parts that a run finds from its onset on."""
    around = audio_around(onset, frames=frames, rate_hz=track.rate_hz, tier=tier)
    return shot_at(onset, track.read(around), confidence=1.0, tier=tier)

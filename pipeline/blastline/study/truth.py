"""Scenes with their true shots: windows as a run would plan them if every onset had been found, to the sample."""

import tempfile
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from ..detect import audio_around, shot_at
from ..errors import RuleError
from ..model import Shot
from ..render import PlannedWindow, plan_windows
from ..ruleset import QualityRules
from ..soundtrack import Soundtrack, open_soundtrack
from ..synth import Truth, load_scene, synthesise


@dataclass(frozen=True, eq=False)
class TrueScene:
    """A scene's track, heard once and ready to be cut, its true shots in order and their windows."""

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
        with open_soundtrack(path) as track:
            for _ in track.blocks():
                pass
            shots = tuple(_parted(track, truth.frames, shot.onset_sample, tier) for shot in truth.shots)
            windows = plan_windows(shots, frames=truth.frames, rate_hz=track.rate_hz, rules=tier.windows)
            yield TrueScene(name, path, track, truth.frames, shots, windows)


def scenes_with_shots(folder: Path, names: Collection[str] | None = None) -> list[Path]:
    """Return the scene files of a folder that have shots, or those of these names; RuleError where there is none."""
    files = [
        file for file in sorted(folder.glob("*.toml")) if (names is None or file.stem in names) and _has_shots(file)
    ]
    if not files:
        raise RuleError(f"{folder}: no scene (*.toml) with shots in it")
    return files


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
    return shot_at(onset, track.cut(around), confidence=1.0, tier=tier)

"""Scenes with their true shots: windows as a run would plan them if every onset had been found, to the sample."""

import tempfile
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from ..detect.segment import segment
from ..errors import RuleError
from ..model import Shot, Span
from ..render import PlannedWindow, plan_windows
from ..ruleset import QualityRules
from ..soundtrack import Soundtrack, open_soundtrack
from ..synth import ShotTruth, load_scene, synthesise
from ..units import samples_from_ms

_BEFORE_MS, _AFTER_MS = 250.0, 1500.0


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
    files = [
        file for file in sorted(folder.glob("*.toml")) if (names is None or file.stem in names) and _has_shots(file)
    ]
    if not files:
        raise RuleError(f"{folder}: no scene (*.toml) with shots in it")
    for file in files:
        with tempfile.TemporaryDirectory(prefix="blastline-") as made:
            truth = synthesise(file, Path(made))
            path = Path(made) / f"{truth.scene}.wav"
            with open_soundtrack(path) as track:
                for _ in track.blocks():
                    pass
                shots = tuple(_segmented(track, truth.frames, shot, tier) for shot in truth.shots)
                windows = plan_windows(shots, frames=truth.frames, rate_hz=track.rate_hz, rules=tier.windows)
                yield TrueScene(file.stem, path, track, truth.frames, shots, windows)


def _has_shots(file: Path) -> bool:
    scene = load_scene(file)
    return bool(scene.shots) or (scene.random is not None and scene.random.shots > 0)


def _segmented(track: Soundtrack, frames: int, shot: ShotTruth, tier: QualityRules) -> Shot:
    """Return a true shot with the parts that segmentation finds from its onset on."""
    before, after = (samples_from_ms(ms, track.rate_hz) for ms in (_BEFORE_MS, _AFTER_MS))
    span = Span(max(0, shot.onset_sample - before), min(frames, shot.onset_sample + after))
    return segment(
        track.cut(span).heard,
        shot.onset_sample - span.start,
        film_start=span.start,
        film_stop=frames,
        confidence=1.0,
        rate_hz=track.rate_hz,
        rules=tier.segment,
    )

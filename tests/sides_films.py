"""A scene of three shots, of which films are mixed whose channels play them in any way."""

from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
import soundfile
from numpy.typing import NDArray

from blastline.synth import Scene, render_scene

RATE_HZ = 48_000
SCENE = {
    "schema": 1,
    "rate_hz": RATE_HZ,
    "duration_s": 12.0,
    "seed": 15,
    "layout": "mono",
    "beds": [{"kind": "ambience", "level_dbfs": -60.0}],
    "shots": [
        {"at_s": at_s, "weapon": weapon, "environment": "street", "distance_m": 12.0, "snr_db": 34.0}
        for at_s, weapon in ((2.0, "rifle"), (5.5, "pistol"), (9.0, "shotgun"))
    ],
}

Samples = NDArray[np.float64]


def three_shots() -> Samples:
    """Return the scene, mono, which peaks at 0.4."""
    audio = render_scene(msgspec.convert(SCENE, Scene))
    samples = np.asarray(audio.read(0, audio.frames)[:, 0], np.float64)
    return np.asarray(samples * (0.4 / np.abs(samples).max()))


def written(path: Path, channels: Sequence[Samples]) -> Path:
    """Write channels side by side and return the path."""
    soundfile.write(path, np.stack(channels, axis=1), RATE_HZ, subtype="PCM_24")
    return path

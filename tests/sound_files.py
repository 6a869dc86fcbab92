"""Uncompressed files that tests write and read."""

from pathlib import Path

import numpy as np
import soundfile
from numpy.typing import NDArray

from blastline.model import Source
from blastline.soundtrack import open_soundtrack

RATE_HZ = 48_000
FRAMES = 70_000
FORMATS = [
    ("WAV", "PCM_U8"),
    ("WAV", "PCM_16"),
    ("WAV", "PCM_24"),
    ("WAV", "PCM_32"),
    ("WAV", "FLOAT"),
    ("WAV", "DOUBLE"),
    ("WAVEX", "PCM_24"),
    ("RF64", "PCM_16"),
    ("W64", "PCM_24"),
    ("AIFF", "PCM_16"),
    ("AIFF", "PCM_S8"),
    ("CAF", "PCM_24"),
]


def noise(frames: int = FRAMES, channels: int = 1, seed: int = 0) -> NDArray[np.float64]:
    return np.random.default_rng(seed).uniform(-0.9, 0.9, (frames, channels))


def wav(path: Path, samples: NDArray[np.floating], *, rate_hz: int = RATE_HZ, subtype: str = "PCM_16") -> Path:
    soundfile.write(path, samples, rate_hz, subtype=subtype, format="WAV")
    return path


def read(path: Path, *, mix: str = "mains", frames: int = 65_536) -> tuple[NDArray[np.float32], Source]:
    with open_soundtrack(path, mix=mix) as track:
        blocks = list(track.blocks(frames))
        assert [block.start for block in blocks] == [frames * index for index in range(len(blocks))]
        assert all(block.samples.dtype == np.float32 for block in blocks)
        return np.concatenate([block.samples for block in blocks]), track.source()

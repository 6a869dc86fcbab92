"""Sound through a lossy codec and back, as it reaches a viewer."""

import tempfile
from fractions import Fraction
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..soundtrack import open_soundtrack

FULL_SCALE = 32_767.0 / 32_768.0
LAYOUTS = {1: "mono", 2: "stereo", 6: "5.1"}
Codec = Literal["ac3", "eac3", "aac", "libmp3lame", "libopus"]
BITS_PER_S: dict[Codec, tuple[int, ...]] = {
    "ac3": (64_000, 96_000, 128_000, 192_000),
    "eac3": (48_000, 64_000, 96_000, 160_000),
    "aac": (32_000, 48_000, 64_000, 96_000, 128_000),
    "libmp3lame": (48_000, 64_000, 96_000, 128_000),
    "libopus": (24_000, 32_000, 64_000, 96_000),
}
"""What one channel is given, from a hardly bearable copy to what a disc or a broadcast spends."""


def coded(samples: NDArray[np.float32], codec: Codec, *, bits_per_s: int, rate_hz: int) -> NDArray[np.float32]:
    """Return mono samples as they come out of a codec, as many and in their places, clipped at full scale.

    The reader takes away the silence that an encoder puts first; a tail that the codec loses is silence.
    """
    with tempfile.TemporaryDirectory(prefix="blastline-") as folder:
        film = Path(folder) / "film.mkv"
        encode(film, samples[:, None], codec, bits_per_s=bits_per_s, rate_hz=rate_hz)
        with open_soundtrack(film) as track:
            heard = np.concatenate([clip.heard for clip in track.blocks()])
    back = np.zeros_like(samples)
    kept = heard[: samples.shape[0]]
    back[: kept.shape[0]] = np.clip(kept, -1.0, FULL_SCALE)
    return back


def encode(path: Path, samples: NDArray[np.float32], codec: Codec, *, bits_per_s: int, rate_hz: int) -> None:
    """Write samples, shape (frames, channels), as the one stream of a film; mono, stereo or 5.1."""
    import av

    layout = LAYOUTS[samples.shape[1]]
    with av.open(str(path), "w") as film:
        stream = film.add_stream(codec, rate=rate_hz, layout=layout)
        stream.bit_rate = bits_per_s
        for start in range(0, samples.shape[0], rate_hz):
            second = np.ascontiguousarray(samples[start : start + rate_hz].T)
            frame = av.AudioFrame.from_ndarray(second, format="fltp", layout=layout)
            frame.sample_rate, frame.pts, frame.time_base = rate_hz, start, Fraction(1, rate_hz)
            film.mux(stream.encode(frame))
        film.mux(stream.encode(None))

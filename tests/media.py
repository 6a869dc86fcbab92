"""Test media, made with PyAV: impulses in noise, in any container and codec that the wheel can write."""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from numpy.typing import NDArray

Samples = NDArray[np.float32]

RATE_HZ = 48_000
LAYOUTS = {1: "mono", 2: "stereo", 3: "3.0", 4: "quad", 6: "5.1", 8: "7.1"}


def impulses(frames: int, at: Sequence[int], *, channels: int = 1, seed: int = 0) -> Samples:
    """Return quiet noise with a short loud burst at each position, the same in all channels."""
    rng = np.random.default_rng(seed)
    samples = rng.uniform(-1e-3, 1e-3, (frames, channels))
    for position in at:
        length = min(96, frames - position)
        samples[position : position + length] += 0.7 * np.exp(-np.arange(length) / 24.0)[:, None]
    # whole 16-bit steps, so that every lossless codec keeps them
    return (np.rint(samples * 32_768) / 32_768).astype(np.float32)


def onsets(samples: NDArray[np.floating], *, threshold: float = 0.25, apart: int = 2_000) -> list[int]:
    """Return where the sound first exceeds the threshold, once per burst."""
    found: list[int] = []
    for position in np.flatnonzero(np.abs(samples) > threshold):
        if not found or position - found[-1] > apart:
            found.append(int(position))
    return found


def require_encoder(codec: str) -> None:
    """Skip the test where the wheel cannot write this codec."""
    if codec not in av.codecs_available:
        pytest.skip(f"this PyAV has no {codec} codec")
    try:
        av.codec.Codec(codec, "w")
    except av.codec.codec.UnknownCodecError:
        pytest.skip(f"this PyAV has no {codec} encoder")


def write_media(
    path: Path,
    tracks: Sequence[Samples],
    *,
    codec: str,
    rate_hz: int = RATE_HZ,
    container_format: str | None = None,
    picture_rate: Fraction | None = None,
    picture_codec: str = "mpeg4",
    picture_size: tuple[int, int] = (64, 64),
    picture_delay_s: float = 0.0,
    timecode: str | None = None,
    audio_delay_s: float = 0.0,
    dispositions: Sequence[av.stream.Disposition] = (),
    titles: Sequence[str] = (),
    container_options: dict[str, str] | None = None,
    lost_s: Sequence[tuple[float, float]] = (),
    silent_s: float = 0.0,
    tags: dict[str, str] | None = None,
) -> Path:
    """Write sound tracks, with a small picture where `picture_rate` is given; skips where the codec is missing.

    Packets of sound whose time lies in one of the ranges `lost_s` are left out; a film without any track of sound
    lasts `silent_s`.
    """
    require_encoder(codec)
    options = container_options or {}
    with av.open(str(path), "w", format=container_format, options=options) as container:
        container.metadata.update(tags or {})
        video: Any = None
        if picture_rate is not None:
            width, height = picture_size
            video = container.add_stream(picture_codec, rate=picture_rate, width=width, height=height)
            video.pix_fmt = "yuv420p"
        if timecode is not None:
            (container if video is None else video).metadata["timecode"] = timecode
        streams: list[Any] = []
        for index, samples in enumerate(tracks):
            stream: Any = container.add_stream(codec, rate=rate_hz, layout=LAYOUTS[samples.shape[1]])
            if index < len(dispositions):
                stream.disposition = dispositions[index]
            if index < len(titles):
                stream.metadata["title"] = titles[index]
            streams.append(stream)
        duration_s = tracks[0].shape[0] / rate_hz + audio_delay_s if tracks else silent_s
        if video is not None and picture_rate is not None:
            black, late = np.zeros((*picture_size[::-1], 3), np.uint8), round(picture_delay_s * picture_rate)
            for place in range(late, int(duration_s * picture_rate)):
                picture = av.VideoFrame.from_ndarray(black, format="rgb24")
                picture.pts, picture.time_base = place, 1 / picture_rate
                container.mux(video.encode(picture))
            container.mux(video.encode(None))
        for stream, samples in zip(streams, tracks, strict=True):
            for packet in encoded(stream, samples, rate_hz=rate_hz, start=round(audio_delay_s * rate_hz)):
                time_s = float(packet.pts * packet.time_base)
                if not any(start <= time_s < stop for start, stop in lost_s):
                    container.mux(packet)
    return path


def encoded(stream: Any, samples: Samples, *, rate_hz: int, start: int = 0) -> list[Any]:
    """Return the packets of one track, its last samples flushed."""
    packets: list[Any] = []
    for place in range(0, samples.shape[0], 4_096):
        block = np.ascontiguousarray(samples[place : place + 4_096])
        frame = av.AudioFrame.from_ndarray(block.reshape(1, -1), format="flt", layout=LAYOUTS[samples.shape[1]])
        frame.sample_rate = rate_hz
        frame.time_base = Fraction(1, rate_hz)
        frame.pts = start + place
        packets += stream.encode(frame)
    packets += stream.encode(None)
    return packets

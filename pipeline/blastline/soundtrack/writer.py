"""Writing the drive: one channel of 24-bit PCM, exactly as long as the film, with silence that takes no room."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..errors import OutputError
from ..model import Clip
from .bwf import RIFF_LIMIT, SAMPLE_BYTES, Cue, cue_chunks, header
from .track import PIECE

FULL_SCALE = 1 << 23
_TOP = FULL_SCALE - 1


def write_drive(
    path: Path,
    clips: Iterable[Clip],
    *,
    rate_hz: int,
    frames: int,
    time_reference: int = 0,
    cues: Sequence[Cue] = (),
    description: str = "",
    riff_limit: int = RIFF_LIMIT,
) -> None:
    """Write a drive of `frames` frames as a broadcast WAV; RF64 where it would exceed `riff_limit` bytes.

    The clips come in order and do not overlap; the last column of each is written. What none of them covers is zero,
    left as a hole in the file. A sample k/2^23 is stored exactly and 1.0 as the topmost step. Raises ValueError for
    a clip out of place or a sample outside [-1, 1], OutputError where the disk refuses.
    """
    if any(not 0 <= cue.sample <= frames for cue in cues):
        raise ValueError(f"a cue lies outside the {frames} frames of the drive")
    tail = cue_chunks(cues)
    head = header(
        frames=frames,
        rate_hz=rate_hz,
        time_reference=time_reference,
        description=description,
        tail=len(tail),
        riff_limit=riff_limit,
    )
    data_bytes = frames * SAMPLE_BYTES
    try:
        with path.open("wb") as file:
            file.write(head)
            _write_clips(file, clips, origin=len(head), rate_hz=rate_hz, frames=frames)
            end = len(head) + data_bytes + data_bytes % 2
            file.seek(end)
            file.write(tail)
            file.truncate(end + len(tail))
    except OSError as error:
        # a pipe that was closed is where progress is told: the file is none
        if isinstance(error, OutputError | BrokenPipeError) or error.errno is None:
            raise
        raise OutputError(f"{path}: cannot write the drive: {error.strerror}") from error


def write_excerpt(path: Path, pieces: Iterable[NDArray[np.float32]], *, rate_hz: int, channels: int) -> int:
    """Write a sound piece by piece, limited to full scale, as 16 bits; return how many frames it has.

    The pieces have the shape (frames, channels). Raises OutputError where the disk refuses.
    """
    import soundfile

    frames = 0
    try:
        with soundfile.SoundFile(path, "w", rate_hz, channels=channels, subtype="PCM_16", format="WAV") as file:
            for piece in pieces:
                file.write((np.clip(piece, -1.0, 1.0) * np.float32(32_767.0)).astype(np.int16))
                frames += piece.shape[0]
    except (OSError, soundfile.SoundFileError) as error:
        raise OutputError(f"{path}: cannot write an excerpt of the film: {error}") from error
    return frames


def _write_clips(file: BinaryIO, clips: Iterable[Clip], *, origin: int, rate_hz: int, frames: int) -> None:
    written = 0
    for clip in clips:
        span = clip.span
        if clip.rate_hz != rate_hz or span.start < written or span.stop > frames:
            raise ValueError(f"a clip at {clip.rate_hz} Hz, {span}, does not follow {written} of {frames} frames")
        file.seek(origin + span.start * SAMPLE_BYTES)
        for start in range(0, len(span), PIECE):
            file.write(_as_24_bit(clip.driving[start : start + PIECE], at=span.start + start))
        written = span.stop


def _as_24_bit(samples: NDArray[np.floating], *, at: int) -> bytes:
    """Return little-endian 24-bit samples."""
    steps = np.rint(samples.astype(np.float64) * FULL_SCALE)
    inside = np.abs(steps) <= FULL_SCALE  # False for NaN
    if not inside.all():
        worst = int(np.argmin(inside))
        raise ValueError(f"the drive is {samples[worst]} at sample {at + worst}; expected -1 to 1")
    whole = np.minimum(steps, _TOP).astype("<i4")
    return whole.view(np.uint8).reshape(-1, 4)[:, :SAMPLE_BYTES].tobytes()

"""Sound that a study writes: films that last as long as they are measured, and excerpts."""

import shutil
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from ..errors import OutputError


def write_sound(path: Path, samples: NDArray[Any], rate_hz: int, *, subtype: str = "PCM_16") -> None:
    """Write samples, shape (frames,) or (frames, channels), as WAV. Raises OutputError where the disk refuses."""
    import soundfile

    try:
        soundfile.write(path, samples, rate_hz, subtype=subtype)
    except soundfile.SoundFileError as error:
        left = shutil.disk_usage(path.parent).free
        raise OutputError(f"{path}: cannot write the sound: {left} bytes are left on the disk ({error})") from error

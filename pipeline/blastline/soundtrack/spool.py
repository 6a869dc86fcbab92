"""Decoded sound kept on disk, because decoding after a seek does not give the same samples."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from ..errors import OutputError
from ..model import Span
from .track import Samples

_SAMPLE_BYTES = 4


class Spool:
    """A nameless temporary file of float32 columns; it vanishes when it is closed, or with the process."""

    def __init__(self, folder: Path | None) -> None:
        """Make the file in `folder`, or where the system keeps such files. Raises OutputError where it cannot."""
        self._columns, self._folder = 1, folder or Path(tempfile.gettempdir())
        with self._refusing():
            self._file = tempfile.TemporaryFile(dir=self._folder)  # noqa: SIM115 - open as long as the track is

    def append(self, samples: Samples) -> None:
        """Add samples, shape (frames, columns), always as many columns. Raises OutputError where the disk is full."""
        self._columns = samples.shape[1]
        with self._refusing():
            self._file.write(samples.data)

    def finish(self) -> None:
        """Write out what is still buffered. Raises OutputError where the disk is full."""
        with self._refusing():
            self._file.flush()

    def read(self, span: Span) -> Samples:
        """Return the samples of a span, shape (frames, columns)."""
        frame_bytes = _SAMPLE_BYTES * self._columns
        self._file.seek(span.start * frame_bytes)
        data = self._file.read(len(span) * frame_bytes)
        return np.frombuffer(data, dtype=np.float32).reshape(-1, self._columns)

    def close(self) -> None:
        """Drop the file; what could not be written no longer matters."""
        with suppress(OSError):
            self._file.close()

    @contextmanager
    def _refusing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise OutputError(f"{self._folder}: cannot keep the decoded sound here: {error.strerror}") from error

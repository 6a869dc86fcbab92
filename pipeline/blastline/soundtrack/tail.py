"""Files as a decoder is to see them: from the first sample on, or as the plain WAV that they are."""

from io import RawIOBase
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer


class Tail(RawIOBase):
    """A file from some byte on, as if it were a file of its own."""

    def __init__(self, path: Path, start: int) -> None:
        """Open it."""
        self._file, self._start = path.open("rb", buffering=0), start
        self.seek(0)

    def seek(self, place: int, whence: int = 0) -> int:
        """Go to a place, counted from the start of the tail, from here, or from the end."""
        return self._file.seek(place + self._start if whence == 0 else place, whence) - self._start

    def tell(self) -> int:
        """Return the place, counted from the start of the tail."""
        return self._file.tell() - self._start

    def readinto(self, buffer: "WriteableBuffer", /) -> int | None:
        """Fill a buffer, as far as there is something."""
        return self._file.readinto(buffer)

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()


class PlainWave(Tail):
    """An RF64 or BW64 whose sizes of 64 bits are wrong: as a RIFF, in which they are one more chunk of no meaning."""

    _FORM = b"RIFF"

    def __init__(self, path: Path) -> None:
        """Open it."""
        super().__init__(path, 0)

    def readinto(self, buffer: "WriteableBuffer", /) -> int | None:
        """Fill a buffer, as far as there is something."""
        place, view = self.tell(), memoryview(buffer)
        count = super().readinto(view)
        over = self._FORM[place : place + (count or 0)]
        view[: len(over)] = over
        return count

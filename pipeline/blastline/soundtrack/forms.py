"""How WAV, RF64, BW64, W64, AIFF and CAF write their chunks: where the first one is, and what stands before each."""

import struct
from dataclasses import dataclass
from typing import BinaryIO


@dataclass(frozen=True)
class WholeSize:
    """Where a file says how long all of it is: at which byte, as what number, and from which byte on that counts."""

    place: int
    number: struct.Struct
    counted_from: int


@dataclass(frozen=True)
class Form:
    """A family of files: `first` is where its chunks begin, `data_preamble` how much stands before the samples.

    `layout_name` is the chunk with a layout of Core Audio; a WAV says so in its format chunk. `whole_size` is None
    where no size of the whole file is told.
    """

    first: int
    head: struct.Struct
    alignment: int = 1
    size_includes_head: bool = False
    data_name: bytes = b"data"
    data_preamble: int = 0
    layout_name: bytes = b""
    is_wave: bool = False
    whole_size: WholeSize | None = None

    @property
    def byte_order(self) -> str:
        """Return the byte order of its numbers, as `struct` writes it."""
        return self.head.format[0]

    def chunk_at(self, file: BinaryIO, place: int, file_bytes: int) -> tuple[bytes, int, int] | None:
        """Return the name of the chunk that begins here, where its body does and how long that claims to be.

        None where the file ends before.
        """
        if place + self.head.size > file_bytes:
            return None
        file.seek(place)
        name, size = self.head.unpack(file.read(self.head.size))
        # a size that includes the head and is smaller than it was never written: nothing is declared
        declared = max(0, size - self.head.size) if self.size_includes_head else size
        return name, place + self.head.size, declared

    def after(self, body: int, size: int) -> int:
        """Return where the next chunk begins: a size is padded, wherever the chunk itself begins."""
        return body + size + -size % self.alignment

    def places_after(self, end: int) -> list[int]:
        """Return where what follows a chunk may begin: some programs forget to pad an odd size, others do in a CAF."""
        return sorted({end, end + end % 2, self.after(0, end)})


_LITTLE, _BIG = (WholeSize(4, struct.Struct(number), counted_from=8) for number in ("<I", ">I"))

FORMS = {
    b"RIFF": Form(12, struct.Struct("<4sI"), alignment=2, is_wave=True, whole_size=_LITTLE),
    b"RF64": Form(12, struct.Struct("<4sI"), alignment=2, is_wave=True, whole_size=_LITTLE),
    b"BW64": Form(12, struct.Struct("<4sI"), alignment=2, is_wave=True, whole_size=_LITTLE),
    b"RIFX": Form(12, struct.Struct(">4sI"), alignment=2, is_wave=True, whole_size=_BIG),
    b"FORM": Form(
        12,
        struct.Struct(">4sI"),
        alignment=2,
        data_name=b"SSND",
        data_preamble=8,
        layout_name=b"CHAN",
        whole_size=_BIG,
    ),
    b"riff": Form(
        40,
        struct.Struct("<4s12xq"),
        alignment=8,
        size_includes_head=True,
        whole_size=WholeSize(16, struct.Struct("<q"), counted_from=0),
    ),
    b"caff": Form(8, struct.Struct(">4sq"), data_preamble=4, layout_name=b"chan"),
}


def is_name(name: bytes) -> bool:
    """Return whether these bytes can be the name of a chunk, which is text."""
    return all(0x20 <= letter < 0x7F for letter in name)

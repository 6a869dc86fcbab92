"""Files that hold more sound than their header declares: how that is told from what properly follows sound.

RIFF size  fmt  data 1000 [ 1000 bytes ][ 1.7 MB that are no chunk ]    more sound, the size is wrong
RIFF size  fmt  data n    [  n bytes   ][ LIST ][ id3 ][ zeros     ]    all as it should be
"""

from typing import BinaryIO

from .appended import BEGINNING_BYTES, begins_file, behind_zeros, find_begun
from .forms import Form, is_name

_LEAST_BYTES = 4_096
"""Less than this is nothing that could be heard; programs leave all kinds of crumbs."""

_KNOWN = frozenset(
    b"LIST INFO bext iXML axml chna cart cue smpl inst plst note labl ltxt fact PEAK levl link umid minf elm1 regn "
    b"JUNK junk PAD pad FLLR Fake _PMX DISP acid strc dbmd MD5 afsp ovwf qlty mext SMED ubxt id3 list mark summ "
    b"COMM MARK INST MIDI AESD APPL COMT NAME AUTH ANNO FVER CHAN ID3 "
    b"free uuid info regn edct pakt kuki chan desc midi peak strg".split()
)
_TAGS = (b"ID3", b"TAG", b"APETAGEX", b"LYRICSBEGIN", b"RIFF", b"RF64", b"BW64", b"caff")
"""What programs put behind a file that is no chunk: tags of music players, another file."""


def more_follows(file: BinaryIO, end: int, file_bytes: int, form: Form) -> bool:
    """Return whether what follows the declared end of the sound is no chunk, no tag, no padding and no other file."""
    if file_bytes - end < _LEAST_BYTES:
        return False
    if any(_is_proper(file, place, file_bytes, form) for place in form.places_after(end)):
        return False
    behind = behind_zeros(file, end)
    return behind < file_bytes and find_begun(file, [behind], file_bytes) is None


def _is_proper(file: BinaryIO, place: int, file_bytes: int, form: Form) -> bool:
    """Return whether a chunk of a known kind, a tag, or a row of chunks up to the end or another file begins here."""
    file.seek(place)
    start = file.read(BEGINNING_BYTES)
    if start.startswith(_TAGS) or start[:4].rstrip(b" \0") in _KNOWN or begins_file(start):
        return True
    while (chunk := form.chunk_at(file, place, file_bytes)) is not None:
        name, body, size = chunk
        if size < 0 or not is_name(name):
            return False
        place = form.after(body, size)
        if find_begun(file, form.places_after(body + size), file_bytes) is not None:
            return True
    return place < file_bytes + form.alignment

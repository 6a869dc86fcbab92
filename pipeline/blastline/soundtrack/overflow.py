"""Files that hold more sound than their header declares: how that is told from what properly follows sound.

RIFF size  fmt  data 1000 [ 1000 bytes ][ 1.7 MB that are no chunk ]    more sound, the size is wrong
RIFF size  fmt  data n    [  n bytes   ][ LIST ][ id3 ][ zeros     ]    all as it should be
RIFF size  fmt  data n    [  n bytes   ][ any  ][ any ][ ID3 tag   ]    so is this, whatever the chunks are called
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
    return not _is_padding(file, end, file_bytes)


def _is_proper(file: BinaryIO, place: int, file_bytes: int, form: Form) -> bool:
    """Return whether a chunk of a known kind, a tag or another file begins here, or chunks up to one, to padding or to
    the end of the file.
    """
    is_behind_chunks = False
    while (chunk := form.chunk_at(file, place, file_bytes)) is not None:
        name, body, size = chunk
        file.seek(place)
        start = file.read(BEGINNING_BYTES)
        if start.startswith(_TAGS) or name.rstrip(b" \0") in _KNOWN or begins_file(start):
            return True
        if size < 0 or not is_name(name):
            return is_behind_chunks and _is_padding(file, place, file_bytes)
        place, is_behind_chunks = form.after(body, size), True
        if find_begun(file, form.places_after(body + size), file_bytes) is not None:
            return True
    return place < file_bytes + form.alignment


def _is_padding(file: BinaryIO, place: int, file_bytes: int) -> bool:
    """Return whether nothing but zeros follows, up to the end of the file or to another file."""
    behind = behind_zeros(file, place)
    return behind >= file_bytes or find_begun(file, [behind], file_bytes) is not None

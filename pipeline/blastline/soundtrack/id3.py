"""The tag that music players put before a file, or between two (ID3 2.4.0, 3.1)."""

ID3_NAME, ID3_HEAD_BYTES = b"ID3", 10


def id3_bytes(head: bytes) -> int:
    """Return the size in bytes of the tag that begins with these ten, its head included.

    Of the last four bytes of the head, which tell the rest, each counts seven bits.
    """
    size = 0
    for byte in head[6:ID3_HEAD_BYTES]:
        size = size << 7 | byte & 0x7F
    return ID3_HEAD_BYTES + size

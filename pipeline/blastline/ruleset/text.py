"""Text that users bring, in UTF-8 with or without a mark: the encoding that TOML has, and what spreadsheets offer."""

import codecs
from pathlib import Path

from ..errors import RuleError


def read_utf_8(path: Path, *, kind: str) -> str:
    """Return what is in a file that should be of a `kind` of text; RuleError tells the line of another encoding."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise RuleError(f"{path}: cannot be read: {error.strerror}") from error
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) or b"\0" in content[:2]:
        raise RuleError(f"{path}: line 1: begins as UTF-16 does; expected {kind} in UTF-8")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        # the mark is no part of what the error counts in
        before = content[: error.start + len(content) - len(error.object)]
        line = before.count(b"\n") + 1
        byte = error.object[error.start]
        raise RuleError(f"{path}: line {line}: the byte 0x{byte:02x} is not UTF-8; expected {kind} in UTF-8") from None

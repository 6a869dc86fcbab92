"""The gain in a label: where this program writes it, or at the end, where people type one; elsewhere it is a word."""

import re
from decimal import Decimal
from typing import get_args

from ...errors import TimelineError
from ...model import DriveModel
from .row import Edit, EditedFile

_NUMBER = r"([+\-\u2212\u2013]?\s?\d+(?:[.,]\d+)?(?:e-\d{1,3})?)"
_GAIN = rf"\bgain[\s:=]*{_NUMBER}\s*dB\b"

_AT_THE_END = re.compile(rf"{_GAIN}[\s.,;!]*$", re.IGNORECASE)
_AS_EXPORTED = re.compile(rf"\bdBFS(?: (?:{'|'.join(get_args(DriveModel))}))? {_GAIN}", re.IGNORECASE)
_ANY = re.compile(rf"\bgain[\s:=]*{_NUMBER}(?:\s*dB\b)?|(?<![\w.]){_NUMBER}\s*dB\b", re.IGNORECASE)
"""What somebody may have meant as a gain."""

_AS_DIGITS = str.maketrans({"\u2212": "-", "\u2013": "-", ",": "."})
"""A true minus, the dash that some systems make of a hyphen, and the comma as they stand in a program's number."""


def gain_in_label(edited: EditedFile, edit: Edit, identity: str) -> Decimal | None:
    """Return the gain that a label says behind its id, in dB; None where it says none.

    Raises TimelineError where it says two.
    """
    found = {_decimal(place[1]) for place in _places(edit, identity)}
    if len(found) > 1:
        both = " and ".join(f"{gain} dB" for gain in sorted(found))
        raise TimelineError(f"{edited.path}: {edit.place}: {edit.text!r}: two gains, {both}; expected one, at the end")
    return next(iter(found), None)


def unread_gains(edit: Edit, identity: str) -> list[str]:
    """Return what a label says that may be meant as a gain and is not read as one."""
    read = {place.end(1) for place in _places(edit, identity)}
    found = _ANY.finditer(edit.text.removeprefix(identity))
    return [place[0].strip() for place in found if read.isdisjoint((place.end(1), place.end(2)))]


def _places(edit: Edit, identity: str) -> list[re.Match[str]]:
    said = edit.text.removeprefix(identity)
    return [place for kind in (_AS_EXPORTED, _AT_THE_END) if (place := kind.search(said))]


def _decimal(number: str) -> Decimal:
    return Decimal("".join(number.split()).translate(_AS_DIGITS))

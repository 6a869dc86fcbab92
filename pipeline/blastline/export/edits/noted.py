"""What a user has to know of edited rows: what of them is not read, and what stays though a row no longer says it."""

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from ...misfits import listed
from .gains import gain_in_label, unread_gains
from .row import EditedFile, Pair

if TYPE_CHECKING:
    from .matching import Wish


def notes_on(edited: EditedFile, pairs: Sequence[Pair], wishes: Sequence["Wish"]) -> Iterator[str]:
    """Yield the notes on rows, each with what is wished by it."""
    unread = [
        f"{said!r} of {wish.id}"
        for pair, wish in zip(pairs, wishes, strict=True)
        for said in unread_gains(pair.edit, pair.id or "")
    ]
    if unread:
        yield f"not used: {listed(unread)}; a gain stands at the end of a label or name, written as gain -6 dB"
    for known, so in ((True, "kept as in the original"), (False, "as usual")):
        empty: dict[str, list[str]] = {}
        for pair, wish in zip(pairs, wishes, strict=True):
            if known == (pair.was is not None):
                for name in _unsaid(edited, pair, wish):
                    empty.setdefault(name, []).append(wish.id)
        if empty:
            told = "; ".join(f"{name} of {listed(sorted(ids))}" for name, ids in empty.items())
            yield f"{so}, since the file says nothing there: {told}"


def _unsaid(edited: EditedFile, pair: Pair, wish: "Wish") -> Iterable[str]:
    """Yield the names of what somebody may have set in an earlier round, and a row says no more.

    Of a row whose original is not known only a cell tells that, in a table that was exported.
    """
    edit, was = pair.edit, pair.was
    if was is None:
        yield from edit.emptied if edit.blast_start is not None else ()
        return
    if was.gain_db and edit.gain_db is None and gain_in_label(edited, edit, pair.id or "") is None:
        yield "gain_db"
    for name in edit.emptied:
        if name == "confidence" or (name != "gain_db" and wish.unmoved):
            yield name

"""What a stream is by its title, as people and programs write it: a channel (Left, Ls, LFE), or speech over a film."""

import re
from collections.abc import Sequence

_SIGNS = re.compile(r"[\W_]+")
_SIDES = {"L": "left", "R": "right"}
_ON_A_SIDE = {
    "F{0}": "{0} {1} f{0} front{1} {1}front",
    "S{0}": "{0}s s{0} {0}ss {1}surround surround{1} side{1} {1}side {1}sidesurround sidesurround{1} surroundside{1}",
    "B{0}": "b{0} {0}b {0}rs {0}sr {0}bs back{1} {1}back rear{1} {1}rear {1}rearsurround {1}surroundrear "
    "rearsurround{1} surroundrear{1} {1}backsurround backsurround{1} surroundback{1}",
    "F{0}C": "{0}c f{0}c {1}center {1}centre front{1}center front{1}centre",
    "D{0}": "{0}t {0}o d{0} {1}total {1}only",
}
"""Titles without signs and spaces by the channel, of which {0} is the letter and {1} the word of its side."""

_IN_THE_MIDDLE = {
    "FC": "c center centre fc frontcenter frontcentre centerfront centrefront",
    "LFE": "lfe sub subwoofer lowfrequency lowfrequencyeffect lowfrequencyeffects",
    "BC": "bc cs backcenter backcentre rearcenter rearcentre centersurround centresurround surroundcenter "
    "surroundcentre",
}
_NAMES = {title: name for name, titles in _IN_THE_MIDDLE.items() for title in titles.split()} | {
    title: name.format(letter)
    for letter, word in _SIDES.items()
    for name, titles in _ON_A_SIDE.items()
    for title in titles.format(letter.lower(), word).split()
}
_PAIRS = tuple(tuple(name.format(letter) for letter in _SIDES) for name in _ON_A_SIDE)

_SPOKEN_OVER = re.compile(r"[ck]omm?ent|des[ck]r(ip|iz|yp)", re.IGNORECASE)
"""Commentaries and audio descriptions: the words are nearly the same in most languages of Europe."""


def is_spoken_over(title: str | None) -> bool:
    """Return whether a title is that of speech over the film's sound.

    >>> is_spoken_over("Director's Commentary"), is_spoken_over("Surround 5.1")
    (True, False)
    """
    return _SPOKEN_OVER.search(title or "") is not None


def channel_of(title: str | None) -> str | None:
    """Return the channel that a title is the name of, as FFmpeg calls it; None for any other title.

    >>> channel_of("Surround Left"), channel_of("Dialogue")
    ('SL', None)
    """
    return _NAMES.get(_SIGNS.sub("", (title or "").casefold()))


def titled_layout(titles: Sequence[str | None]) -> tuple[str, ...]:
    """Return what channels the titles name, where all do, each another, and they make a whole layout; else nothing.

    A layout is whole that has left and right, and of each further pair both or none, or is the stereo mix that goes
    with such a one: what lacks a channel, or has one twice, may be titles of something else.
    """
    names = tuple(name for title in titles if (name := channel_of(title)) is not None)
    is_whole = all((left in names) == (right in names) for left, right in _PAIRS)
    is_whole = is_whole and ("FL" in names or set(names) == {"DL", "DR"})
    return names if is_whole and len(set(names)) == len(titles) else ()

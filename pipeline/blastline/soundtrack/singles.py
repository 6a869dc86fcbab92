"""Streams of one channel each: which channels these are, and what a user can do where nobody joined them."""

from collections.abc import Sequence

from ..streams import streams_text

_LAYOUTS = {
    2: ("stereo", ("FL", "FR")),
    6: ("5.1", ("FL", "FR", "FC", "LFE", "SL", "SR")),
    8: ("7.1", ("FL", "FR", "FC", "LFE", "SL", "SR", "BL", "BR")),
}
"""The order in which masters are delivered, L R C LFE Ls Rs Lrs Rrs; of 7.1, WAV has the rear pair before the sides."""


def layout_of(names: Sequence[Sequence[str] | None]) -> tuple[str, ...]:
    """Return what joined streams are, given what each calls its channel: that where all differ, else the usual order.

    Empty where there is no usual order for so many, as the fourth of them may be the low-frequency channel, or where
    one calls itself otherwise, as a stereo mix beside the film does. Each may call itself FC, which is mono as well.
    """
    said = tuple(name for each in names for name in each or ())
    if len(set(said)) == len(said) == len(names):
        return said
    _, usual = _LAYOUTS.get(len(names), ("", ()))
    fits = all(each in (None, ("FC",), (name,)) for each, name in zip(names, usual, strict=False))
    return usual if fits else ()


def joining_hint(heard: int, singles: Sequence[int]) -> str:
    """Return the line for a user of whose streams of one channel, `singles`, only the one that is `heard` is."""
    fitting = [count for count in _LAYOUTS if count <= len(singles)]
    # of many streams the last two are often a stereo mix, so both are told; no film is left and right of six
    counts = [count for count in fitting if count > 2] or fitting
    ways = [f"--stream {streams_text(singles[:count])} joins {count} as {_LAYOUTS[count][0]}" for count in counts]
    return (
        f"only sound stream {heard} of {len(singles)} with one channel each is heard: {', '.join(ways)}; "
        "a single number chooses another"
    )

"""Streams of one channel each: which channels these are, and what a user can do where nobody joined them."""

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from ..streams import streams_text
from .facts import title_of
from .layouts import ChannelNames, clear
from .mix import has_mains
from .probe import told_start
from .titles import channel_of, titled_layout

if TYPE_CHECKING:
    from av.audio.stream import AudioStream
    from av.container import InputContainer

_LAYOUTS = {
    2: ("stereo", ("FL", "FR")),
    6: ("5.1", ("FL", "FR", "FC", "LFE", "SL", "SR")),
    8: ("7.1", ("FL", "FR", "FC", "LFE", "SL", "SR", "BL", "BR")),
}
"""The order in which masters are delivered, L R C LFE Ls Rs Lrs Rrs; of 7.1, WAV has the rear pair before the sides."""

_KINDS = {frozenset(layout): kind for kind, layout in _LAYOUTS.values()} | {
    frozenset(("DL", "DR")): "stereo",
    frozenset(("FL", "FR", "FC", "LFE", "BL", "BR")): "5.1",
}


def layout_of(names: Sequence[Sequence[str] | None], titles: Sequence[str | None] = ()) -> tuple[str, ...]:
    """Return what joined streams are, given what each calls its channel, and its title.

    That is what the names say where all differ, else what all titles say, else the usual order. Empty where there is no
    usual order for so many, as the fourth of them may be the low-frequency channel, or where one calls itself, or has a
    title, otherwise, as a stereo mix beside the film does. Each may call itself FC, which is mono as well.
    """
    said = tuple(name for each in names for name in each or ())
    if len(set(said)) == len(said) == len(names):
        return said
    titled = titled_layout(titles)
    if titled and _fits(names, titled):
        return titled
    _, usual = _LAYOUTS.get(len(names), ("", ()))
    fits = all(channel_of(title) in (None, name) for title, name in zip(titles, usual, strict=False))
    return usual if fits and _fits(names, usual) else ()


def _fits(names: Sequence[Sequence[str] | None], layout: Sequence[str]) -> bool:
    """Return whether none of the streams calls its channel otherwise."""
    return all(each in (None, ("FC",), (name,)) for each, name in zip(names, layout, strict=False))


def unjoined(container: "InputContainer", chosen: "AudioStream", names: ChannelNames) -> str | None:
    """Return what to tell of streams that have one channel, as the one that was chosen has, and may go with it.

    Masters keep 5.1 in six of them.
    """
    streams = container.streams.audio
    singles = [each for each in streams if len(names.get(each.index, ())) == 1 and _goes_with(each, chosen)]
    if chosen not in singles or len(singles) == 1:
        return None
    called = [clear(names[each.index]) for each in singles]
    return joining_hint(streams.index(chosen), [*map(streams.index, singles)], called, [*map(title_of, singles)])


def _goes_with(stream: "AudioStream", chosen: "AudioStream") -> bool:
    """Return whether two streams can be joined: at one rate, and from one moment on as far as it is known."""
    rate_hz, starts = chosen.codec_context.sample_rate, (told_start(stream), told_start(chosen))
    late_s = Fraction(0) if starts[0] is None or starts[1] is None else starts[0] - starts[1]
    return stream.codec_context.sample_rate == rate_hz and abs(late_s) * rate_hz < 1


def joining_hint(
    heard: int,
    singles: Sequence[int],
    names: Sequence[Sequence[str] | None] = (),
    titles: Sequence[str | None] = (),
) -> str:
    """Return the line for a user of whose streams of one channel, `singles`, only the one that is `heard` is.

    What it says to type is what is known to be a layout by the names and titles of the streams; where nothing is, their
    mean.
    """
    known = {
        count: layout
        for count in range(2, len(singles) + 1)
        if has_mains(layout := layout_of((names or (None,) * len(singles))[:count], titles[:count]))
    }
    fitting = [count for count, layout in known.items() if frozenset(layout) in _KINDS or count == max(known)]
    # of many streams the last two are often a stereo mix, so both are told; no film is left and right of six
    counts = [count for count in fitting if count > 2] or fitting
    ways = [f"--stream {streams_text(singles[:count])} joins {count} as {_kind(known[count])}" for count in counts]
    if not ways:
        every = ",".join(map(str, range(len(singles))))
        ways = [f"--stream {streams_text(singles)} --mix {every} joins {len(singles)} and hears their mean"]
    return (
        f"only sound stream {heard} of {len(singles)} with one channel each is heard: {', '.join(ways)}; "
        "a single number chooses another"
    )


def _kind(layout: Sequence[str]) -> str:
    return _KINDS.get(frozenset(layout), " ".join(layout))

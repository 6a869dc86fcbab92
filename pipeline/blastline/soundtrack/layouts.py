"""Which channels the streams of a film have, asked in the one way that PyAV survives.

Behind a layout whose channels are in an order of their own, as QuickTime and MXF tell it, FFmpeg keeps a list. PyAV
shares that list with whatever it is asked about, a decoder or a frame, and both free it, which ends the process:

container ─► decoder ─────────► frame, frame, ...    each frame has a copy of the decoder's layout and its list
                └► AudioLayout    └► AudioLayout     frees a list that is not its own

So a decoder gets a layout without a list before it is opened, and is never asked again.
"""

import ctypes
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from av import AudioFrame
    from av.audio.layout import AudioLayout
    from av.container import InputContainer

ChannelNames = Mapping[int, tuple[str, ...]]
"""What the channels of each sound stream that can be decoded are called, by its index in the file."""

_USUAL = ("FL", "FR", "FC", "LFE", "BL", "BR", "FLC", "FRC", "BC", "SL", "SR")
"""The loudspeakers of cinemas, in FFmpeg's own order."""


def taken_names(container: "InputContainer") -> ChannelNames:
    """Return the names of the channels of each stream, and leave its decoder no list of them. Not to be asked twice."""
    names = {}
    for stream in container.streams.audio:
        context = stream.codec_context
        if context is None:
            continue
        layout = context.layout
        if layout.nb_channels:
            # now `layout` alone has the list, and may free it
            context.layout = f"{layout.nb_channels} channels" if _is_listed(layout) else layout.name
        names[stream.index] = _names(layout)
    return names


def named(frame: "AudioFrame", told: tuple[str, ...]) -> tuple[str, ...] | None:
    """Return what the channels of a frame are called: as its decoder says, else as was `told`; None if unclear."""
    own = _names(frame.layout)
    return next((names for names in map(clear, (own, told)) if names is not None and len(names) == len(own)), None)


def clear(names: tuple[str, ...]) -> tuple[str, ...] | None:
    """Return names of channels, None where one is missing or there twice."""
    return names if len(set(names)) == len(names) and "NONE" not in names else None


def keep_list(frame: "AudioFrame") -> None:
    """Have the list of a frame whose decoder made one itself, as that of xHE-AAC can, freed once: with the frame.

    What asked for it is kept for good, 48 bytes, 16 MB in two hours.
    """
    if _is_listed(frame.layout) and not _is_in_usual_order(frame.layout):
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(frame.layout))


def _is_listed(layout: "AudioLayout") -> bool:
    """Return whether nothing but its channels names a layout, as in '2 channels (FC+FL)': some have a list behind."""
    return " channels (" in layout.name or "+" in layout.name


def _is_in_usual_order(layout: "AudioLayout") -> bool:
    """Return whether the channels are in an order for which FFmpeg needs no list."""
    places = [_USUAL.index(name) for name in _names(layout) if name in _USUAL]
    return len(places) == layout.nb_channels and places == sorted(set(places))


def _names(layout: "AudioLayout") -> tuple[str, ...]:
    return tuple(channel.name for channel in layout.channels)

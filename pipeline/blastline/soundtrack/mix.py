"""Which channels become which column of the mixed soundtrack.

    mains    the picture-wide sound, by the weights of ITU-R BS.775; the low-frequency channel is left out
    lfe      the low-frequency channel drives, detection listens to the mains
    center   the centre channel alone
    all      mains plus the low-frequency channel drive, detection listens to the mains
    0,2,5    the mean of these channels, counted from 0

The sides are what the mains hold beside their middle: without the centre channel, or half the difference of a pair.

The first column is what detection hears, the last one is what drives. The weights are not normalised: a shot at full
scale keeps its level in the channel where it was mixed, and the sum of several channels may exceed 1. The exception is
a plain pair, which is averaged, so that a mono film and the same film as two equal channels give the same drive.
"""

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import SoundtrackError
from ..plurals import counted

Matrix = NDArray[np.float32]

LFE_GAIN = 10.0**0.5
"""The low-frequency channel is mixed 10 dB low on the medium and raised in the cinema."""

_HEARS_MAINS = ("mains", "lfe", "all")
_NAMED = (*_HEARS_MAINS, "center")
_CHANNEL = re.compile("[0-9]{1,6}")
_HALF_POWER = 0.5**0.5
_WEIGHTS = {"FL": _HALF_POWER, "FR": _HALF_POWER, "FLC": _HALF_POWER, "FRC": _HALF_POWER, "FC": 1.0}
_OTHER_WEIGHT = 0.5
_LOW = frozenset({"LFE", "LFE2"})
_TOTAL = {"DL": "FL", "DR": "FR"}
"""A ready-made stereo version of the channels beside it, which is not mixed with them; alone, it is the film."""

_USUAL_ORDER = {
    1: ("FC",),
    2: ("FL", "FR"),
    3: ("FL", "FR", "FC"),
    4: ("FL", "FR", "BL", "BR"),
    5: ("FL", "FR", "FC", "BL", "BR"),
    6: ("FL", "FR", "FC", "LFE", "BL", "BR"),
    7: ("FL", "FR", "FC", "LFE", "BC", "SL", "SR"),
    8: ("FL", "FR", "FC", "LFE", "BL", "BR", "SL", "SR"),
}


def mix_matrix(layout: Sequence[str] | None, channels: int, mix: str) -> Matrix:
    """Return the weights, shape (channels, columns), with one column or two (heard, driving).

    `layout` names the channels as FFmpeg does (FL, FR, FC, LFE, SL, ...); where it is None the usual order for that
    number of channels is taken, where it is empty none is. Raises SoundtrackError where the mix asks for channels that
    are not there, or not known.
    """
    if mix not in _NAMED:
        return _mean_of(_indices(mix, channels), channels)
    names = names_of(layout, channels)
    if not names:
        raise SoundtrackError(
            f"mix {mix!r}: the file does not say what its {channels} channels are; "
            f"choose channels by number, 0 to {channels - 1}"
        )
    if mix == "center":
        return _mean_of([_place_of("FC", names, mix)], channels)
    mains = _mains(names)
    if mix == "mains" or (mix == "all" and not _LOW & set(names)):
        return mains[:, None]
    low = np.zeros(channels, dtype=np.float32)
    low[_place_of("LFE", names, mix)] = LFE_GAIN
    return np.stack([mains, low if mix == "lfe" else mains + low], axis=1)


def mix_name(mix: str) -> str:
    """Return a mix as timelines have it: numbers of channels in order, since in no other are they another sound.

    >>> mix_name("2, 0"), mix_name("mains")
    ('0,2', 'mains')
    """
    parts = [part.strip() for part in mix.split(",")]
    if mix in _NAMED or not all(_CHANNEL.fullmatch(part) for part in parts):
        return mix
    return ",".join(map(str, sorted(map(int, parts))))


def heard_mix(mix: str) -> str:
    """Return the mix that detection listens to: the mains with those that only drive."""
    return "mains" if mix in _HEARS_MAINS else mix_name(mix)


def names_of(layout: Sequence[str] | None, channels: int) -> tuple[str, ...]:
    """Return what the channels are called; those of the usual order where the file does not say, else nothing.

    Left and right total, as files call a stereo mix with the surround in it, are left and right where nothing else is.
    """
    names = _USUAL_ORDER.get(channels, ()) if layout is None else tuple(layout)
    if all(name in _TOTAL for name in names):
        names = tuple(_TOTAL[name] for name in names)
    return names if len(names) == channels else ()


def has_mains(names: Sequence[str]) -> bool:
    """Return whether channels of these names have a main one among them."""
    return bool(_mains_of(names_of(names, len(names))))


def summing_order(layout: Sequence[str] | None, channels: int) -> tuple[int, ...]:
    """Return the channels in the order in which they are summed: by name, so that no other order is another sound."""
    names = names_of(layout, channels)
    known = [*_USUAL_ORDER[8], *_WEIGHTS]
    if len(set(names)) < channels:
        return tuple(range(channels))
    ranks = [(known.index(name) if name in known else len(known), name) for name in names]
    return tuple(sorted(range(channels), key=ranks.__getitem__))


def sides_matrix(layout: Sequence[str] | None, channels: int, mix: str) -> Matrix | None:
    """Return the weights, shape (channels, 1), of what the mains hold beside their middle; None where nothing does.

    Of a film with a centre channel these are the mains without it. Of a pair, half the difference: the middle is what
    both play alike, and what they play against each other cancels in the mains. None for a single main channel, for
    others without a centre, and where the mix says what to listen to.
    """
    names = names_of(layout, channels)
    mains = _mains_of(names)
    centre = centre_of(layout, channels)
    is_pair = len(mains) == 2 and "FC" not in mains
    if mix not in _HEARS_MAINS or not (is_pair or centre is not None):
        return None
    weights = _mains(names)[:, None]
    if centre is not None:
        weights[centre] = 0.0
    else:
        _, right = (channel for channel in summing_order(layout, channels) if names[channel] in mains)
        weights[right] *= -1.0
    return weights


def centre_of(layout: Sequence[str] | None, channels: int) -> int | None:
    """Return the centre channel, None where a film has none with others on either side."""
    names = names_of(layout, channels)
    return names.index("FC") if "FC" in names and len(_mains_of(names)) > 2 else None


def as_front(heard: NDArray[np.float32], sides: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return left, right and centre, shape (frames, 3), that are heard like this, as a whole and without the centre."""
    side = sides * np.float32(0.5 / _HALF_POWER)
    return np.stack([side, side, heard - sides], axis=1)


def is_identity(matrix: Matrix) -> bool:
    """Return whether the mix would change nothing: one channel, taken as it is."""
    return matrix.shape == (1, 1) and bool(matrix[0, 0] == 1.0)


def mixed(samples: NDArray[np.float32], matrix: Matrix, order: Sequence[int] | None = None) -> NDArray[np.float32]:
    """Return the columns, shape (frames, columns); channels are summed in the given order, else as they come.

    Each sample is summed in the same order whatever the block is, which a matrix product does not promise: so a block
    and a cut agree to the bit.
    """
    if is_identity(matrix):
        return samples
    columns = np.empty((samples.shape[0], matrix.shape[1]), dtype=np.float32)
    for total, weights in zip(columns.T, matrix.T, strict=True):
        first, *others = np.flatnonzero(weights) if order is None else [c for c in order if weights[c]]
        np.multiply(samples[:, first], weights[first], out=total)
        for channel in others:
            total += samples[:, channel] * weights[channel]
    return columns


def _indices(mix: str, channels: int) -> list[int]:
    parts = [part.strip() for part in mix.split(",")]
    if not all(_CHANNEL.fullmatch(part) for part in parts):
        raise SoundtrackError(
            f"mix {mix!r}: expected mains, lfe, center, all, or channel numbers counted from 0, such as 0,2"
        )
    indices = [int(part) for part in parts]
    for index in indices:
        if index >= channels:
            there = f"the sound has {counted(channels, 'channel')}, counted from 0"
            raise SoundtrackError(f"mix {mix!r}: there is no channel {index}; {there}")
        if indices.count(index) > 1:
            raise SoundtrackError(f"mix {mix!r}: names channel {index} twice")
    return indices


def _mean_of(indices: Sequence[int], channels: int) -> Matrix:
    matrix = np.zeros((channels, 1), dtype=np.float32)
    for index in indices:
        matrix[index, 0] = 1.0 / len(indices)
    return matrix


def _place_of(name: str, names: Sequence[str], mix: str) -> int:
    if name not in names:
        raise SoundtrackError(
            f"mix {mix!r}: there is no {name} channel among {', '.join(names)}; choose mains or channel numbers"
        )
    return names.index(name)


def _mains_of(names: Sequence[str]) -> list[str]:
    return [name for name in names if name not in _LOW | _TOTAL.keys()]


def _mains(names: Sequence[str]) -> Matrix:
    mains = _mains_of(names)
    if not mains:
        raise SoundtrackError(f"the sound has no main channel among {', '.join(names)}; choose channels by number")
    if len(mains) == 1:
        weights = {mains[0]: 1.0}
    elif len(mains) == 2:
        weights = dict.fromkeys(mains, 0.5)
    else:
        weights = {name: _WEIGHTS.get(name, _OTHER_WEIGHT) for name in mains}
    return np.array([weights.get(name, 0.0) for name in names], dtype=np.float32)

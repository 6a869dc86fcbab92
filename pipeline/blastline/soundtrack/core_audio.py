"""The channel layouts of Core Audio, as CAF (`chan`) and AIFF (`CHAN`) name them: Apple, Core Audio Format 1.0.

A layout is a tag that stands for an order of channels, a mask of loudspeakers, or a label for each channel.
"""

import struct

_HEAD = struct.Struct(">III")  # tag, mask, number of descriptions
_DESCRIPTION = struct.Struct(">I16x")  # label, then flags and coordinates
_BY_LABELS, _BY_MASK = 0, 1

# by label of a channel; surrounds of which there are two pairs are side and rear
_LABELS = {
    1: "FL",
    2: "FR",
    3: "FC",
    4: "LFE",
    5: "SL",
    6: "SR",
    7: "FLC",
    8: "FRC",
    9: "BC",
    10: "SL",
    11: "SR",
    12: "TC",
    13: "TFL",
    14: "TFC",
    15: "TFR",
    16: "TBL",
    17: "TBC",
    18: "TBR",
    33: "BL",
    34: "BR",
    35: "WL",
    36: "WR",
}
_SHORT = {
    "L": "FL",
    "R": "FR",
    "C": "FC",
    "LFE": "LFE",
    "Ls": "SL",
    "Rs": "SR",
    "Rls": "BL",
    "Rrs": "BR",
    "Lc": "FLC",
    "Rc": "FRC",
    "Cs": "BC",
}
# by the upper half of a tag; the lower half is the number of channels
_ORDERS = {
    100: "C",
    101: "L R",
    108: "L R Rls Rrs",
    109: "L R Rls Rrs C",
    110: "L R Rls Rrs C Cs",
    111: "L R Rls Rrs C Cs Ls Rs",
    113: "L R C",
    114: "C L R",
    115: "L R C Cs",
    116: "C L R Cs",
    117: "L R C Ls Rs",
    118: "L R Ls Rs C",
    119: "L C R Ls Rs",
    120: "C L R Ls Rs",
    121: "L R C LFE Ls Rs",
    122: "L R Ls Rs C LFE",
    123: "L C R Ls Rs LFE",
    124: "C L R Ls Rs LFE",
    125: "L R C LFE Ls Rs Cs",
    126: "L R C LFE Ls Rs Lc Rc",
    127: "C Lc Rc L R Ls Rs LFE",
    128: "L R C LFE Ls Rs Rls Rrs",
    129: "L R Ls Rs C LFE Lc Rc",
    131: "L R Cs",
    132: "L R Ls Rs",
    133: "L R LFE",
    134: "L R LFE Cs",
    135: "L R LFE Ls Rs",
    136: "L R C LFE",
    137: "L R C LFE Cs",
    138: "L R Ls Rs LFE",
    139: "L R Ls Rs C Cs",
    140: "L R Ls Rs C Rls Rrs",
    141: "C L R Ls Rs Cs",
    142: "C L R Ls Rs Cs LFE",
    143: "C L R Ls Rs Rls Rrs",
    144: "C L R Ls Rs Rls Rrs Cs",
    148: "L R Ls Rs C Lc Rc",
    149: "C LFE",
    150: "L C R",
    151: "L C R Cs",
    152: "L C R LFE",
    153: "L R Cs LFE",
    154: "L C R Cs LFE",
    155: "L C R Ls Rs Cs",
    156: "L C R Ls Rs Rls Rrs",
    157: "L C R Ls Rs LFE Cs",
    160: "L C R Ls Rs LFE Rls Rrs",
    161: "L C R Ls Rs LFE Lc Rc",
    168: "C L R LFE",
    169: "C L R Cs LFE",
    170: "Lc Rc L R Ls Rs",
    172: "C Cs L R Rls Rrs",
    173: "Lc Rc L R Ls Rs LFE",
    175: "C Cs L R Rls Rrs LFE",
    176: "Lc C Rc L R Ls Rs",
    177: "Lc C Rc L R Ls Rs LFE",
    178: "Lc Rc L R Ls Rs Rls Rrs",
    179: "Lc C Rc L R Ls Cs Rs",
    180: "Lc Rc L R Ls Rs Rls Rrs LFE",
    181: "Lc C Rc L R Ls Cs Rs LFE",
    182: "C L R Ls Rs LFE Cs",
}


def named_channels(chunk: bytes, speakers: tuple[str, ...]) -> tuple[str, ...] | None:
    """Return the channels that a layout names, in their order; None for one that names them otherwise or not once each.

    `speakers` are the names by bit of a mask, which are those of a WAV.
    """
    if len(chunk) < _HEAD.size:
        return None
    tag, mask, count = _HEAD.unpack_from(chunk)
    if tag >> 16 == _BY_MASK:
        names = [name for bit, name in enumerate(speakers) if mask >> bit & 1]
    elif tag >> 16 == _BY_LABELS and len(chunk) >= _HEAD.size + count * _DESCRIPTION.size:
        labels = [_DESCRIPTION.unpack_from(chunk, _HEAD.size + n * _DESCRIPTION.size)[0] for n in range(count)]
        names = [_LABELS.get(label, "") for label in labels]
    else:
        names = [_SHORT[name] for name in _ORDERS.get(tag >> 16, "").split()]
    return tuple(names) if names and "" not in names and len(set(names)) == len(names) else None

"""A second listening without the centre: what dialogue drowns in the mains may be clear beside it.

mains  ──► shots ─┐
sides  ──► shots ─┴► one onset, one shot
"""

from collections.abc import Sequence

import msgspec

from ..model import Clip, Rejection, Shot
from ..ruleset import QualityRules
from ..units import samples_from_ms

_SAME_MS = 5.0
"""Two mixes of one sound begin that near to each other; no gun fires twice in it."""


def as_heard(clip: Clip) -> Clip:
    """Return a clip whose sides are what is heard."""
    assert clip.sides is not None
    return Clip(clip.sides[:, None], clip.rate_hz, clip.start)


def beside(tier: QualityRules) -> QualityRules:
    """Return the rules by which the sides are judged: what is only heard there has to be surer."""
    threshold = tier.channels.sides_threshold
    verify = msgspec.structs.replace(tier.verify, threshold=threshold, company_threshold=threshold)
    return msgspec.structs.replace(tier, verify=verify)


def joined(
    mains: tuple[Sequence[Shot], Sequence[Rejection]],
    sides: tuple[Sequence[Shot], Sequence[Rejection]],
    *,
    rate_hz: int,
) -> tuple[list[Shot], list[Rejection]]:
    """Return the shots and rejections of both mixes, each sound once.

    A shot that both heard keeps its parts in the mains, with the larger of the two confidences.
    """
    near = samples_from_ms(_SAME_MS, rate_hz)
    shots, more = list(mains[0]), []
    for shot in sides[0]:
        same = min(range(len(shots)), key=lambda i: abs(shots[i].onset - shot.onset), default=None)
        if same is None or abs(shots[same].onset - shot.onset) > near:
            more.append(msgspec.structs.replace(shot, heard_in="sides"))
        elif shot.confidence > shots[same].confidence:
            shots[same] = msgspec.structs.replace(shots[same], confidence=shot.confidence, heard_in="sides")
    shots += more
    refused = list(mains[1])
    taken = [shot.onset for shot in shots]
    refused = [each for each in refused if all(abs(each.at_sample - onset) > near for onset in taken)]
    return shots, refused

"""A second listening beside the middle: what dialogue drowns in the mains, or what cancels there, may be clear.

mains  ──► shots ─┐
sides  ──► shots ─┴► one onset, one shot
"""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..model import Clip, Rejection, Shot
from ..ruleset import QualityRules
from ..units import samples_from_ms
from .chunks import Chunk, track_peaks_dbfs
from .near import have_near
from .tracks import Grid

Found = tuple[list[Shot], list[Rejection]]
"""The shots of one mix, and what was refused."""

SAME_MS = 5.0
"""Two mixes of one sound begin that near to each other; no gun fires twice in it."""

COVERED_DB = 24.0
"""What is softer by that in the sides is what a codec or a mixer has left there; of 125 drowned shots that were found
in made scenes the softest was 24 dB under the mains."""


def are_audible(sides: Chunk, mains: Chunk, places: NDArray[np.intp], grid: Grid) -> NDArray[np.bool_]:
    """Return which of n places of a chunk of the sides are heard under the mains, with which they play, shape (n,)."""
    heard_db = track_peaks_dbfs(sides, places, grid) - track_peaks_dbfs(mains, places, grid)
    return np.asarray(heard_db >= -COVERED_DB, np.bool_)


def side_as_main(clip: Clip) -> Clip:
    """Return a clip whose sides are what is heard; the clip itself where it has none."""
    return clip if clip.sides is None else Clip(clip.sides[:, None], clip.rate_hz, clip.start)


def side_rules(tier: QualityRules) -> QualityRules:
    """Return the rules by which the sides are searched: what is only heard there has to be surer."""
    own, asked = tier.channels, tier.verify
    verify = msgspec.structs.replace(
        asked,
        threshold=own.sides_threshold,
        company_threshold=own.sides_company_threshold,
        burst_threshold=own.sides_company_threshold,
        even_threshold=own.sides_company_threshold,
        even_networks_threshold=own.sides_company_threshold,
        round_threshold=own.sides_company_threshold,
        report_from=min(asked.report_from, own.sides_company_threshold),
    )
    return msgspec.structs.replace(tier, verify=verify)


def merge_mixes(mains: Found, sides: Found, *, rate_hz: int, tier: QualityRules) -> Found:
    """Return the shots and rejections of both mixes, each sound once.

    A shot that both heard keeps its parts in the mains. Where they are not sure of it, it is judged by the mix that is
    surer. Where they are, nothing that begins in the sides nearer than any gun fires again is another one.
    """
    sure, least = tier.verify.threshold, tier.channels.sides_company_threshold
    near, apart = (samples_from_ms(ms, rate_hz) for ms in (SAME_MS, tier.bursts.shortest_gap_ms))
    shots, beside_it = list(mains[0]), sides[0]
    # below that the sides believe nothing: their verdict would only cost a shot that the mains may believe
    judging = sorted((other for other in beside_it if other.confidence >= least), key=lambda other: other.onset)
    at = [other.onset for other in judging]
    for index, shot in enumerate(shots):
        there = max(
            judging[bisect_left(at, shot.onset - near) : bisect_right(at, shot.onset + near)],
            key=lambda other: other.confidence,
            default=None,
        )
        if there is not None and shot.confidence < min(sure, there.confidence):
            shots[index] = _judged_as(shot, there)
    known, certain = [shot.onset for shot in shots], [shot.onset for shot in shots if shot.confidence >= sure]
    onsets = [shot.onset for shot in beside_it]
    same = have_near(onsets, known, near) | have_near(onsets, certain, apart)
    shots += [
        msgspec.structs.replace(shot, heard_in="sides")
        for shot, told in zip(beside_it, same.tolist(), strict=True)
        if not told
    ]
    refused = _told_anew([shot.onset for shot in shots], mains[1], near)
    known = [*(shot.onset for shot in shots), *(each.at_sample for each in refused)]
    refused += [
        Rejection(each.at_sample, f"{each.reason}, in the sides", each.evidence)
        for each in _told_anew(known, sides[1], near)
    ]
    return shots, refused


def _told_anew(known: Sequence[int], refused: Sequence[Rejection], near: int) -> list[Rejection]:
    told = have_near([each.at_sample for each in refused], known, near).tolist()
    return [each for each, before in zip(refused, told, strict=True) if not before]


def _judged_as(shot: Shot, there: Shot) -> Shot:
    """Return a shot of the mains with the verdict of the sides, and who gave it."""
    evidence = shot.evidence
    if evidence is not None and there.evidence is not None:
        who = {"screen": there.evidence.screen, "networks": there.evidence.networks}
        evidence = msgspec.structs.replace(evidence, **who)
    return msgspec.structs.replace(shot, confidence=there.confidence, heard_in="sides", evidence=evidence)

"""What all of a film tells of what was found in its chunks: a film is the same wherever they end.

chunks  | s  s |s   s |   s  |      more shots than are worth it: what lies beyond a chunk may make shots of them
film      s      s   s    s         those that are, of each mix; then each sound of both once; then rows and the beat
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..model import FIRE, EvenRow, HeardIn, Rejection, Shot
from ..ruleset import QualityRules
from ..units import samples_from_ms
from .beat import on_the_beat
from .company import unlike_a_shot, worth_segmenting
from .fire import ScoredCandidates, even_rows
from .middle import left_to_mains
from .near import have_near
from .rounds import before_a_round
from .sides import SAME_MS, Found, merge_mixes, side_rules
from .verify import log_odds_of


@dataclass(frozen=True, eq=False)
class MixResult:
    """What was found in a chunk of one mix: what may be shots, what is none, and all that the networks scored.

    `heard_beside` are the same shots, with the azimuths that they have if the sides hear them as well. `as_well` tells
    of shots of the sides whether the mains hear them as the sides do, shape (shots,).
    """

    shots: list[Shot]
    refused: list[Rejection]
    scored: ScoredCandidates
    heard_beside: list[Shot]
    as_well: NDArray[np.bool_]


ChunkResult = Mapping[HeardIn, MixResult]
"""What was found in a chunk, in the mains and in the sides where the film has any."""


@dataclass(frozen=True, eq=False)
class _HeardMix:
    """What a whole film tells of a mix: all that was scored, its even rows, and which of the shots are worth it."""

    scored: ScoredCandidates
    rows: list[EvenRow | None]
    shots: list[Shot]
    heard_beside: list[Shot]
    refused: list[Rejection]

    @classmethod
    def of(cls, parts: Sequence[MixResult], *, rate_hz: int, tier: QualityRules) -> "_HeardMix":
        """Return what all chunks, one at least, tell of a mix that is searched by these rules."""
        scored = ScoredCandidates.all_of([part.scored for part in parts])
        rows = even_rows(scored, rate_hz=rate_hz, tier=tier)
        shots = [shot for part in parts for shot in part.shots]
        onsets = np.array([shot.onset for shot in shots], np.intp)
        places = np.searchsorted(scored.onsets, onsets)
        worth = worth_segmenting(scored, rows, rate_hz=rate_hz, tier=tier)[places]
        refused = [each for part in parts for each in part.refused]
        refused += [
            unlike_a_shot(shot.onset, shot.confidence)
            for shot, kept in zip(shots, worth.tolist(), strict=True)
            if not kept and shot.confidence >= tier.verify.report_from
        ]
        chosen = np.flatnonzero(worth)
        as_well = np.concatenate([part.as_well for part in parts])[chosen]
        chosen = chosen[~left_to_mains(as_well, onsets[chosen], rate_hz=rate_hz, rules=tier.bursts)]
        beside = [shot for part in parts for shot in part.heard_beside]
        kept, kept_beside = ([each[index] for index in chosen.tolist()] for each in (shots, beside))
        return cls(scored, rows, kept, kept_beside, refused)

    def told_of(self, asked: Sequence[int], near: int, *, rate_hz: int, tier: QualityRules) -> "_Told":
        """Return what is told of the shots that the mix has judged, which may begin up to `near` samples aside."""
        places = np.array(sorted({_nearest(self.scored, onset, near) for onset in asked}), np.intp)
        kept = on_the_beat(places, self.scored, rate_hz=rate_hz, rules=tier.beat, bursts=tier.bursts)
        fires_on = _fires_on(self.scored, self.rows, rate_hz=rate_hz, tier=tier)
        return _Told(self.scored, self.rows, set(places[kept].tolist()), set(np.flatnonzero(fires_on).tolist()), near)


@dataclass(frozen=True)
class _Told:
    """All that was scored in a mix, its rows, what keeps a beat, what another round follows; the last two as indices.

    A shot may begin up to `near` samples aside in the mix.
    """

    scored: ScoredCandidates
    rows: list[EvenRow | None]
    on_beat: set[int]
    fires_on: set[int]
    near: int

    def of(self, shot: Shot) -> Shot:
        """Return a shot that the mix has judged, with all of that; what a round follows goes on for a round."""
        place = _nearest(self.scored, shot.onset, self.near)
        lasting = shot.evidence is not None and shot.evidence.goes_on and place not in self.fires_on
        return with_evidence(shot, even_row=self.rows[place], on_beat=place in self.on_beat, goes_on=lasting)


def of_whole_film(found: Sequence[ChunkResult], *, rate_hz: int, tier: QualityRules) -> Found:
    """Return the shots of all chunks, each sound once, with what the whole film tells of them, and what is none."""
    rules_of: dict[HeardIn, QualityRules] = {"mains": tier, "sides": side_rules(tier)}
    near = samples_from_ms(SAME_MS, rate_hz)
    heard = {
        mix: _HeardMix.of(parts, rate_hz=rate_hz, tier=rules)
        for mix, rules in rules_of.items()
        if (parts := [each[mix] for each in found if mix in each])
    }
    if not heard:
        return [], []
    shots, refused = heard["mains"].shots, heard["mains"].refused
    if "sides" in heard:
        sides = heard["sides"]
        shots = _placed(heard["mains"], [shot.onset for shot in sides.shots], near)
        shots, refused = merge_mixes((shots, refused), (sides.shots, sides.refused), rate_hz=rate_hz, tier=tier)
    told = {
        mix: each.told_of([s.onset for s in shots if s.heard_in == mix], near, rate_hz=rate_hz, tier=rules_of[mix])
        for mix, each in heard.items()
    }
    return [told[shot.heard_in].of(shot) for shot in shots], refused


def _placed(mains: _HeardMix, side_onsets: Sequence[int], near: int) -> list[Shot]:
    """Return the shots of the mains with the azimuths that they have by what the sides hear."""
    beside = have_near([shot.onset for shot in mains.shots], side_onsets, near)
    choices = zip(mains.shots, mains.heard_beside, beside.tolist(), strict=True)
    return [there if doubted else here for here, there, doubted in choices]


def _nearest(scored: ScoredCandidates, onset: int, near: int) -> int:
    first, stop = np.searchsorted(scored.onsets, (onset - near, onset + near + 1))
    return int(first + np.argmin(np.abs(scored.onsets[first:stop] - onset)))


def _fires_on(
    scored: ScoredCandidates, rows: Sequence[EvenRow | None], *, rate_hz: int, tier: QualityRules
) -> NDArray[np.bool_]:
    """Return which of n candidates are rounds of even fire, or right before a likely round, shape (n,)."""
    fire = np.array([row in FIRE for row in rows], bool)
    rounds = fire | (scored.odds.by_all >= log_odds_of(tier.verify.burst_threshold))
    return fire | before_a_round(scored.onsets, rounds, rate_hz=rate_hz, rules=tier.bursts)


def with_evidence(shot: Shot, **known: object) -> Shot:
    """Return a shot with some fields of its evidence replaced, where it has any."""
    if shot.evidence is None:
        return shot
    return msgspec.structs.replace(shot, evidence=msgspec.structs.replace(shot.evidence, **known))

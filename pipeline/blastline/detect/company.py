"""Accept candidates: those over the high threshold, and those over a lower one near an accepted shot or in its burst.

Hysteresis thresholding in time (two thresholds, as in Canny 1986), then rules on rows and loops.

surely a shot ──► near it, less surely                     films fire in scenes
run of likely ones, as fast as a gun fires ──► sure        guns do what nothing else does for so short a time
even row, likely in the mean               ──► believed    a weapon keeps its pace, and is heard so many times
long even row, unlikely in the mean        ──► none        so do machines
believed ──► the next as fast as a gun fires, unlikely     one round is followed by another
surely a shot ──► one right before or after, less likely   many come in twos
even row, slower, half of it unsure, and   ──► none        so come steps and blows
    unlikely in the mean
even run without an end, half of it unsure     ──► none    so do machines as well
on the beat that is kept around                ──► none    so do drums
goes on as loud as it begins                   ──► none    so does a louder scene
again and again with what is heard before it   ──► none    so do loops of ambience
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..model import FIRE, EvenRow, Rejection, Shot, Span
from ..ruleset import QualityRules, VerifyRules
from ..units import samples_from_ms, samples_from_s
from .backdrop import LEVELS
from .fire import ScoredCandidates
from .loops import LoopCandidates, in_loops
from .near import have_near
from .pace import rows_at, shot_by_shot
from .rounds import in_a_run, in_pairs, with_rounds
from .rows import in_endless_fire, in_even_rows, runs_of
from .verify import log_odds_of

_ROUNDING = 2  # samples that a gap may gain on its way to another rate
_ALONE = "alone, and not sure enough for that"
_STEP = "one of an even row, as of steps or blows"
_MACHINE = "one of a row that goes on as no gun does, as of a machine"
_UNLIKE = "one of a row as even as automatic fire that does not sound like a gun"
_SCENE = "begins at once and goes on as loud, as after a cut to another scene"
_BEAT = "on the beat of music"
_LOOP = "one of a loop: it comes again with all that is around it, and again"


@dataclass(frozen=True, eq=False)
class _Belief:
    """What is thought of n candidates, shape (n,) each.

    `believed` are shots, unless their row is refused. `by_itself` would be believed alone, `likely` in company. `fire`
    are rounds of a row of even fire, `sustained` those of one that lasts longer than a burst; `unlike` belong to a row
    at that pace that does not sound like a gun.
    """

    believed: NDArray[np.bool_]
    by_itself: NDArray[np.bool_]
    likely: NDArray[np.bool_]
    fire: NDArray[np.bool_]
    sustained: NDArray[np.bool_]
    unlike: NDArray[np.bool_]


def in_company(
    shots: Iterable[Shot], *, rate_hz: int, tier: QualityRules
) -> tuple[tuple[Shot, ...], tuple[Rejection, ...]]:
    """Return the shots that are believed, in order of time, and the rest.

    Believed are

    - sure shots: what reaches `threshold`, and each of a run of `fewest_shots` that all reach `burst_threshold`;
    - what reaches `company_threshold` within `company_s` of a sure shot;
    - the rounds of a row of even fire that sounds like fire in the mean (`fire.py`);
    - of a burst with two believed shots, the other rounds that reach `round_threshold`: what lies within
      `longest_gap_ms` from one to the next, unless it is `echo_drop_db` softer than the believed ones;
    - what lies within `pair_ms` of a shot that is sure by itself, if it reaches `pair_threshold` and is not
      `echo_drop_db` softer: the other one of a double shot.

    Refused all the same, so that they are company for no other, are

    - of a long row of even fire that does not sound like that, all that are not sure by themselves;
    - a run at a gun's pace of more than `most_unsure`, of which fewer than half are sure by themselves or in a row of
      sustained fire;
    - a slower even row (`RowRules`) of which fewer than half are sure by themselves or rounds of even fire;
    - what turns with a loop of ambience, unless it is in a row of sustained fire;
    - what keeps the beat of music (`beat.py`);
    - what goes on as loud as it begins (`steady.py`), unless it is a round of even fire or a likely round follows it.
    """
    left = sorted(shots, key=lambda s: s.onset)
    refused: list[Rejection] = []
    while True:
        belief = _belief(left, rate_hz=rate_hz, tier=tier)
        rows = _rows(left, belief, rate_hz=rate_hz, tier=tier)
        if not any(rows):
            break
        refused += [_refused(shot, why) for shot, why in zip(left, rows, strict=True) if why]
        left = [shot for shot, why in zip(left, rows, strict=True) if not why]
    rest = [
        _refused(shot, _ALONE) if likely else unlike_a_shot(shot.onset, shot.confidence)
        for shot, kept, likely in zip(left, belief.believed, belief.likely, strict=True)
        if not kept
    ]
    believed = tuple(shot for shot, kept in zip(left, belief.believed, strict=True) if kept)
    return believed, tuple(sorted([*refused, *rest], key=lambda each: each.at_sample))


def _belief(shots: Sequence[Shot], *, rate_hz: int, tier: QualityRules) -> _Belief:
    """Return what is believed of candidates, ascending, as long as no row of them is refused."""
    rules, channels, bursts = tier.verify, tier.channels, tier.bursts
    onsets = _onsets(shots)
    probability = np.array([shot.confidence for shot in shots])
    aside = np.array([shot.heard_in == "sides" for shot in shots], bool)
    by_itself = probability >= np.where(aside, channels.sides_threshold, rules.threshold)
    rounds = probability >= np.where(aside, channels.sides_company_threshold, rules.round_threshold)
    in_run = np.where(aside, channels.sides_company_threshold, rules.burst_threshold)
    sure = by_itself | in_a_run(onsets, probability, in_run, rate_hz=rate_hz, rules=bursts)
    likely = probability >= np.where(aside, channels.sides_company_threshold, rules.company_threshold)
    believed = sure | (likely & have_near(onsets, onsets[sure], samples_from_s(rules.company_s, rate_hz)))
    peaks_dbfs = np.array([shot.peak_dbfs for shot in shots])
    rows = [shot.evidence.even_row if shot.evidence else None for shot in shots]
    fire = np.array([row in FIRE for row in rows], bool)
    sustained = np.array([row == "sustained fire" for row in rows], bool)
    believed |= fire
    believed = with_rounds(onsets, believed, rounds, peaks_dbfs, rate_hz=rate_hz, rules=bursts)
    perhaps = rounds & (probability >= rules.pair_threshold)
    pairs = partial(in_pairs, onsets, peaks_dbfs, longest_ms=rules.pair_ms, rate_hz=rate_hz, rules=bursts)
    believed = believed | pairs(by_itself & aside, perhaps & aside) | pairs(by_itself & ~aside, perhaps & ~aside)
    unlike = np.array([row == "no fire" for row in rows], bool) & ~by_itself
    return _Belief(believed, by_itself, likely, fire, sustained, unlike)


def _rows(shots: Sequence[Shot], belief: _Belief, *, rate_hz: int, tier: QualityRules) -> list[str]:
    """Return of each candidate why it is refused as one of a row, and nothing of those that are not."""
    believed = np.flatnonzero(belief.believed)
    onsets, by_itself = _onsets(shots), belief.by_itself
    vouched, lasting = by_itself | belief.fire, by_itself | belief.sustained
    steps = in_even_rows(onsets[believed], vouched[believed], rate_hz=rate_hz, rules=tier.rows)
    machines = in_endless_fire(onsets[believed], lasting[believed], rate_hz=rate_hz, rules=tier.bursts)
    returning = np.flatnonzero(belief.likely)  # a turn may be out of all company; what is less is not always segmented
    looping = _loop_candidates([shots[place] for place in returning.tolist()], lasting[returning])
    loops = in_loops(looping, rate_hz=rate_hz, rules=tier.rows)
    known = [shot.evidence for shot in shots]
    why = [""] * len(shots)
    for refused, reason in (
        (returning[loops], _LOOP),
        (believed[steps], _STEP),
        (believed[machines], _MACHINE),
        (np.flatnonzero(belief.unlike), _UNLIKE),
        (np.flatnonzero([each is not None and each.on_beat for each in known]), _BEAT),
        (np.flatnonzero([each is not None and each.goes_on for each in known]), _SCENE),
    ):
        for place in refused.tolist():
            why[place] = reason
    return why


def _loop_candidates(shots: Sequence[Shot], by_itself: NDArray[np.bool_]) -> LoopCandidates:
    """Return what tells of candidates whether they turn with a loop; of those that nobody looked at, nothing does."""
    known = [shot.evidence for shot in shots]
    backdrops = [-1 if each is None or each.backdrop is None else each.backdrop for each in known]
    sounds = [each.sound if each and each.sound else (np.nan,) * LEVELS for each in known]
    return LoopCandidates(
        _onsets(shots),
        np.array([shot.peak_dbfs for shot in shots]),
        by_itself,
        np.array(backdrops, np.int64),
        np.array(sounds, np.float64).reshape(len(shots), LEVELS),
    )


def _onsets(shots: Sequence[Shot]) -> NDArray[np.intp]:
    return np.array([shot.onset for shot in shots], np.intp)


def unlike_a_shot(onset: int, probability: float) -> Rejection:
    """Return the rejection of what is hardly a shot."""
    return Rejection(onset, "does not sound like a shot", {"probability": probability})


def _refused(shot: Shot, why: str) -> Rejection:
    return Rejection(shot.onset, why, {"probability": shot.confidence})


def worth_segmenting(
    scored: ScoredCandidates,
    rows: Sequence[EvenRow | None],
    *,
    rate_hz: int,
    tier: QualityRules,
    core: Span | None = None,
) -> NDArray[np.bool_]:
    """Return which of n candidates of a film, or a chunk's core, `in_company` could believe, shape (n,), by their rows.

    The others need not be segmented: they are rounds of no burst, and no second of a double shot. What a burst or a row
    beyond the core may reach is worth it, a slow row of shots too, which the networks alone may believe.
    """
    longest = samples_from_ms(tier.bursts.longest_gap_ms, rate_hz) + _ROUNDING
    fired = np.array([row in FIRE for row in rows], bool)
    worth: NDArray[np.bool_] = (scored.odds.by_all >= log_odds_of(tier.verify.company_threshold)) | fired
    worth |= _perhaps_of_a_pair(scored, rate_hz=rate_hz, rules=tier.verify, core=core)
    likeliest = np.maximum(scored.odds.by_all, scored.odds.by_networks)
    members = np.flatnonzero((likeliest >= log_odds_of(tier.verify.round_threshold)) | worth)
    reach = (tier.rows.fewest - 1) * samples_from_ms(tier.rows.longest_gap_ms, rate_hz)
    cut = _near_an_end(scored.onsets, core, reach)
    for row in rows_at(scored.onsets, scored.peaks_dbfs, shot_by_shot(tier), rate_hz=rate_hz) if cut.any() else ():
        cut[row] |= cut[row].any()  # what is beyond the core may make fire of all of it
    worth |= cut & (scored.odds.by_networks >= log_odds_of(tier.verify.round_threshold))
    for run in runs_of(scored.onsets[members], longest):
        burst = members[run]
        worth[burst] |= worth[burst].any() or _near_an_end(scored.onsets[burst], core, longest).any()
    return worth


def _perhaps_of_a_pair(
    scored: ScoredCandidates, *, rate_hz: int, rules: VerifyRules, core: Span | None
) -> NDArray[np.bool_]:
    """Return which of n candidates are likely enough and near enough to a sure one, which may lie beyond the core."""
    reach = samples_from_ms(rules.pair_ms, rate_hz) + _ROUNDING
    sure = scored.onsets[scored.odds.by_all >= log_odds_of(rules.threshold)]
    cut = _near_an_end(scored.onsets, core, reach)
    return (scored.odds.by_all >= log_odds_of(rules.pair_threshold)) & (cut | have_near(scored.onsets, sure, reach))


def _near_an_end(onsets: NDArray[np.intp], core: Span | None, reach: int) -> NDArray[np.bool_]:
    """Return which of n onsets something beyond the core may reach, shape (n,); beyond a film is nothing."""
    if core is None:
        return np.zeros(onsets.size, np.bool_)
    return np.asarray((onsets < core.start + reach) | (onsets >= core.stop - reach))

"""Which shots are one, which are echoes, and which belong together as automatic fire."""

from bisect import bisect_left, bisect_right, insort
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise, takewhile
from statistics import median

import msgspec
import numpy as np

from ..model import FIRE, HeardIn, Reflection, Rejection, Shot, Span
from ..ruleset import BurstRules
from ..units import ms_from_samples, samples_from_ms
from .copies import likeness
from .rows import runs_of

_ROUNDS_HEARD = 5  # of a burst, to tell its pace by
_STAGES_MS = 20.0  # from where a shot begins: a bolt, the blast, what the room adds
_HAIR = 0.03  # of probability: by so little one of two may be surer by chance
_SAME_ECHO_MS = 1.0  # two shots that hear an echo this close hear the same one


def suppress_non_maxima(
    shots: Iterable[Shot], *, rate_hz: int, rules: BurstRules, sure: Mapping[HeardIn, float]
) -> tuple[tuple[Shot, ...], tuple[Rejection, ...]]:
    """Return the shots no two of which lie nearer than `shortest_gap_ms`, and the rest, both in order of time.

    Temporal non-maximum suppression: what is given up lies too near to one that is kept and at least as sure. What is
    `sure` by itself, in the mix that judged it, begins a shot and counts as sure as a later stage of it, up to 20 ms
    on, that is surer by a hair: a shot does not begin where it is loudest.
    """
    gap = samples_from_ms(rules.shortest_gap_ms, rate_hz)
    kept: list[Shot] = []
    dropped: list[Rejection] = []
    taken: list[int] = []  # onsets, ascending
    # the surest first, so that only a shot that stays costs another its place; of equals the one that began the sound
    for shot, _ in sorted(_with_surest_stage(shots, rate_hz, sure), key=lambda each: (-each[1], each[0].onset)):
        place = bisect_left(taken, shot.onset)
        if any(abs(shot.onset - onset) < gap for onset in taken[max(0, place - 1) : place + 1]):
            why = "nearer to another shot than any gun fires"
            dropped.append(Rejection(shot.onset, why, {"probability": shot.confidence}))
        else:
            taken.insert(place, shot.onset)
            kept.append(shot)
    return tuple(sorted(kept, key=lambda s: s.onset)), tuple(sorted(dropped, key=lambda r: r.at_sample))


def _with_surest_stage(
    shots: Iterable[Shot], rate_hz: int, sure: Mapping[HeardIn, float]
) -> Iterator[tuple[Shot, float]]:
    """Yield the shots in order of time, each with the probability of the surest stage of what it begins, if near it."""
    longest = samples_from_ms(_STAGES_MS, rate_hz)
    in_time = sorted(shots, key=lambda s: s.onset)
    onsets = [shot.onset for shot in in_time]
    for place, shot in enumerate(in_time):
        stages = in_time[place : bisect_left(onsets, shot.onset + longest)]
        surest = max(each.confidence for each in stages)
        begins = shot.confidence >= max(sure[shot.heard_in], surest - _HAIR)
        yield shot, surest if begins else shot.confidence


def without_echoes(
    shots: Iterable[Shot], *, rate_hz: int, rules: BurstRules
) -> tuple[tuple[Shot, ...], tuple[Rejection, ...]]:
    """Return the shots that are no echo of an earlier one, in order of time, and the echoes.

    An echo lies where an earlier shot was found to repeat itself more softly, and is a little like it, or sounds as an
    earlier shot does; its own peak is lower by as much. The rounds of a burst are alike, too, but about as loud, or
    fall evenly: what comes when the next round of even fire is due is none. An echo that only its sound gives away
    becomes a reflection of the shot that it copies.
    """
    same = samples_from_ms(_SAME_ECHO_MS, rate_hz)
    kept: list[Shot] = []
    echoes: list[Rejection] = []
    due: list[tuple[int, float, Shot]] = []  # where echoes are still to come, their highest peak, and whose they are
    in_order = sorted(shots, key=lambda s: s.onset)
    for place, shot in enumerate(in_order):
        due = [each for each in due if each[0] >= shot.onset - same]
        expected = any(
            at <= shot.onset + same and shot.peak_dbfs <= highest_dbfs and _may_repeat(shot, first, rules)
            for at, highest_dbfs, first in due
        )
        copied = None if expected else _copied_by(shot, kept, rate_hz=rate_hz, rules=rules)
        later = in_order[place + 1 : place + _ROUNDS_HEARD]
        if (expected or copied is not None) and not _is_next_round(shot, kept, later, rate_hz=rate_hz, rules=rules):
            if copied is not None:
                kept[copied] = _with_echo(kept[copied], shot, rate_hz=rate_hz)
            echoes.append(Rejection(shot.onset, "the echo of an earlier shot", {"probability": shot.confidence}))
            continue
        kept.append(shot)
        softer = (echo for echo in shot.reflections if echo.level_db <= -rules.echo_drop_db)
        due += [(echo.start, shot.peak_dbfs - rules.echo_drop_db, shot) for echo in softer]
    return tuple(kept), tuple(echoes)


def _may_repeat(shot: Shot, earlier: Shot, rules: BurstRules) -> bool:
    """Return whether a shot is like an earlier one, as echoes of crowded places still are, or nobody knows.

    Where reflections are looked for, another shot is a spike as well.
    """
    attacks = [each.evidence.attack if each.evidence else b"" for each in (shot, earlier)]
    return not all(attacks) or likeness(attacks[0], attacks[1:])[0] >= rules.echo_likeness


def _is_next_round(
    shot: Shot, earlier: Sequence[Shot], later: Sequence[Shot], *, rate_hz: int, rules: BurstRules
) -> bool:
    """Return whether a shot comes one gap of even fire after the last of the earlier ones, in order of time.

    What the gap is, the rounds before it tell, or those after it that are as loud as the last one, from it on where
    none else does. So an echo passes only where its way takes as long as the gun. Those that are as soft as it is may
    be its further echoes, but in a row that sounds like fire.
    """
    before = earlier[: -1 - _ROUNDS_HEARD : -1]
    if not before:
        return False
    as_soft, as_loud = (
        [each for each in later if abs(each.peak_dbfs - like.peak_dbfs) <= rules.echo_drop_db]
        for like in (shot, before[0])
    )
    is_fire = any(each.evidence and each.evidence.even_row in FIRE for each in (shot, *before))
    bursts = [before, as_loud] + ([[shot, *as_soft]] if is_fire else [])
    gap = shot.onset - before[0].onset
    paces = [_pace([each.onset for each in burst], rate_hz=rate_hz, rules=rules) for burst in bursts]
    if not any(paces):
        paces = [_pace([shot.onset, *(each.onset for each in as_loud)], rate_hz=rate_hz, rules=rules)]
    return any(abs(gap - pace) <= rules.unevenness * pace for pace in paces)


def _pace(onsets: Sequence[int], *, rate_hz: int, rules: BurstRules) -> float:
    """Return the usual gap, in samples, of a burst that the first onset and those next to it belong to; 0 for none."""
    shortest, longest = (samples_from_ms(ms, rate_hz) for ms in (rules.shortest_gap_ms, rules.longest_gap_ms))
    gaps = takewhile(lambda gap: shortest <= gap <= longest, (abs(b - a) for a, b in pairwise(onsets)))
    return median(list(gaps) or [0])


def _copied_by(shot: Shot, earlier: Sequence[Shot], *, rate_hz: int, rules: BurstRules) -> int | None:
    """Return the index of the one of the earlier shots, in order of time, that a shot copies most; None for none.

    That one is near, and louder by enough. A round of even fire copies none: a designer's burst may be one sample again
    and again, more softly.
    """
    if shot.evidence is None or shot.evidence.even_row is not None:
        return None
    louder: list[int] = []
    attacks: list[bytes] = []
    for index in range(len(earlier) - 1, -1, -1):
        other = earlier[index]
        if shot.onset - other.onset > samples_from_ms(rules.latest_copy_ms, rate_hz):
            break
        if other.evidence is not None and other.peak_dbfs >= shot.peak_dbfs + rules.echo_drop_db:
            louder.append(index)
            attacks.append(other.evidence.attack)
    if not louder:
        return None
    like = likeness(shot.evidence.attack, attacks)
    return louder[int(like.argmax())] if like.max() >= rules.copy_likeness else None


def _with_echo(shot: Shot, echo: Shot, *, rate_hz: int) -> Shot:
    """Return a shot with a softer sound that was taken for a shot and copies it, as a reflection.

    It stands for a reflection that was heard there, one too loud to expect an echo by: that is the same echo.
    """
    delay_ms, level_db = ms_from_samples(echo.onset - shot.onset, rate_hz), echo.peak_dbfs - shot.peak_dbfs
    same = samples_from_ms(_SAME_ECHO_MS, rate_hz)
    others = [each for each in shot.reflections if abs(each.start - echo.onset) > same]
    reflections = (*others, Reflection(echo.onset, echo.blast.stop, delay_ms, level_db))
    gained = len(reflections) - len(shot.reflections)
    evidence = shot.evidence and msgspec.structs.replace(shot.evidence, copies=shot.evidence.copies + gained)
    in_time = tuple(sorted(reflections, key=lambda each: each.start))
    return msgspec.structs.replace(shot, reflections=in_time, evidence=evidence)


def drop_claimed_reflections(shots: Sequence[Shot], *, rate_hz: int, rules: BurstRules) -> tuple[Shot, ...]:
    """Return the shots without reflections that are later shots, or that a later shot also claims: that one keeps them.

    The next shot sounds like the first, and so do its echoes. All that sounds sooner after a shot than any gun fires
    again is that shot's as well. A shot is not over before the last reflection that it keeps. What it claims,
    but its place drowns, is nobody's: no earlier shot hears it better.
    """
    gap, same = samples_from_ms(rules.shortest_gap_ms, rate_hz), samples_from_ms(_SAME_ECHO_MS, rate_hz)
    onsets = sorted(shot.onset for shot in shots)
    claimed: list[int] = []  # negated, ascending: of shots from the last to the first, the next go in near its end
    left: list[Shot] = []
    for shot in reversed(shots):
        echoes = tuple(
            echo
            for echo in shot.reflections
            if not _any_between(onsets, max(shot.onset, echo.start - gap), echo.start + gap // 2)
            and not _any_between(claimed, -echo.start - same - 1, -echo.start + same + 1)
        )
        for echo in echoes:
            insort(claimed, -echo.start)
        left.append(_lasting(msgspec.structs.replace(shot, reflections=echoes)))
    return tuple(reversed(left))


def _lasting(shot: Shot) -> Shot:
    """Return a shot that lasts until its last reflection is over, without those that its place drowns after the decay.

    What is told from the decay is its own sound; later there may be anything, and what is like the blast in it is none.
    """
    known = shot.evidence
    if known is None:
        return shot
    echoes = tuple(e for e in shot.reflections if e.start < shot.span.stop or e.level_db >= known.drowned_db)
    copies = known.copies - (len(shot.reflections) - len(echoes))
    stop = max((echo.stop for echo in echoes), default=shot.span.stop)
    span, ended = shot.span, known.decay_end
    if stop > span.stop:
        span, ended = Span(span.start, stop), "last reflection"
    known = msgspec.structs.replace(known, copies=copies, decay_end=ended)
    return msgspec.structs.replace(shot, reflections=echoes, span=span, evidence=known)


def _any_between(places: Sequence[int], above: int, below: int) -> bool:
    """Return whether any of the places, ascending, lies above the one limit and below the other."""
    first = bisect_right(places, above)
    return first < len(places) and places[first] < below


def group_bursts(shots: Sequence[Shot], *, rate_hz: int, rules: BurstRules) -> tuple[Shot, ...]:
    """Number the runs of at least `fewest_shots` shots that follow each other within `longest_gap_ms`.

    Bursts are numbered from 1 in the film, shots from 1 in their burst; a single shot has neither.
    """
    gap = samples_from_ms(rules.longest_gap_ms, rate_hz)
    numbered: list[Shot] = []
    burst = 0
    for places in runs_of(np.array([shot.onset for shot in shots], np.intp), gap):
        run = [shots[place] for place in places]
        if len(run) < rules.fewest_shots:
            numbered += run
            continue
        burst += 1
        numbered += [msgspec.structs.replace(s, burst=burst, shot_in_burst=n) for n, s in enumerate(run, start=1)]
    return tuple(numbered)

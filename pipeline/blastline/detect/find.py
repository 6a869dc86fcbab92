"""The detection pipeline, chunk by chunk: candidates, verification, segmentation; then what the whole film tells."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, tee

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..model import FIRE, Channels, Clip, EvenRow, HeardIn, Rejection, Shot
from ..ruleset import QualityRules
from ..units import samples_from_ms
from .across import RowSounds
from .backdrop import backdrops, sounds
from .beat import on_the_beat
from .bursts import drop_claimed_reflections, group_bursts, suppress_non_maxima, without_echoes
from .candidates import CandidateFeatures
from .chunks import CORE_PIECES, SHORT_CORE_PIECES, Chunk, aligned_chunks, chunks
from .closer import with_long_rows, worth_looking_at
from .company import in_company, unlike_a_shot, worth_segmenting
from .copies import attack
from .direction import with_azimuths
from .fire import ScoredCandidates, even_rows
from .middle import left_to_mains
from .rate import LISTENING_HZ, film_sample, in_film, resampled
from .rounds import before_a_round
from .scan import loudest_around
from .segment import peak_dbfs, segment
from .sides import SAME_MS, merge_mixes, side_as_main, side_rules
from .spectrogram import Spectrograms, spectrograms
from .steady import goes_on
from .tracks import Grid, pieces
from .verify import Verdicts, Verifier, log_odds_in, log_odds_of

LATENCY_S = 40.0
"""Of a film with channels a shot is found at the latest so long after it: a short core, what follows, some blocks."""


@dataclass(frozen=True)
class Detection:
    """What was found in a film: shots and rejections, both in order."""

    shots: tuple[Shot, ...]
    rejections: tuple[Rejection, ...]


@dataclass(frozen=True, eq=False)
class ChunkResult:
    """What was found in a chunk: shots and rejections of one mix or both, and all that the networks scored in each."""

    shots: list[Shot]
    refused: list[Rejection]
    scored: dict[HeardIn, ScoredCandidates]


@dataclass(frozen=True)
class _Told:
    """What a whole film tells of all that was scored in a mix: its rows, what keeps a beat, what another round follows.

    The last two are indices.
    """

    scored: ScoredCandidates
    rows: list[EvenRow | None]
    on_beat: set[int]
    fires_on: set[int]

    def of(self, shot: Shot, near: int) -> Shot:
        """Return a shot that the mix has judged, which may begin up to `near` samples aside in it, with all of that.

        What a round follows goes on for a round.
        """
        place = _nearest(self.scored, shot.onset, near)
        lasting = shot.evidence is not None and shot.evidence.goes_on and place not in self.fires_on
        return _with_evidence(shot, even_row=self.rows[place], on_beat=place in self.on_beat, goes_on=lasting)


def _nearest(scored: ScoredCandidates, onset: int, near: int) -> int:
    first, stop = np.searchsorted(scored.onsets, (onset - near, onset + near + 1))
    return int(first + np.argmin(np.abs(scored.onsets[first:stop] - onset)))


def find_shots(
    blocks: Iterable[Clip], *, rate_hz: int, tier: QualityRules, verifier: Verifier, channels: Channels | None = None
) -> Detection:
    """Return the gunshots of a film, given as blocks in order, in constant memory.

    `rate_hz` is the film's, whose samples all places count. Blocks with sides are listened to twice. `channels`, where
    given, tell from where the shots come.
    """
    found = list(search_chunks(blocks, rate_hz=rate_hz, tier=tier, verifier=verifier, channels=channels))
    shots = chain.from_iterable(with_what_the_film_tells(found, rate_hz=rate_hz, tier=tier))
    return select_shots(shots, chain.from_iterable(each.refused for each in found), rate_hz=rate_hz, tier=tier)


def with_what_the_film_tells(found: Sequence[ChunkResult], *, rate_hz: int, tier: QualityRules) -> Iterator[list[Shot]]:
    """Yield the shots of each chunk, with what the whole film tells of them: rows and the beat may cross chunks."""
    told: dict[HeardIn, _Told] = {}
    rules_of: dict[HeardIn, QualityRules] = {"mains": tier, "sides": side_rules(tier)}
    near = samples_from_ms(SAME_MS, rate_hz)
    for mix, rules in rules_of.items():
        parts = [each.scored[mix] for each in found if mix in each.scored]
        if parts:
            every = ScoredCandidates.all_of(parts)
            shots = (shot.onset for each in found for shot in each.shots if shot.heard_in == mix)
            asked = np.array(sorted({_nearest(every, onset, near) for onset in shots}), np.intp)
            kept = on_the_beat(asked, every, rate_hz=rate_hz, rules=tier.beat, bursts=tier.bursts)
            rows = even_rows(every, rate_hz=rate_hz, tier=rules)
            fires_on = _fires_on(every, rows, rate_hz=rate_hz, tier=rules)
            told[mix] = _Told(every, rows, set(asked[kept].tolist()), set(np.flatnonzero(fires_on).tolist()))
    for each in found:
        yield [told[shot.heard_in].of(shot, near) for shot in each.shots]


def _fires_on(
    scored: ScoredCandidates, rows: Sequence[EvenRow | None], *, rate_hz: int, tier: QualityRules
) -> NDArray[np.bool_]:
    """Return which of n candidates are rounds of even fire, or right before a likely round, shape (n,)."""
    fire = np.array([row in FIRE for row in rows], bool)
    rounds = fire | (scored.odds.by_all >= log_odds_of(tier.verify.burst_threshold))
    return fire | before_a_round(scored.onsets, rounds, rate_hz=rate_hz, rules=tier.bursts)


def select_shots(
    shots: Iterable[Shot], rejections: Iterable[Rejection], *, rate_hz: int, tier: QualityRules
) -> Detection:
    """Return which of a film's candidates are shots, echoes and doublets taken out and bursts numbered."""
    believed, alone = in_company(shots, rate_hz=rate_hz, tier=tier)
    sure: dict[HeardIn, float] = {"mains": tier.verify.threshold, "sides": tier.channels.sides_threshold}
    kept, dropped = suppress_non_maxima(believed, rate_hz=rate_hz, rules=tier.bursts, sure=sure)
    fired, echoes = without_echoes(kept, rate_hz=rate_hz, rules=tier.bursts)
    segmented = drop_claimed_reflections(fired, rate_hz=rate_hz, rules=tier.bursts)
    missed = (each for each in alone if each.evidence["probability"] >= tier.verify.report_from)
    return Detection(
        shots=group_bursts(segmented, rate_hz=rate_hz, rules=tier.bursts),
        rejections=tuple(sorted(chain(rejections, missed, dropped, echoes), key=lambda r: r.at_sample)),
    )


def search_chunks(
    blocks: Iterable[Clip], *, rate_hz: int, tier: QualityRules, verifier: Verifier, channels: Channels | None = None
) -> Iterator[ChunkResult]:
    """Yield what is found in each of a film's chunks, with what their sides add where the blocks have any.

    Nothing is believed yet, since that depends on all of the film.
    """
    rest = resampled(blocks, rate_hz)
    first = next(rest, None)
    if first is None:
        return
    film = chain([first], rest)
    cut = partial(pieces, rate_hz=LISTENING_HZ, with_bands=tier.scan.band_jump_db is not None)
    search = partial(_search_chunk, grid=Grid(LISTENING_HZ), tier=tier, verifier=verifier, rate_hz=rate_hz)
    place = partial(with_azimuths, channels=channels, rate_hz=rate_hz, rules=tier.channels)
    core_pieces = CORE_PIECES if channels is None else SHORT_CORE_PIECES
    if first.sides is None:
        for mains in map(search, chunks(cut(film), core_pieces)):
            yield ChunkResult(place(mains.shots), mains.refused, mains.scored)
        return
    once, again = tee(film)
    search_sides = partial(search, tier=side_rules(tier))
    for chunk, sides in aligned_chunks(cut(once), cut(map(side_as_main, again)), core_pieces=core_pieces):
        mains, there = search(chunk), search_sides(sides, over=chunk)
        heard = ((each.shots, each.refused) for each in (mains, there))
        shots, refused = merge_mixes(*heard, rate_hz=rate_hz, tier=tier)
        scored: dict[HeardIn, ScoredCandidates] = {"mains": mains.scored["mains"], "sides": there.scored["mains"]}
        yield ChunkResult(place(shots, side_onsets=[shot.onset for shot in there.shots]), refused, scored)


def _search_chunk(
    chunk: Chunk,
    grid: Grid,
    tier: QualityRules,
    verifier: Verifier,
    rate_hz: int,
    over: Chunk | None = None,
) -> ChunkResult:
    """Return what is found in a chunk of one mix, with its places in the samples of a film of that rate.

    What the mix `over` it covers is not looked at, and rows that are heard there as well are left to it.
    """
    found = worth_looking_at(chunk, grid, tier, verifier, over)
    loudest = loudest_around(chunk.peak, found.onsets // grid.step, grid=grid)

    def seen(which: NDArray[np.intp] | slice, speed: float) -> Spectrograms:
        return spectrograms(chunk.samples, found.onsets[which], grid.rate_hz, loudest[which], speed=speed)

    shown = seen(slice(None), 1.0)
    verdicts = verifier.verdicts(found.rows, shown, [partial(seen, speed=speed) for speed in tier.verify.speeds])
    peaks_dbfs = np.array([peak_dbfs(chunk.samples, onset, grid.rate_hz) for onset in found.onsets.tolist()])
    around = RowSounds.around(chunk, found, peaks_dbfs, grid.rate_hz)
    odds = with_long_rows(log_odds_in(verdicts), found, shown, around, grid, tier, verifier)
    scored = ScoredCandidates(found.onsets + chunk.start, peaks_dbfs, odds, sounds(shown))
    rows = even_rows(scored, rate_hz=grid.rate_hz, tier=tier)
    worth = worth_segmenting(scored, rows, rate_hz=grid.rate_hz, tier=tier, core=chunk.core)
    worth |= around.going_on(rate_hz=grid.rate_hz, rules=tier.bursts)
    chosen = np.flatnonzero(worth)
    if over is not None:
        sides, mains, onsets = chunk.samples, over.samples, found.onsets[chosen]
        chosen = chosen[~left_to_mains(sides, mains, onsets, rate_hz=grid.rate_hz, rules=tier.bursts)]
    shots = _segmented(chunk, found, verdicts, shown, scored.sounds, chosen, grid=grid, tier=tier)
    refused = [
        unlike_a_shot(int(scored.onsets[index]), float(verdicts.probability[index]))
        for index in np.flatnonzero(~worth & (verdicts.probability >= tier.verify.report_from))
    ]
    in_film_at = np.array([film_sample(sample, rate_hz) for sample in scored.onsets.tolist()], np.intp)
    return ChunkResult(*in_film(shots, refused, rate_hz), {"mains": replace(scored, onsets=in_film_at)})


def _segmented(
    chunk: Chunk,
    found: CandidateFeatures,
    verdicts: Verdicts,
    shown: Spectrograms,
    own: NDArray[np.int16],
    chosen: NDArray[np.intp],
    *,
    grid: Grid,
    tier: QualityRules,
) -> list[Shot]:
    """Return the candidates with these indices as shots: segmented, each with the evidence of its verdict."""
    before, rate_hz = backdrops(shown), grid.rate_hz
    steady = goes_on(chunk.bands, found.onsets[chosen], grid, tier.verify.least_fall_db)
    shots = []
    for index, lasting in zip(chosen.tolist(), steady.tolist(), strict=True):
        shot = segment(
            chunk.samples,
            int(found.onsets[index]),
            confidence=float(verdicts.probability[index]),
            rate_hz=rate_hz,
            film_start=chunk.start,
            film_stop=chunk.stop,
            rules=tier.segment,
        )
        evidence = {
            "screen": float(verdicts.screen_probability[index]),
            "networks": int(verdicts.networks[index]),
            "backdrop": before[index],
            "sound": tuple(own[index].tolist()),
            "attack": attack(chunk.samples, int(found.onsets[index]), rate_hz),
            "goes_on": lasting,
        }
        shots.append(_with_evidence(shot, **evidence))
    return shots


def _with_evidence(shot: Shot, **known: object) -> Shot:
    """Return a shot with some fields of its evidence replaced, where it has any."""
    if shot.evidence is None:
        return shot
    return msgspec.structs.replace(shot, evidence=msgspec.structs.replace(shot.evidence, **known))

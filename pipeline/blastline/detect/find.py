"""The detection pipeline, chunk by chunk: candidates, verification, segmentation; then what the whole film tells."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, tee

import numpy as np
from numpy.typing import NDArray

from ..model import Channels, Clip, HeardIn, Rejection, Shot
from ..ruleset import QualityRules
from .across import RowSounds
from .backdrop import backdrops, sounds
from .bursts import drop_claimed_reflections, group_bursts, suppress_non_maxima, without_echoes
from .candidates import CandidateFeatures
from .chunks import CORE_PIECES, SHORT_CORE_PIECES, Chunk, aligned_chunks, chunks
from .closer import with_long_rows, worth_looking_at
from .company import in_company, unlike_a_shot, worth_segmenting
from .copies import attack
from .direction import with_azimuths
from .fire import ScoredCandidates, even_rows
from .middle import heard_as_well
from .rate import LISTENING_HZ, film_sample, in_film, resampled
from .scan import loudest_around
from .segment import peak_dbfs, segment
from .sides import side_as_main, side_rules
from .spectrogram import Spectrograms, spectrograms
from .steady import goes_on
from .tracks import Grid, pieces
from .verify import Verdicts, Verifier, log_odds_in
from .whole import ChunkResult, MixResult, of_whole_film, with_evidence

LATENCY_S = 40.0
"""Of a film with channels a shot is found at the latest so long after it: a short core, what follows, some blocks."""


@dataclass(frozen=True)
class Detection:
    """What was found in a film: shots and rejections, both in order."""

    shots: tuple[Shot, ...]
    rejections: tuple[Rejection, ...]


def find_shots(
    blocks: Iterable[Clip], *, rate_hz: int, tier: QualityRules, verifier: Verifier, channels: Channels | None = None
) -> Detection:
    """Return the gunshots of a film, given as blocks in order, in constant memory.

    `rate_hz` is the film's, whose samples all places count. Blocks with sides are listened to twice. `channels`, where
    given, tell from where the shots come.
    """
    found = list(search_chunks(blocks, rate_hz=rate_hz, tier=tier, verifier=verifier, channels=channels))
    return select_shots(*of_whole_film(found, rate_hz=rate_hz, tier=tier), rate_hz=rate_hz, tier=tier)


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
    """Yield what is found in each of a film's chunks, in the mains and in the sides where the blocks have any.

    Nothing is believed yet, nor are the mixes merged, since that depends on all of the film.
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
            yield {"mains": replace(mains, shots=place(mains.shots))}
        return
    once, again = tee(film)
    search_sides = partial(search, tier=side_rules(tier))
    for chunk, aside in aligned_chunks(cut(once), cut(map(side_as_main, again)), core_pieces=core_pieces):
        mains, sides = search(chunk), search_sides(aside, over=chunk)
        # as if the sides heard all of them: whether they do, the whole film tells
        in_sides, beside = (place(each.shots, side_onsets=[s.onset for s in each.shots]) for each in (mains, sides))
        heard = in_sides if channels is None or channels.centre is None else place(mains.shots)
        yield {
            "mains": replace(mains, shots=heard, heard_beside=in_sides),
            "sides": replace(sides, shots=beside),
        }


def _search_chunk(
    chunk: Chunk,
    grid: Grid,
    tier: QualityRules,
    verifier: Verifier,
    rate_hz: int,
    over: Chunk | None = None,
) -> MixResult:
    """Return what is found in a chunk of one mix, with its places in the samples of a film of that rate.

    What the mix `over` it covers is not looked at, and what is heard there as well is told.
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
    as_well = np.zeros(chosen.size, np.bool_)
    if over is not None:
        as_well = heard_as_well(chunk.samples, over.samples, found.onsets[chosen], grid.rate_hz)
    shots = _segmented(chunk, found, verdicts, shown, scored.sounds, chosen, grid=grid, tier=tier)
    refused = [
        unlike_a_shot(int(scored.onsets[index]), float(verdicts.probability[index]))
        for index in np.flatnonzero(~worth & (verdicts.probability >= tier.verify.report_from))
    ]
    in_film_at = np.array([film_sample(sample, rate_hz) for sample in scored.onsets.tolist()], np.intp)
    shots, refused = in_film(shots, refused, rate_hz)
    return MixResult(shots, refused, replace(scored, onsets=in_film_at), shots, as_well)


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
        shots.append(with_evidence(shot, **evidence))
    return shots

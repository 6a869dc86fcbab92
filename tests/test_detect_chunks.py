"""A film is searched chunk by chunk: where one ends and another begins, nothing is lost, cut or found twice."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect.candidates import describe_candidates, let_all_pass
from blastline.detect.chunks import (
    CORE_PIECES,
    LEFT_PIECES,
    RIGHT_PIECES,
    SHORT_CORE_PIECES,
    Chunk,
    chunks,
    track_peaks_dbfs,
)
from blastline.detect.segment import segment
from blastline.detect.tracks import Grid, pieces
from blastline.model import Clip, Shot
from blastline.ruleset import load_rules
from blastline.ruleset.tables import LONGEST_DECAY_MS, SegmentRules

RATE_HZ = 48_000
GRID = Grid(RATE_HZ)
TIER = load_rules("standard").tier
BORDER = CORE_PIECES * GRID.piece
"""Where the first core of a film ends and the second begins."""


def film_with(sound: NDArray[np.float64], at: int) -> list[Chunk]:
    """Return the chunks of a film with one sound in it, just long enough to have two."""
    film = 1e-5 * np.random.default_rng(2).standard_normal((CORE_PIECES + RIGHT_PIECES + 2) * GRID.piece)
    film[at : at + sound.size] += sound
    samples = film.astype(np.float32)[:, None]
    return [copied(chunk) for chunk in chunks(pieces([Clip(samples, RATE_HZ)], RATE_HZ))]


def copied(chunk: Chunk) -> Chunk:
    """Return a chunk that holds when the next one is asked for."""
    tracks = {name: getattr(chunk, name).copy() for name in ("samples", "peak", "slope", "bands")}
    return replace(chunk, **tracks)


def swelling(rise_ms: float) -> NDArray[np.float64]:
    """Return a bang that rises steadily and dies away."""
    rise, fall = (np.arange(round(ms * 48)) for ms in (rise_ms, 60.0))
    envelope = np.concatenate([(rise + 1) / rise.size, np.exp(-fall / 480.0)])
    return np.asarray(0.3 * envelope * np.random.default_rng(5).uniform(-1.0, 1.0, envelope.size), np.float64)


def test_cores_tile_the_film_and_have_their_surroundings() -> None:
    film = film_with(swelling(1.0), BORDER)
    assert len(film) == 2
    assert [chunk.core.start for chunk in film] == [0, BORDER]
    for one, other in pairwise(film):
        assert other.core.start == one.core.stop == one.stop - RIGHT_PIECES * GRID.piece
        assert other.start == other.core.start - LEFT_PIECES * GRID.piece


def test_a_sound_is_as_loud_as_its_loudest_moment_within_20_ms() -> None:
    click_at = BORDER // 2
    chunk = film_with(np.array([0.5]), click_at)[0]
    before = np.array([25, 18, 10, 2]) * RATE_HZ // 1000
    peaks_dbfs = track_peaks_dbfs(chunk, click_at - before, GRID)
    assert peaks_dbfs[0] < -70.0
    assert np.ptp(peaks_dbfs[1:]) == 0.0
    assert peaks_dbfs[1] > -20.0


def test_short_cores_find_what_long_ones_do() -> None:
    random = np.random.default_rng(9)
    film = 1e-5 * random.standard_normal((CORE_PIECES + 6) * GRID.piece)
    for at in random.integers(0, film.size - 2 * RATE_HZ, 80).tolist():
        bang = random.uniform(0.01, 1.0) * swelling(random.uniform(0.05, 3.0))
        film[at : at + bang.size] += bang
    clip = Clip(film.astype(np.float32)[:, None], RATE_HZ)
    (onsets, rows), (onsets_by_short, rows_by_short) = (
        candidates_in(chunks(pieces([clip], RATE_HZ), core_pieces)) for core_pieces in (CORE_PIECES, SHORT_CORE_PIECES)
    )
    assert onsets.size > 40
    assert np.array_equal(onsets, onsets_by_short)
    np.testing.assert_allclose(rows, rows_by_short, atol=1e-3)


def candidates_in(film: Iterable[Chunk]) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return the onsets of all candidates in a film's samples, and their features."""
    seen = [
        (chunk.start, describe_candidates(chunk, GRID, TIER, gate=let_all_pass, screen=let_all_pass)) for chunk in film
    ]
    return np.concatenate([start + each.onsets for start, each in seen]), np.concatenate(
        [each.rows for _, each in seen]
    )


def announced() -> NDArray[np.float64]:
    """Return a bang and, 2 ms before it, a click of half a millisecond, which rises more over what was before."""
    click = np.zeros(96)
    click[:24] = 0.03 * np.random.default_rng(1).choice([-1.0, 1.0], 24)
    return np.concatenate([click, swelling(0.05)])


@pytest.mark.parametrize("beside", [-120, -60, -20, -1, 0, 1, 30])
@pytest.mark.parametrize(("sound", "begins"), [(swelling(3.0), 0), (announced(), 96)], ids=["swelling", "announced"])
def test_what_begins_beside_the_border_of_two_cores_is_found_once(
    sound: NDArray[np.float64], begins: int, beside: int
) -> None:
    """Its steepest step may lie in the other core, before its first sample or after it."""
    at = BORDER + beside
    onsets: list[int] = []
    for chunk in film_with(sound, at - begins):
        found = describe_candidates(chunk, GRID, TIER, gate=let_all_pass, screen=let_all_pass).onsets + chunk.start
        assert np.all((found >= chunk.core.start) & (found < chunk.core.stop))
        onsets += found.tolist()
    assert sum(abs(onset - at) < 1.5 * 48 for onset in onsets) == 1


def lasting() -> NDArray[np.float64]:
    """Return faint noise for a fourth of a second, then a bang that is heard for over 4 s, with a late echo."""
    rng = np.random.default_rng(3)
    sound = 1e-5 * rng.standard_normal(5 * RATE_HZ)
    onset = RATE_HZ // 4
    sound[onset:] += 0.03 * rng.standard_normal(sound.size - onset)
    blast = np.exp(-np.arange(RATE_HZ // 50) / 30.0)
    for at_ms, gain in ((0.0, 0.9), (LONGEST_DECAY_MS - 20.0, 0.6)):
        start = onset + round(at_ms * RATE_HZ / 1000.0)
        sound[start : start + blast.size] += gain * blast
    return sound


def segmented(at: int, rules: SegmentRules) -> Shot:
    """Return the parts of the long bang where it begins at a sample of a film."""
    sound = lasting()
    chunk = next(each for each in film_with(sound, at - RATE_HZ // 4) if each.core.start <= at < each.core.stop)
    return segment(
        chunk.samples,
        at - chunk.start,
        film_start=chunk.start,
        film_stop=chunk.stop,
        confidence=1.0,
        rate_hz=RATE_HZ,
        rules=rules,
    )


def test_the_longest_shot_that_rules_may_ask_for_is_as_long_wherever_it_begins() -> None:
    longest = {"longest_ms": LONGEST_DECAY_MS, "latest_reflection_ms": LONGEST_DECAY_MS}
    rules = msgspec.convert(msgspec.to_builtins(TIER.segment) | longest, SegmentRules)
    for at in (BORDER - 1, BORDER - 20 * GRID.piece):
        shot = segmented(at, rules)
        assert len(shot.span) * 1000.0 / RATE_HZ == LONGEST_DECAY_MS
        assert shot.reflections[-1].delay_ms == pytest.approx(LONGEST_DECAY_MS - 20.0, abs=0.1)

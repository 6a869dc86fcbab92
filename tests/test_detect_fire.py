"""Rows of even fire: what makes one, and when it is believed, as a whole."""

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import expit, logit

from blastline.detect.backdrop import LEVELS
from blastline.detect.fire import ScoredCandidates, even_rows, in_long_rows, worth_a_look
from blastline.detect.pace import automatic, evenly_placed, rows_at
from blastline.detect.verify import LogOdds, Verdicts, combined_log_odds, log_odds_in
from blastline.model import EvenRow
from blastline.ruleset import load_rules
from blastline.units import ms_from_samples, samples_from_ms

RATE_HZ = 48_000
TIER = load_rules("standard").tier
VERIFY, BURSTS = TIER.verify, TIER.bursts
FAST_MS = (BURSTS.shortest_gap_ms + BURSTS.longest_gap_ms) / 2


def told(
    probability: Sequence[float],
    screened: Sequence[float] | None = None,
    gap_ms: float = FAST_MS,
    peaks_dbfs: NDArray[np.float64] | None = None,
) -> list[EvenRow | None]:
    """Return what is told of each sound of a row."""
    onsets = np.array([samples_from_ms(n * gap_ms, RATE_HZ) for n in range(len(probability))], np.intp)
    by_screen = np.array(probability if screened is None else screened)
    odds = log_odds_in(Verdicts(np.array(probability), by_screen, np.full(onsets.size, 2)))
    peaks_dbfs = np.zeros(onsets.size) if peaks_dbfs is None else peaks_dbfs
    scored = ScoredCandidates(onsets, peaks_dbfs, odds, np.zeros((onsets.size, LEVELS), np.int16))
    return even_rows(scored, rate_hz=RATE_HZ, tier=TIER)


def rows(onsets_ms: list[float], peaks_dbfs: list[float] | None = None, rate_hz: int = RATE_HZ) -> list[list[int]]:
    onsets = np.array([samples_from_ms(at_ms, rate_hz) for at_ms in onsets_ms], np.intp)
    peaks = np.zeros(onsets.size) if peaks_dbfs is None else np.array(peaks_dbfs)
    return [row.tolist() for row in rows_at(onsets, peaks, automatic(BURSTS), rate_hz=rate_hz)]


@pytest.mark.parametrize("gap_ms", [BURSTS.shortest_gap_ms, FAST_MS, BURSTS.longest_gap_ms])
@pytest.mark.parametrize("rate_hz", [44_100, 48_000, 96_000])
def test_a_row_is_fast_even_and_long_enough(gap_ms: float, rate_hz: int) -> None:
    fewest = BURSTS.fewest_even
    whole_ms = ms_from_samples(samples_from_ms(gap_ms, rate_hz), rate_hz)
    assert rows([n * whole_ms for n in range(fewest)], rate_hz=rate_hz) == [list(range(fewest))]
    assert rows([n * whole_ms for n in range(fewest - 1)], rate_hz=rate_hz) == []


def test_neither_slower_nor_faster_than_a_gun_is_a_row() -> None:
    for gap_ms in (BURSTS.shortest_gap_ms / 2.5, BURSTS.longest_gap_ms + 1.0):
        assert rows([n * gap_ms for n in range(BURSTS.fewest_even)]) == []


def test_a_pace_that_drifts_out_of_what_guns_do_ends_the_row() -> None:
    change = (1.0 + 0.9 * BURSTS.unevenness) ** np.arange(18)
    for gaps_ms in (FAST_MS * change, FAST_MS / change):
        assert gaps_ms.min() < BURSTS.shortest_gap_ms or gaps_ms.max() > BURSTS.longest_gap_ms
        (row,) = rows(np.cumsum(gaps_ms).tolist())
        within = (gaps_ms >= BURSTS.shortest_gap_ms) & (gaps_ms <= BURSTS.longest_gap_ms)
        assert row == list(range(np.count_nonzero(within[1:]) + 1))


def test_a_pace_may_drift_but_not_stumble() -> None:
    drifting = np.cumsum(FAST_MS * (1.0 + 0.9 * BURSTS.unevenness) ** np.arange(5))
    stumbling = np.cumsum(FAST_MS * (1.0 + 1.5 * BURSTS.unevenness) ** (np.arange(12) % 2))
    assert rows(drifting.tolist()) == [[0, 1, 2, 3, 4]]
    assert rows(stumbling.tolist()) == []


def test_what_sounds_between_breaks_no_row_and_is_not_of_it() -> None:
    rounds_ms = [n * FAST_MS for n in range(6)]
    places_ms = sorted([*rounds_ms, 0.3 * FAST_MS, 2.6 * FAST_MS, 2.7 * FAST_MS, 4.5 * FAST_MS])
    peaks_dbfs = [-6.0 if at_ms in rounds_ms else -6.0 - 2.0 * BURSTS.echo_drop_db for at_ms in places_ms]
    for peaks in (peaks_dbfs, None):
        assert rows(places_ms, peaks) == [[places_ms.index(at_ms) for at_ms in rounds_ms]]


def test_what_is_louder_or_softer_is_of_no_row() -> None:
    rounds_ms = [n * FAST_MS for n in range(BURSTS.fewest_even)]
    for step_db in (-BURSTS.echo_drop_db - 0.1, BURSTS.echo_drop_db + 0.1):
        assert rows(rounds_ms, [-6.0, -6.0, -6.0 + step_db, -6.0]) == []
        assert rows(rounds_ms, [-6.0, -6.0, -6.0 + 0.9 * step_db, -6.0]) == [[0, 1, 2, 3]]


def test_no_sound_is_in_two_rows_and_a_delay_or_gain_changes_none() -> None:
    rng = np.random.default_rng(11)
    starts_ms = rng.uniform(0.0, 20_000.0, 20)
    even_ms = [start + np.arange(rng.integers(3, 9)) * rng.uniform(40.0, 150.0) for start in starts_ms]
    places_ms = np.unique(np.round(np.concatenate([rng.uniform(0.0, 20_000.0, 150), *even_ms]))).tolist()
    peaks_dbfs = rng.uniform(-8.0, -4.0, len(places_ms))
    found = rows(places_ms, peaks_dbfs.tolist())
    assert len(found) >= 5
    members = [place for row in found for place in row]
    assert len(members) == len(set(members))
    assert [len(row) for row in found] == sorted((len(row) for row in found), reverse=True)
    assert rows([at_ms + 123.0 for at_ms in places_ms], (peaks_dbfs - 40.0).tolist()) == found


def test_a_row_without_an_end_is_taken_in_pieces_that_leave_no_sound_out() -> None:
    count = 2_000
    jitter_ms = np.random.default_rng(3).uniform(-0.01, 0.01, count) * FAST_MS
    found = rows((np.arange(count) * FAST_MS + jitter_ms + 1.0).tolist())
    assert sorted(place for row in found for place in row) == list(range(count))
    assert len(found) < count / 100
    assert all(np.all(np.diff(row) == 1) for row in found)


@pytest.mark.parametrize("count", [4, 11, 31])
def test_many_rows_far_apart_are_each_what_they_are_alone(count: int) -> None:
    random = np.random.default_rng(count)
    gaps_ms = random.uniform(50.0, 140.0, 2600 // count)
    film_ms = (5000.0 * np.arange(gaps_ms.size)[:, None] + gaps_ms[:, None] * np.arange(count)).ravel()
    assert sorted(rows(film_ms.tolist())) == np.arange(film_ms.size).reshape(-1, count).tolist()


def taken_together(by_networks: float, by_screen: float) -> float:
    """Return the probability that two networks of one mind and the screen give."""
    (odds,) = combined_log_odds(np.array([2.0 * by_networks]), 2, np.array([by_screen]))
    return float(expit(odds))


@pytest.mark.parametrize("networks", [1, 2, 4])
def test_the_odds_of_the_networks_are_what_the_screen_leaves(networks: int) -> None:
    rng = np.random.default_rng(2)
    by_networks, by_screen = rng.uniform(-4.0, 4.0, (2, 50))
    probability = expit(combined_log_odds(networks * by_networks, networks, by_screen))
    odds = log_odds_in(Verdicts(probability, expit(by_screen), np.full(50, networks)))
    np.testing.assert_allclose(odds.by_networks, by_networks, atol=1e-9)
    np.testing.assert_allclose(odds.by_all, logit(probability), atol=1e-9)
    assert np.isfinite(
        log_odds_in(Verdicts(np.array([0.0, 1.0]), np.array([1.0, 0.0]), np.full(2, 2))).by_networks
    ).all()


def test_a_row_is_fire_where_its_mean_odds_are_enough() -> None:
    enough = float(logit(VERIFY.even_threshold))
    offs = [-0.9, 0.9, -0.4]
    assert told(expit([enough + off for off in (*offs, 0.4 + 1e-9)]).tolist()) == ["fire"] * 4
    assert told(expit([enough + off for off in (*offs, 0.39)]).tolist()) == [None] * 4


def test_the_networks_alone_may_settle_it() -> None:
    """The screen takes fire for a machine; each sound is then unlikely, and all are, in the mean."""
    by_networks, by_screen = float(logit(VERIFY.even_networks_threshold)) + 0.1, -4.0
    probability = taken_together(by_networks, by_screen)
    assert probability < VERIFY.even_threshold
    assert told([probability] * 5, [float(expit(by_screen))] * 5) == ["fire"] * 5
    assert told([probability] * 5) == [None] * 5


def test_a_row_that_is_fire_has_a_round_where_the_networks_alone_hear_hardly_any() -> None:
    """A gun that fires on time skips none, though a voice may cover one; a finger may, at its slower pace."""
    said = [0.95, 0.95, 0.1 * VERIFY.round_threshold, 0.95, 0.99, 0.99]
    assert told(said) == ["fire"] * 6
    assert told(said, gap_ms=500.0) == ["fire"] * 2 + [None] + ["fire"] * 3


def test_a_long_row_is_fire_or_none_and_a_short_one_may_be_anything() -> None:
    fewest = BURSTS.fewest_as_one
    assert told([0.2] * fewest) == ["no fire"] * fewest
    assert told([0.2] * (fewest - 1)) == [None] * (fewest - 1)
    assert told([0.2] * fewest, gap_ms=BURSTS.longest_gap_ms + 1.0) == [None] * fewest


def test_what_a_whole_row_told_of_its_sounds_half_of_them_does_not_take_back() -> None:
    """Every other sound of a machine is a row at half its pace, which may be that of a finger."""
    said = [0.95, 0.01] * 8
    assert told(said[::2], gap_ms=200.0) == ["fire"] * 8
    assert told(said, gap_ms=100.0) == ["no fire"] * 16


@pytest.mark.parametrize("gap_ms", [TIER.rows.shortest_gap_ms, 500.0, TIER.rows.longest_gap_ms])
def test_a_slow_row_is_fire_where_the_networks_alone_are_as_sure_of_it_as_of_a_shot(gap_ms: float) -> None:
    """Somebody pulls the trigger at a pace at which steps and hammers come as well; the screen doubts all of them."""
    enough, by_screen = float(logit(VERIFY.threshold)), -4.0
    for above, row in ((0.1, "fire"), (-0.1, None)):
        probability = taken_together(enough + above, by_screen)
        assert probability < VERIFY.threshold
        assert told([probability] * 4, [float(expit(by_screen))] * 4, gap_ms=gap_ms) == [row] * 4
    assert told([0.99] * (TIER.rows.fewest - 1), gap_ms=gap_ms) == [None] * (TIER.rows.fewest - 1)
    assert told([0.99] * 4, gap_ms=TIER.rows.longest_gap_ms + 1.0) == [None] * 4


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_between_the_paces_of_machine_guns_and_of_steps_a_row_needs_the_more_the_slower_it_is(share: float) -> None:
    gap_ms = BURSTS.longest_gap_ms + share * (TIER.rows.shortest_gap_ms - BURSTS.longest_gap_ms)
    least, most = float(logit(VERIFY.even_networks_threshold)), float(logit(VERIFY.threshold))
    for above, row in ((0.02, "fire"), (-0.02, None)):
        probability = taken_together(least + share * (most - least) + above, -4.0)
        assert told([probability] * 4, [float(expit(-4.0))] * 4, gap_ms=gap_ms) == [row] * 4


def test_what_the_screen_doubts_is_looked_at_where_it_makes_a_row_with_what_it_does_not() -> None:
    count = BURSTS.fewest_even
    onsets = np.array([samples_from_ms(n * FAST_MS, RATE_HZ) for n in range(count)], np.intp)

    def looked_at(*said: float) -> list[bool]:
        likely, at = np.array(said), onsets[: len(said)]
        passed = worth_a_look(at, np.zeros(at.size), likely, least=least, rate_hz=RATE_HZ, tier=TIER)
        return [bool(each) for each in passed]

    least = VERIFY.look_from / 2.0
    doubted = 0.75 * VERIFY.look_from
    assert looked_at(VERIFY.look_from, *[doubted] * (count - 1)) == [True] * count
    assert looked_at(*[doubted] * count) == [False] * count
    assert looked_at(VERIFY.look_from, *[doubted] * (count - 2)) == [True] + [False] * (count - 2)
    assert looked_at(VERIFY.look_from, *[doubted] * (count - 2), 0.9 * least) == [True] + [False] * (count - 1)


def long_told(
    count: int, by_networks: float, as_burst: float, peaks_dbfs: NDArray[np.float64] | None = None
) -> set[EvenRow | None]:
    """Return what is told of the sounds of a row, by their probabilities as they are and as if in a burst."""
    onsets = samples_from_ms(FAST_MS, RATE_HZ) * np.arange(count)
    usual, alike = (np.full(count, float(logit(p))) for p in (by_networks, as_burst))
    peaks_dbfs = np.zeros(count) if peaks_dbfs is None else peaks_dbfs
    candidates = ScoredCandidates(onsets, peaks_dbfs, LogOdds(usual, usual, alike), np.zeros((count, LEVELS), np.int16))
    return set(even_rows(candidates, rate_hz=RATE_HZ, tier=TIER))


def test_a_row_longer_than_a_burst_is_judged_by_its_sounds_as_if_each_were_in_one_as_well() -> None:
    """And as it is, it need not be likely but no machine either."""
    fewest, sure, least = BURSTS.fewest_sustained, VERIFY.sustained_threshold + 1e-3, VERIFY.report_from + 1e-3
    assert long_told(fewest, least, sure) == {"sustained fire"}
    assert long_told(fewest, least, sure - 2e-3) == {"no fire"}
    assert long_told(fewest, least - 2e-3, sure) == {"no fire"}
    assert long_told(fewest - 1, least, sure) == {"no fire"}


def test_a_row_longer_than_a_magazine_is_judged_so_alone() -> None:
    most, likely, least = BURSTS.most_unsure, VERIFY.even_networks_threshold + 1e-3, VERIFY.report_from
    assert long_told(most, likely, least) == {"fire"}
    assert long_told(most + 1, likely, least) == {"no fire"}
    assert long_told(most + 1, likely, VERIFY.sustained_threshold + 1e-3) == {"sustained fire"}


def test_the_level_of_sustained_fire_may_vary_by_more_than_that_of_a_burst() -> None:
    least, sure, count = VERIFY.report_from + 1e-3, VERIFY.sustained_threshold + 1e-3, BURSTS.fewest_sustained
    loud, soft = 0.0, 0.1 - BURSTS.sustained_within_db
    assert long_told(count, least, sure, peaks_dbfs=np.resize((loud, soft), count)) == {"sustained fire"}
    assert long_told(count, least, sure, peaks_dbfs=np.resize((loud, soft - 0.2), count)) == {None}


def test_a_burst_stays_fire_where_something_like_a_machine_goes_on_at_its_pace() -> None:
    rounds, others = BURSTS.fewest_as_one, BURSTS.fewest_sustained
    by_networks = np.repeat((VERIFY.threshold, 1e-3), (rounds, others))
    peaks_dbfs = np.repeat((0.0, -BURSTS.echo_drop_db - 1.0), (rounds, others))
    assert told(by_networks.tolist(), peaks_dbfs=peaks_dbfs) == ["fire"] * rounds + ["no fire"] * others


@pytest.mark.parametrize("count", [0, 5, BURSTS.fewest_sustained - 1, BURSTS.fewest_sustained, 100])
def test_long_rows_are_those_of_more_sounds_than_a_learnt_burst_has(count: int) -> None:
    row = 480_000 + samples_from_ms(FAST_MS, RATE_HZ) * np.arange(count)
    others = np.random.default_rng(count).integers(0, 400_000, 50)
    onsets = np.unique(np.concatenate([others, row]))
    found = in_long_rows(onsets, np.zeros(onsets.size), rate_hz=RATE_HZ, rules=BURSTS)
    assert [onsets[each].tolist() for each in found] == ([row.tolist()] if count >= BURSTS.fewest_sustained else [])


def test_of_two_sounds_where_a_round_is_due_the_nearer_is_the_round() -> None:
    row_ms = 100.0 * np.arange(8)
    all_ms = np.sort(np.concatenate([row_ms, row_ms[2:] - 0.8 * BURSTS.unevenness * 100.0])).tolist()
    assert [all_ms[place] for place in rows(all_ms)[0]] == row_ms.tolist()


@pytest.mark.parametrize("seed", range(6))
def test_what_a_row_holds_is_evenly_placed_and_what_is_alone_is_not(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pace = automatic(BURSTS)
    gap = samples_from_ms(rng.uniform(45.0, 150.0), RATE_HZ)
    due = 48_000 + gap * np.arange(pace.fewest + seed)
    row = due + np.round(rng.uniform(-0.01, 0.01, due.size) * gap).astype(np.intp)
    alone = np.array([5_000, 40_000 - pace.fewest * 9_600, row[-1] + 96_000], np.intp)
    onsets = np.sort(np.concatenate([row, alone]))
    (found,) = rows_at(onsets, np.zeros(onsets.size), pace, rate_hz=RATE_HZ)
    assert onsets[found].tolist() == row.tolist()
    assert onsets[evenly_placed(onsets, np.zeros(onsets.size), pace, rate_hz=RATE_HZ)].tolist() == row.tolist()
    louder = np.where(np.isin(onsets, row[:: pace.fewest - 1]), 2.0 * pace.within_db, 0.0)
    assert not evenly_placed(onsets, louder, pace, rate_hz=RATE_HZ).any(), "no four next to each other are alike"


def test_too_few_sounds_are_no_row() -> None:
    pace = automatic(BURSTS)
    for count in range(pace.fewest):
        onsets = samples_from_ms(FAST_MS, RATE_HZ) * np.arange(1, count + 1)
        assert not evenly_placed(onsets, np.zeros(count), pace, rate_hz=RATE_HZ).any()

"""What keeps the beat of music and what does not: shots lie anywhere, drums on one grid."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from blastline.detect.backdrop import LEVELS
from blastline.detect.beat import on_the_beat
from blastline.detect.company import in_company
from blastline.detect.fire import ScoredCandidates
from blastline.detect.verify import LogOdds
from blastline.model import Shot, ShotEvidence, Span
from blastline.ruleset import load_rules

Onsets = NDArray[np.intp]

RATE_HZ = 48_000
TIER = load_rules("standard").tier


def samples(times_s: NDArray[np.floating], rate_hz: int = RATE_HZ) -> Onsets:
    return np.round(np.sort(times_s) * rate_hz).astype(np.intp)


def kept(
    shots: Onsets,
    onsets: Onsets,
    rate_hz: int = RATE_HZ,
    kinds: NDArray[np.intp] | None = None,
    peaks_dbfs: NDArray[np.float64] | None = None,
) -> list[bool]:
    """Return which shots, all of them heard, keep the beat of what is heard; without kinds no two sounds are alike."""
    kind = np.arange(onsets.size) if kinds is None else kinds
    sounds = np.random.default_rng(7).integers(-60, 1, (onsets.size, LEVELS)).astype(np.int16)
    odds = np.zeros(onsets.size)
    peaks = odds if peaks_dbfs is None else peaks_dbfs
    heard = ScoredCandidates(onsets, peaks, LogOdds(odds, odds, odds), sounds[kind])
    asked = np.flatnonzero(np.isin(onsets, shots))
    found = on_the_beat(asked, heard, rate_hz=rate_hz, rules=TIER.beat, bursts=TIER.bursts)
    return [bool(each) for each in found]


def keep_no_beat(onsets: Onsets) -> bool:
    """Return whether none of some sounds keeps a beat, whether all are alike or no two of them."""
    return not any(kept(onsets, onsets) + kept(onsets, onsets, kinds=np.zeros(onsets.size, np.intp)))


def rhythm(period_s: float, *, seed: int = 0, length_s: float = 24.0, start_s: float = 0.4321) -> NDArray[np.float64]:
    """Return drums on a third of the places of a grid, which a person or a codec moves by a millisecond or two."""
    rng = np.random.default_rng(seed)
    places = np.flatnonzero(rng.random(round(length_s / period_s)) < 0.34)
    return start_s + period_s * places + rng.uniform(-0.0015, 0.0015, places.size)


def may_be_written(period_s: float) -> bool:
    """Return whether a grid is one of multiples of 50 ms, as a film at one of the usual speeds plays them."""
    multiples = [period_s / 0.05 * pull * pal for pull in (1.0, 1.001, 1.0 / 1.001) for pal in (1.0, 0.96, 1.0 / 0.96)]
    return any(abs(each - round(each)) < 0.03 for each in multiples)


@given(st.floats(0.0911, 0.26), st.integers(0, 99))
@settings(max_examples=60)
def test_a_drum_keeps_the_beat_and_what_lies_beside_it_does_not(period_s: float, seed: int) -> None:
    assume(not may_be_written(period_s))
    drums = rhythm(period_s, seed=seed)
    free = drums[np.argmax(np.diff(drums))]
    beside = free + (1.4 if 1.4 * period_s > 0.17 else 2.4) * period_s
    onsets = samples(np.append(drums, beside))
    gaps_s = np.diff(onsets, prepend=-RATE_HZ, append=99 * RATE_HZ) / RATE_HZ
    alone = np.minimum(gaps_s[:-1], gaps_s[1:]) > 0.16
    expected = ~np.isin(onsets, samples(np.array([beside])))
    np.testing.assert_array_equal(np.array(kept(onsets, onsets))[alone], expected[alone])


@pytest.mark.parametrize("seed", range(12))
def test_what_comes_at_random_keeps_no_beat(seed: int) -> None:
    rng = np.random.default_rng(seed)
    onsets = samples(rng.uniform(0.0, 240.0, int(rng.integers(60, 700))))
    assert keep_no_beat(onsets)


@pytest.mark.parametrize("rounds_a_minute", [450.0, 600.0, 660.0])
@pytest.mark.parametrize("seed", range(10))
def test_bursts_of_one_gun_keep_no_beat(rounds_a_minute: float, seed: int) -> None:
    """Each of them is a grid by itself, and all have one period, but each begins anywhere."""
    rng = np.random.default_rng(seed)
    starts = np.cumsum(rng.uniform(1.5, 3.0, 12))
    onsets = samples(np.concatenate([start + 60.0 / rounds_a_minute * np.arange(8) for start in starts]))
    assert keep_no_beat(onsets)


@pytest.mark.parametrize("step_s", [0.1, 0.25, 0.5, 1.0])
@pytest.mark.parametrize("speed", [1.0, 1.001, 1.0 / 1.001, 0.96, 25.0 / 24.0])
@pytest.mark.parametrize("delay_s", [0.0, 0.1234])
def test_a_scene_whose_times_were_written_down_keeps_no_beat(step_s: float, speed: float, delay_s: float) -> None:
    """Multiples of half a second are multiples of an eighth and of a sixth, too; at the speed of television as well."""
    rng = np.random.default_rng(1)
    times = step_s * np.flatnonzero(rng.random(round(60.0 / step_s)) < 0.6)
    onsets = samples(speed * (delay_s + times))
    assert keep_no_beat(onsets)


@pytest.mark.parametrize("aside_ms", [6.0, 7.0, 8.0])
def test_clips_may_begin_some_milliseconds_after_the_times_that_were_written_down(aside_ms: float) -> None:
    rng = np.random.default_rng(2)
    onsets = samples(0.5 * np.arange(1, 41) + rng.choice([0.0, aside_ms / 1000.0], 40))
    assert keep_no_beat(onsets)


@pytest.mark.parametrize("rounds_a_minute", [480.0, 540.0, 600.0, 660.0, 720.0])
@pytest.mark.parametrize("every_s", [0.5, 1.0])
def test_bursts_that_begin_at_times_that_were_written_down_keep_no_beat(rounds_a_minute: float, every_s: float) -> None:
    """Their other rounds do not lie at such times."""
    rng = np.random.default_rng(3)
    starts = every_s * np.cumsum(rng.integers(2, 5, 24))
    onsets = samples(np.concatenate([start + 60.0 / rounds_a_minute * np.arange(3) for start in starts]))
    assert keep_no_beat(onsets)


@pytest.mark.parametrize("gap_s", [0.21, 0.37, 0.733, 1.37, 2.3333])
@pytest.mark.parametrize("pauses", [0, 3])
@pytest.mark.parametrize("strays", [0, 1, 4, 8])
def test_an_even_row_is_no_rhythm(gap_s: float, pauses: int, strays: int) -> None:
    """Somebody may fire like that, among other sounds: `rows` judges it."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        row = 3.21 + gap_s * rng.choice(np.arange(40 + pauses), 40, replace=False)
        onsets = samples(np.append(row + rng.uniform(-1e-3, 1e-3, 40), rng.uniform(3.0, 3.0 + 40 * gap_s, strays)))
        assert keep_no_beat(onsets)


def test_sustained_fire_of_which_some_rounds_were_not_heard_is_no_rhythm() -> None:
    """What follows a round that is missing seems to begin something."""
    for seed, gap_s in enumerate([0.0933, 0.1117, 60.0 / 450.0, 0.147]):
        rng = np.random.default_rng(seed)
        rounds = 1.37 + gap_s * np.sort(rng.choice(np.arange(150), 115, replace=False))
        onsets = samples(rounds + rng.uniform(-1e-3, 1e-3, rounds.size))
        assert keep_no_beat(onsets)


@pytest.mark.parametrize("gap_s", [0.0937, 0.1171, 0.1429])
@pytest.mark.parametrize("seed", range(6))
def test_rolls_at_the_pace_of_a_gun_that_share_a_grid_for_longer_than_any_belt_lasts_are_music(
    gap_s: float, seed: int
) -> None:
    """They begin on it as well: one row, however long, is for the rules on fire to judge."""
    rng = np.random.default_rng(seed)
    played = np.concatenate([np.arange(bar) < rng.integers(3, bar - 1) for bar in rng.integers(6, 14, 90)])
    places = np.flatnonzero(played[: round(60.0 / gap_s)])
    onsets = samples(1.234 + gap_s * places + rng.uniform(-1e-3, 1e-3, places.size))
    assert np.mean(kept(onsets, onsets)) > 0.9


@pytest.mark.parametrize("gap_s", [0.0937, 0.1091])
def test_long_bursts_and_short_ones_on_one_grid_may_be_fire(gap_s: float) -> None:
    """A scene may be cut so that its pauses are whole rounds; music plays rolls of more than 16 seldom."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        played = [np.arange(n + rng.integers(3, 8)) < n for n in rng.permutation(np.tile([17, 18, 3, 20], 20))]
        places = np.flatnonzero(np.concatenate(played)[: round(60.0 / gap_s)])
        assert keep_no_beat(samples(1.234 + gap_s * places + rng.uniform(-1e-3, 1e-3, places.size)))


@pytest.mark.parametrize("length_s", [30.0, 45.0])
@pytest.mark.parametrize("unheard", [0.05, 0.1, 0.2])
def test_sustained_fire_that_goes_on_for_longer_than_a_window_is_no_music(length_s: float, unheard: float) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        rounds = np.flatnonzero(rng.random(round(length_s / 0.1091)) > unheard)
        assert keep_no_beat(samples(1.37 + 0.1091 * rounds + rng.uniform(-1e-3, 1e-3, rounds.size)))


@pytest.mark.parametrize("pace_s", [0.3, 0.37, 0.45])
@pytest.mark.parametrize("strays", [0, 15])
def test_a_gun_fired_evenly_in_strings_keeps_no_beat(pace_s: float, strays: int) -> None:
    """The shots of a string follow from its first two: they are no more looks at a grid."""
    refused: list[bool] = []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        gaps = [
            np.append(pace_s * rng.normal(1.0, 0.03, rng.integers(3, 12)), rng.uniform(1.1, 3.4)) for _ in range(12)
        ]
        shots = samples(1.3 + np.cumsum(np.concatenate(gaps)))
        heard = np.append(shots, samples(rng.uniform(1.0, 59.0, strays)))
        order = np.argsort(heard, kind="stable")
        refused += kept(shots, heard[order], kinds=np.append(np.zeros(shots.size, int), 1 + np.arange(strays))[order])
    assert np.mean(refused) < 0.02


@pytest.mark.parametrize("step_s", [0.1, 0.25, 0.5])
def test_clips_may_begin_anywhere_near_the_times_that_were_written_down(step_s: float) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        times = step_s * np.flatnonzero(rng.random(round(60.0 / step_s)) < 0.4)
        assert keep_no_beat(samples(1.0 + times + rng.normal(0.0, 0.006, times.size)))


@pytest.mark.parametrize("gap_s", [0.0937, 0.1171, 0.1429])
@pytest.mark.parametrize("late", [0.3, 0.5, 0.7])
def test_long_bursts_of_one_gun_share_no_grid(gap_s: float, late: float) -> None:
    """Each lasts for ten seconds, and the next begins somewhere between the rounds of the one before."""
    burst = gap_s * np.arange(round(10.0 / gap_s))
    starts = 1.234 + np.arange(4) * (round(14.0 / gap_s) + late) * gap_s
    onsets = samples((starts[:, None] + burst).ravel())
    assert keep_no_beat(onsets)


@pytest.mark.parametrize("period_s", [0.0923, 0.1171, 0.1467, 0.187, 0.231, 0.2583])
def test_what_lies_anywhere_over_music_is_on_the_beat_by_chance_alone(period_s: float) -> None:
    """At most twice as often as one grid would have it: each of three windows has its own."""
    refused: list[bool] = []
    for seed in range(30):
        drums = rhythm(period_s, seed=seed, length_s=60.0)
        shots = samples(np.random.default_rng(seed).uniform(2.0, 58.0, 12))
        refused += kept(shots, np.sort(np.append(samples(drums), shots)))
    assert np.mean(refused) < 2.0 * 0.008 / period_s


@pytest.mark.parametrize("period_s", [0.2201, 0.241, 0.2562, 0.2583])
def test_a_shot_halfway_between_two_drums_is_beside_their_grid_whichever_drum_a_window_begins_with(
    period_s: float,
) -> None:
    """A grid of half the period holds all of them as well, and of that the drums may be on every odd place."""
    place = round(36.0 / period_s)
    for seed in range(5):
        drums = rhythm(period_s, seed=seed, length_s=72.0)
        assert all(kept(samples(drums), samples(drums)))
        shot = samples(0.4321 + period_s * np.array([place + 0.5]))
        assert kept(shot, np.sort(np.append(samples(drums), shot))) == [False]


def played_by_hand(period_s: float, seed: int) -> tuple[Onsets, NDArray[np.intp]]:
    """Return drums of two kinds that a person plays, most of them more than 4 ms off, and which of them each is."""
    rng = np.random.default_rng(seed)
    places = np.flatnonzero(rng.random(round(60.0 / period_s)) < 0.34)
    return samples(0.4321 + period_s * places + rng.normal(0.0, 0.007, places.size)), rng.integers(0, 2, places.size)


@pytest.mark.parametrize("period_s", [0.1171, 0.1467, 0.187, 0.231])
@pytest.mark.parametrize("seed", range(4))
def test_strokes_of_one_drum_need_not_keep_the_beat_as_exactly(period_s: float, seed: int) -> None:
    onsets, kinds = played_by_hand(period_s, seed)
    assert np.mean(kept(onsets, onsets, kinds=kinds)) > 0.7
    assert np.mean(kept(onsets, onsets)) < 0.3
    levels_dbfs = np.linspace(0.0, -6.0 * onsets.size, onsets.size)  # no two as loud
    assert np.mean(kept(onsets, onsets, kinds=kinds, peaks_dbfs=levels_dbfs)) < 0.3
    soft_dbfs = np.full(onsets.size, -40.0)
    assert kept(onsets, onsets, kinds=kinds, peaks_dbfs=soft_dbfs) == kept(onsets, onsets, kinds=kinds)


def test_what_keeps_the_beat_does_not_depend_on_what_else_is_asked() -> None:
    onsets, kinds = played_by_hand(0.1467, 3)
    whole = np.array(kept(onsets, onsets, kinds=kinds))
    apart = np.diff(onsets, prepend=-RATE_HZ, append=99 * RATE_HZ) > 0.16 * RATE_HZ
    alone = np.flatnonzero(apart[:-1] & apart[1:])
    for some in (alone[::2], alone[5:], alone[7:9]):
        assert kept(onsets[some], onsets, kinds=kinds) == whole[some].tolist()


@pytest.mark.parametrize("seed", [0, 3, 7])
def test_what_sounds_long_before_changes_nothing(seed: int) -> None:
    """Where no pause parts the sounds, the first one of the film must not place the windows of all."""
    drums = rhythm(0.1171, seed=seed, start_s=50.4321)
    heard = samples(np.append(drums, np.random.default_rng(seed).uniform(0.0, 84.0, 168)))
    late = heard[heard >= 40 * RATE_HZ]
    expected = kept(late, heard)
    for start_s in (1.0, 2.0, 3.0):
        assert kept(late, heard[heard >= start_s * RATE_HZ]) == expected


@pytest.mark.parametrize("period_s", [0.1171, 0.1467, 0.187, 0.231])
@pytest.mark.parametrize("seed", range(4))
def test_shots_of_one_gun_over_drums_keep_no_beat(period_s: float, seed: int) -> None:
    """Ten milliseconds to either side are a sixth of the time and less: more of them do not lie there."""
    drums, kinds = played_by_hand(period_s, seed)
    shots = samples(np.random.default_rng(seed).uniform(2.0, 58.0, 24))
    heard = np.append(drums, shots)
    order = np.argsort(heard, kind="stable")
    told = kept(shots, heard[order], kinds=np.append(kinds, np.full(shots.size, 2))[order])
    assert np.mean(told) < 0.1


def test_a_shot_right_after_a_drum_does_not_fall_with_it() -> None:
    drums = rhythm(0.1871, seed=2)
    free = drums[:-1][np.diff(drums) > 0.3]
    shots = samples(free + 0.05)
    heard = np.sort(np.append(samples(drums), shots))
    assert np.mean(kept(shots, heard)) < 0.1
    told = dict(zip(heard.tolist(), kept(heard, heard), strict=True))
    assert not any(told[onset] for onset in shots.tolist())
    assert np.mean([told[onset] for onset in samples(free).tolist()]) > 0.9


@pytest.mark.parametrize("delay_s", [0.01, 3.7, 3000.0])
def test_a_delay_and_another_rate_change_nothing(delay_s: float) -> None:
    times = np.concatenate([rhythm(0.1171, seed=3), np.random.default_rng(4).uniform(30.0, 60.0, 30)])
    expected = kept(samples(times), samples(times))
    assert 10 < sum(expected) < len(expected)
    assert kept(samples(times + delay_s), samples(times + delay_s)) == expected
    assert kept(samples(times, 96_000), samples(times, 96_000), 96_000) == expected


def test_a_burst_over_music_keeps_all_of_its_rounds() -> None:
    """One of them lies on the grid by chance."""
    drums = rhythm(0.1467, seed=5)
    free = float(drums[np.argmax(np.diff(drums))])
    burst = free + 0.1467 + 0.07 * np.arange(4)
    heard = samples(np.concatenate([drums, burst]))
    shots = samples(burst)
    assert not any(kept(shots, heard))
    assert kept(shots[:1], heard) == [True]


def test_few_sounds_tell_of_no_beat() -> None:
    drums = rhythm(0.12, seed=6)[: TIER.beat.fewest - 1]
    assert not any(kept(samples(drums), samples(drums)))
    assert kept(samples(drums[:0]), samples(drums[:0])) == []


def test_what_keeps_the_beat_is_refused_by_its_name_and_is_company_for_none() -> None:
    def shot(at_s: float, confidence: float, *, on_beat: bool) -> Shot:
        onset = round(at_s * RATE_HZ)
        measured = ShotEvidence(0.9, 3, None, "fallen", on_beat=on_beat)
        span = Span(onset, onset + 4800)
        return Shot(onset, confidence, -6.0, 30.0, Span(onset, onset + 200), (), span, evidence=measured)

    drum, beside = shot(10.0, 0.99, on_beat=True), shot(12.0, 0.6, on_beat=False)
    found, refused = in_company([drum, beside], rate_hz=RATE_HZ, tier=TIER)
    assert found == ()
    assert [each.reason for each in refused] == ["on the beat of music", "alone, and not sure enough for that"]
    free = shot(10.0, 0.99, on_beat=False)
    assert in_company([free, beside], rate_hz=RATE_HZ, tier=TIER)[0] == (free, beside)

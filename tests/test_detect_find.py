"""The detector as a whole, on a small film: what must not change what is found."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from blastline.detect import Detection, find_shots, load_verifier, verifier_of
from blastline.detect.candidates import CandidateFeatures, describe_candidates, let_all_pass, well_apart
from blastline.detect.chunks import CORE_PIECES, Chunk, chunks
from blastline.detect.closer import worth_looking_at
from blastline.detect.features import feature_names
from blastline.detect.find import search_chunks, select_shots
from blastline.detect.fire import ScoredCandidates
from blastline.detect.forest import ForestFile, forest_from, probabilities
from blastline.detect.spectrogram import Spectrograms, spectrograms
from blastline.detect.tracks import Grid, pieces
from blastline.detect.verify import (
    CONFIDENT_LOG_ODDS,
    SCHEMA,
    LogOdds,
    Look,
    ModelFile,
    Sieve,
    SieveFile,
    Verdicts,
    Verifier,
    log_odds_in,
    log_odds_of,
)
from blastline.detect.whole import _nearest
from blastline.errors import RuleError
from blastline.model import Clip, EvenRow, Shot, ShotEvidence, Span
from blastline.ruleset import load_rules, verifier_path
from blastline.synth import Scene, Truth, render_scene, truth_of

RATE_HZ = 48_000
RULES = load_rules("standard")
VERIFIER = verifier_of(RULES.tier)
SCENE = {
    "schema": 1,
    "rate_hz": RATE_HZ,
    "duration_s": 24.0,
    "seed": 11,
    "beds": [{"kind": "dialogue", "level_dbfs": -36.0}, {"kind": "ambience", "level_dbfs": -52.0}],
    "shots": [
        {"at_s": 2.0, "weapon": "shotgun", "environment": "field", "distance_m": 20.0, "peak_dbfs": -3.0},
        {"at_s": 6.5, "weapon": "pistol", "environment": "street", "distance_m": 8.0, "peak_dbfs": -6.0},
        {
            "at_s": 11.0,
            "weapon": "smg",
            "environment": "field",
            "distance_m": 12.0,
            "peak_dbfs": -4.0,
            "burst": {"shots": 5, "rpm": 700.0},
        },
        {"at_s": 19.0, "weapon": "shotgun", "environment": "street", "distance_m": 10.0, "peak_dbfs": -3.0},
    ],
    "negatives": [
        {"at_s": 4.0, "kind": "door", "peak_dbfs": -10.0},
        {"at_s": 14.5, "kind": "clap", "peak_dbfs": -10.0},
        {"at_s": 21.5, "kind": "tom", "peak_dbfs": -12.0},
    ],
}


@pytest.fixture(scope="module")
def film() -> tuple[NDArray[np.float32], Truth]:
    audio = render_scene(msgspec.convert(SCENE, Scene))
    samples = audio.read(0, audio.frames)[:, 0]
    return np.asarray(np.round(samples * 32767.0) / 32768.0, np.float32), truth_of(audio)


def find(samples: NDArray[np.float32], size: int = 65_536) -> Detection:
    blocks = [Clip(samples[at : at + size, None], RATE_HZ, at) for at in range(0, samples.shape[0], size)]
    return find_shots(blocks, rate_hz=RATE_HZ, tier=RULES.tier, verifier=VERIFIER)


def test_every_shot_is_found_where_it_is_and_no_door_clap_or_drum(film: tuple[NDArray[np.float32], Truth]) -> None:
    samples, truth = film
    onsets = np.array([shot.onset for shot in find(samples).shots])
    for true in truth.shots:
        error_ms = np.min(np.abs(onsets - true.onset_sample)) / 48.0
        assert error_ms <= (0.1 if true.burst is None else 10.0)
    for negative in truth.negatives:
        assert not np.any(np.abs(onsets - negative.at_sample) < 0.1 * RATE_HZ)


def test_what_is_a_shot_is_not_refused_and_what_is_refused_is_so_once(film: tuple[NDArray[np.float32], Truth]) -> None:
    found = find(film[0])
    told = [*(shot.onset for shot in found.shots), *(each.at_sample for each in found.rejections)]
    assert len(found.rejections) > 0
    assert len(set(told)) == len(told)


@pytest.mark.parametrize("size", [1, 7, 4096])
def test_the_block_size_changes_nothing(film: tuple[NDArray[np.float32], Truth], size: int) -> None:
    samples = film[0][: (4 if size < 7 else 24) * RATE_HZ]
    assert find(samples, size) == find(samples, samples.shape[0])


CLEAR = 0.9


def clear(found: Detection) -> list[Shot]:
    """Return the shots that no small change of their features could turn down."""
    return [shot for shot in found.shots if shot.confidence > CLEAR]


@pytest.mark.parametrize("delay", [1, 17, 48, 96, 12_345, 1_000_003])
def test_a_delay_delays_every_shot(film: tuple[NDArray[np.float32], Truth], delay: int) -> None:
    samples, _ = film
    first = clear(find(samples))
    later = {shot.onset: shot for shot in find(np.concatenate([np.zeros(delay, np.float32), samples])).shots}
    assert len(first) >= 3
    for shot in first:
        moved = later[shot.onset + delay]
        assert moved.span.stop - delay == shot.span.stop
        assert moved.blast.stop - delay == shot.blast.stop
        assert [r.delay_ms for r in moved.reflections] == [r.delay_ms for r in shot.reflections]


@pytest.mark.parametrize("gain", [2.0, 0.5, -1.0, 0.125])
def test_gain_and_polarity_move_no_onset(film: tuple[NDArray[np.float32], Truth], gain: float) -> None:
    samples, _ = film
    changed = [shot.onset for shot in find(np.asarray(gain * samples, np.float32)).shots]
    assert {shot.onset for shot in clear(find(samples))} <= set(changed)


@pytest.mark.parametrize("offset", [0.05, -0.2])
@pytest.mark.parametrize("from_the_shot", [False, True])
def test_a_constant_changes_no_shot(
    film: tuple[NDArray[np.float32], Truth], offset: float, *, from_the_shot: bool
) -> None:
    samples = film[0][film[1].shots[0].onset_sample if from_the_shot else 0 :]
    plain, shifted = find(samples), find(samples + np.float32(offset))
    for one, other in ((plain, shifted), (shifted, plain)):
        others = {shot.onset: shot for shot in other.shots}
        for shot in clear(one):
            near = others[min(others, key=lambda onset: abs(onset - shot.onset))]
            assert abs(near.onset - shot.onset) <= 1
            assert near.peak_dbfs == pytest.approx(shot.peak_dbfs, abs=0.1)
            assert len(near.blast) == pytest.approx(len(shot.blast), abs=5)


@pytest.mark.parametrize("start_ms", [0.0, 0.5])
def test_a_film_that_starts_with_a_shot(film: tuple[NDArray[np.float32], Truth], start_ms: float) -> None:
    samples, truth = film
    start = truth.shots[0].onset_sample - round(start_ms * 48)
    (first, *_) = find(samples[start:]).shots
    assert abs(first.onset - (truth.shots[0].onset_sample - start)) <= 5


@pytest.mark.parametrize("after_ms", [5.0, 60.0])
def test_a_film_that_ends_inside_a_shot(film: tuple[NDArray[np.float32], Truth], after_ms: float) -> None:
    samples, truth = film
    frames = truth.shots[-1].onset_sample + round(after_ms * 48)
    for shot in find(samples[:frames]).shots:
        assert shot.onset < shot.blast.stop <= shot.span.stop <= frames


def test_no_sound_silence_and_a_full_scale_square_hold_no_shot() -> None:
    time = np.arange(3 * RATE_HZ)
    square = np.where(time // 240 % 2 == 0, 1.0, -1.0)
    for samples in (np.zeros(0), np.zeros(time.size), square):
        assert find(samples.astype(np.float32)).shots == ()


def test_features_are_finite_and_named(film: tuple[NDArray[np.float32], Truth]) -> None:
    for chunk in chunks(pieces([Clip(film[0][:, None], RATE_HZ)], RATE_HZ)):
        found = describe_candidates(chunk, Grid(RATE_HZ), RULES.tier, gate=let_all_pass, screen=let_all_pass)
        assert found.rows.shape == (found.onsets.size, len(feature_names()))
        assert np.isfinite(found.rows).all()
    assert len(set(feature_names())) == len(feature_names())


def _sieved(chunk: Chunk, verifier: Verifier) -> CandidateFeatures:
    gate, screen = (lambda rows, _, sieve=sieve: sieve.lets_pass(rows) for sieve in (verifier.gate, verifier.screen))
    return describe_candidates(chunk, Grid(RATE_HZ), RULES.tier, gate=gate, screen=screen)


def test_what_the_sieves_hold_back_changes_nothing_else(film: tuple[NDArray[np.float32], Truth]) -> None:
    for chunk in chunks(pieces([Clip(film[0][:, None], RATE_HZ)], RATE_HZ)):
        every = describe_candidates(chunk, Grid(RATE_HZ), RULES.tier, gate=let_all_pass, screen=let_all_pass)
        some = _sieved(chunk, VERIFIER)
        # of candidates whose onsets come to lie within 3 ms one is kept; another one where the first is held back
        assert np.abs(every.onsets[:, None] - some.onsets).min(axis=0).max() < 0.003 * RATE_HZ
        kept, same = np.isin(every.onsets, some.onsets), np.isin(some.onsets, every.onsets)
        assert some.onsets.size - 3 <= same.sum() <= some.onsets.size < every.onsets.size
        others = np.any(np.abs(every.rows[kept] - some.rows[same]) > 1e-9, axis=1)
        assert others.sum() <= 3


def judged(samples: NDArray[np.float32], **changes: float | None) -> NDArray[np.intp]:
    """Return the onsets of a film that the networks judge, with other rules for what they look at."""
    tier = msgspec.structs.replace(RULES.tier, verify=msgspec.structs.replace(RULES.tier.verify, **changes))
    found = search_chunks([Clip(samples[:, None], RATE_HZ)], rate_hz=RATE_HZ, tier=tier, verifier=VERIFIER)
    return np.concatenate([each["mains"].scored.onsets for each in found])


def test_a_tier_that_asks_less_than_the_model_has_more_looked_at_and_one_that_asks_nothing_all(
    film: tuple[NDArray[np.float32], Truth],
) -> None:
    samples, _ = film
    usual, more, most, every = (
        judged(samples, **changes)
        for changes in (
            {"look_from": VERIFIER.screen.threshold},
            {"look_from": VERIFIER.screen.threshold / 4.0},
            {"look_from": VERIFIER.screen.threshold / 4.0, "gate_from": VERIFIER.gate.threshold / 2.0},
            {"look_from": 0.0, "gate_from": 0.0},
        )
    )
    assert usual.size < more.size < most.size < every.size
    for fewer, others in ((usual, more), (more, most), (most, every)):
        assert np.abs(others[:, None] - fewer).min(axis=0).max() < 0.003 * RATE_HZ
    free = [
        each.start + describe_candidates(each, Grid(RATE_HZ), RULES.tier, gate=let_all_pass, screen=let_all_pass).onsets
        for each in chunks(pieces([Clip(samples[:, None], RATE_HZ)], RATE_HZ))
    ]
    assert every.tolist() == np.concatenate(free).tolist()


def test_a_row_of_fire_takes_along_what_its_rule_asks_and_loses_nothing() -> None:
    far = {"at_s": 3.0, "weapon": "smg", "environment": "field", "distance_m": 60.0, "peak_dbfs": -18.0}
    fired = {**SCENE, "duration_s": 8.0, "shots": [{**far, "burst": {"shots": 12, "rpm": 700.0}}], "negatives": []}
    audio = render_scene(msgspec.convert(fired, Scene))
    samples = np.asarray(np.round(audio.read(0, audio.frames)[:, 0] * 32767.0) / 32768.0, np.float32)
    fewest, some, most = (judged(samples, look_from=0.6, row_from=asked) for asked in (0.99, None, 0.001))
    assert fewest.size < some.size <= most.size
    for others in (some, most):
        assert np.abs(others[:, None] - fewest).min(axis=0).max() < 0.003 * RATE_HZ


def test_the_runtime_walks_the_trees_as_scikit_learn_does() -> None:
    from sklearn.ensemble import HistGradientBoostingClassifier

    from blastline.study.sieves import exported

    rng = np.random.default_rng(3)
    rows = rng.standard_normal((600, 8))
    labels = rows[:, 0] * rows[:, 1] + 0.3 * rng.standard_normal(600) > 0.0
    classifier = HistGradientBoostingClassifier(max_iter=40, random_state=0).fit(rows, labels)
    ours = probabilities(rows, forest_from(exported(classifier, tuple("abcdefgh"))))
    np.testing.assert_allclose(ours, classifier.predict_proba(rows)[:, 1], rtol=0.0, atol=1e-9)


def test_a_second_opinion_is_asked_where_there_is_doubt_and_changes_no_clear_verdict(
    film: tuple[NDArray[np.float32], Truth],
) -> None:
    both = load_verifier(verifier_path(RULES.tier), networks=2)
    first, second = (Verifier(both.gate, both.screen, (network,)) for network in both.networks)
    for chunk in chunks(pieces([Clip(film[0][:, None], RATE_HZ)], RATE_HZ)):
        found = _sieved(chunk, both)
        shown = spectrograms(chunk.samples, found.onsets, RATE_HZ)
        together, one, two = (each.verdicts(found.rows, shown) for each in (both, first, second))
        asked_both = together.networks == 2
        assert np.array_equal(asked_both, np.abs(log_odds_of(one.probability)) < CONFIDENT_LOG_ODDS)
        assert np.array_equal(together.probability[~asked_both], one.probability[~asked_both])
        by_both, by_one, by_two = (log_odds_in(each).by_networks for each in (together, one, two))
        told = asked_both & (np.abs(by_two) < 5.0)  # of what is surer, little is left once it is rounded
        np.testing.assert_allclose(by_both[told], (0.5 * (by_one + by_two))[told], atol=0.05)


def test_further_looks_count_where_every_network_doubts_and_nowhere_else(
    film: tuple[NDArray[np.float32], Truth],
) -> None:
    verifier = load_verifier(verifier_path(RULES.tier), networks=2)
    asked: list[int] = []

    def look(chunk: Chunk, found: CandidateFeatures, speed: float, which: NDArray[np.intp]) -> Spectrograms:
        asked.append(which.size)
        return spectrograms(chunk.samples, found.onsets[which], RATE_HZ, speed=speed)

    for chunk in chunks(pieces([Clip(film[0][:, None], RATE_HZ)], RATE_HZ)):
        found = _sieved(chunk, verifier)
        shown, faster = (spectrograms(chunk.samples, found.onsets, RATE_HZ, speed=speed) for speed in (1.0, 1.1))
        once, alone = verifier.verdicts(found.rows, shown), verifier.verdicts(found.rows, faster)
        same, other = (
            verifier.verdicts(found.rows, shown, [partial(look, chunk, found, speed)]) for speed in (1.0, 1.1)
        )
        np.testing.assert_allclose(same.probability, once.probability, atol=1e-4)
        doubted = (once.networks == 2) & (np.abs(log_odds_of(once.probability)) < CONFIDENT_LOG_ODDS)
        assert asked[-2:] == [doubted.sum()] * 2
        assert np.array_equal(other.probability[~doubted], once.probability[~doubted])
        by_both, by_one, by_two = (log_odds_in(each).by_networks for each in (other, once, alone))
        told = doubted & (alone.networks == 2) & (np.abs(by_two) < 5.0)
        assert told.any()
        np.testing.assert_allclose(by_both[told], (0.5 * (by_one + by_two))[told], atol=0.05)


def test_a_model_of_other_features_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.json"
    sieve = SieveFile(0.0, ForestFile(("one",), 0.0, []))
    path.write_bytes(msgspec.json.encode(ModelFile(SCHEMA, sieve, sieve, [], {})))
    with pytest.raises(
        RuleError, match=r"other\.json: gate\.forest\.features: expected the \d+ of this version, got 1"
    ):
        load_verifier(path, networks=1)
    path.write_text("{}")
    with pytest.raises(RuleError, match=r"other\.json: not a verifier model"):
        load_verifier(path, networks=1)


def test_a_network_for_other_spectrograms_is_refused_by_its_number(tmp_path: Path) -> None:
    shipped = msgspec.json.decode(verifier_path(RULES.tier).read_bytes(), type=ModelFile)
    narrower = msgspec.structs.replace(shipped.networks[1], wide=shipped.networks[1].wide[1:])
    path = tmp_path / "narrower.json"
    path.write_bytes(msgspec.json.encode(msgspec.structs.replace(shipped, networks=[shipped.networks[0], narrower])))
    with pytest.raises(
        RuleError, match=r"narrower\.json: networks\[1\]: expected layers for the features and pictures of this version"
    ):
        load_verifier(path, networks=2)
    assert len(load_verifier(path, networks=1).networks) == 1  # what is not asked is not read


def test_a_model_is_read_again_when_its_file_has_changed_and_only_then(tmp_path: Path) -> None:
    shipped = msgspec.json.decode(verifier_path(RULES.tier).read_bytes(), type=ModelFile)
    path = tmp_path / "model.json"
    path.write_bytes(msgspec.json.encode(shipped))
    before = load_verifier(path, networks=1)
    assert load_verifier(path, networks=1) is before
    assert len(load_verifier(path, networks=2).networks) == 2
    severe = msgspec.structs.replace(shipped.gate, threshold=0.5)
    path.write_bytes(msgspec.json.encode(msgspec.structs.replace(shipped, gate=severe)))
    assert load_verifier(path, networks=1).gate.threshold == 0.5
    path.unlink()
    with pytest.raises(RuleError, match=r"model\.json: not a verifier model"):
        load_verifier(path, networks=1)


def test_a_tier_that_asks_for_more_networks_than_there_are_is_refused() -> None:
    path = verifier_path(RULES.tier)
    with pytest.raises(RuleError, match=r"networks: expected at least 99, as \[verify\] asks, got \d"):
        load_verifier(path, networks=99)


@given(st.lists(st.integers(0, 2000), max_size=40), st.integers(1, 300))
def test_of_onsets_in_one_place_one_is_kept_and_every_other_is_near_one_that_is(places: list[int], apart: int) -> None:
    onsets = np.array(places, np.intp)
    kept = onsets[well_apart(onsets, apart)]
    assert np.all(np.diff(kept) >= apart)
    assert all(np.any((kept <= each) & (kept > each - apart)) for each in places)


class AllAlike(Sieve):
    """A sieve that gives everything the same probability."""

    def probabilities(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.full(rows.shape[0], 0.5)


EVEN_THRESHOLD = 0.4
"""Less than company needs: what is believed is so for its row alone."""


class Undecided(Verifier):
    """A verifier that thinks just enough of everything for a row of it to be fire."""

    def verdicts(self, rows: NDArray[np.float64], shown: Spectrograms, looks: Sequence[Look] = ()) -> Verdicts:
        every = np.full(rows.shape[0], EVEN_THRESHOLD + 0.01)
        return Verdicts(every, every, np.ones(rows.shape[0], np.intp))


@pytest.mark.parametrize("rounds", [6, 14])
def test_a_row_may_cross_the_end_of_a_chunk(rounds: int) -> None:
    sieve = AllAlike(VERIFIER.screen.forest, 0.01)
    verifier = Undecided(sieve, sieve, VERIFIER.networks)
    verify = msgspec.structs.replace(RULES.tier.verify, even_threshold=EVEN_THRESHOLD)
    tier = msgspec.structs.replace(RULES.tier, verify=verify)
    border_s = CORE_PIECES * Grid(RATE_HZ).piece / RATE_HZ
    rng = np.random.default_rng(0)
    bang = 0.5 * np.exp(-np.arange(4800) / 480.0) * rng.standard_normal(4800)
    for first_s in (border_s - 10.0, *(border_s - 0.1 * n - 0.05 for n in range(rounds + 1))):
        samples = 1e-4 * rng.standard_normal(round((border_s + 6.0) * RATE_HZ))
        starts = [round((first_s + 0.1 * n) * RATE_HZ) for n in range(rounds)]
        for start in starts:
            samples[start : start + bang.size] += bang
        clip = Clip(samples.astype(np.float32)[:, None], RATE_HZ)
        shots = find_shots([clip], rate_hz=RATE_HZ, tier=tier, verifier=verifier).shots
        assert [shot.evidence.even_row for shot in shots if shot.evidence] == ["fire"] * rounds
        assert np.abs([shot.onset - start for shot, start in zip(shots, starts, strict=True)]).max() < 48


def gun(rng: np.random.Generator) -> NDArray[np.float64]:
    """Return a shot: a blast wave, noise that dies away in two stages, and a boom."""
    time_s = np.arange(RATE_HZ // 2) / RATE_HZ
    blast = 1.5 * np.exp(-time_s / 6e-4) * (1.0 - time_s / 1.2e-3)
    noise = rng.standard_normal(time_s.size) * (0.8 * np.exp(-time_s / 0.012) + 0.25 * np.exp(-time_s / 0.06))
    return blast + noise + 0.6 * np.sin(2.0 * np.pi * 70.0 * time_s) * np.exp(-time_s / 0.1)


@pytest.mark.parametrize("rounds", [20, 45, 90])
def test_a_gun_may_fire_for_as_long_as_its_belt_lasts(rounds: int) -> None:
    """A seat must not fall silent amid a machine gun's fire."""
    rng = np.random.default_rng(rounds)
    samples = 1e-4 * rng.standard_normal(round((4.0 + 0.1 * rounds) * RATE_HZ))
    starts = [2 * RATE_HZ + round(0.1 * n * RATE_HZ) for n in range(rounds)]
    for start in starts:
        shot = gun(rng)
        samples[start : start + shot.size] += 0.2 * 10.0 ** (rng.uniform(-1.0, 1.0) / 20.0) * shot
    found = [shot.onset for shot in find(samples.astype(np.float32)).shots]
    late = np.array(found)[:, None] - np.array(starts)
    assert (np.abs(late).min(axis=1) < RATE_HZ // 1000).all(), "nothing else is"
    assert np.count_nonzero(np.abs(late).min(axis=0) < RATE_HZ // 1000) >= 0.9 * rounds
    assert np.diff(found).max() < 0.8 * RATE_HZ


@pytest.mark.parametrize("before", [1, 12, 20, 39])
def test_a_gun_may_fire_on_across_the_end_of_a_chunk(before: int) -> None:
    """Of so many rounds before it and the rest behind it, each chunk sees one row of 40."""
    rng, rounds = np.random.default_rng(before), 40
    border = CORE_PIECES * Grid(RATE_HZ).piece
    samples = 1e-4 * rng.standard_normal(border + 6 * RATE_HZ)
    starts = [border + round((n - before + 0.5) * 0.1 * RATE_HZ) for n in range(rounds)]
    for start in starts:
        shot = 0.2 * 10.0 ** (rng.uniform(-1.0, 1.0) / 20.0) * gun(rng)
        samples[start : start + shot.size] += shot
    shots = find(samples.astype(np.float32)).shots
    assert [shot.evidence.even_row for shot in shots if shot.evidence] == ["sustained fire"] * rounds
    assert np.abs(np.array([shot.onset for shot in shots]) - starts).max() < RATE_HZ // 1000


def test_beyond_a_core_all_that_a_row_may_reach_is_looked_at_as_in_it() -> None:
    rng = np.random.default_rng(3)
    grid, sieve = Grid(RATE_HZ), AllAlike(VERIFIER.screen.forest, 0.01)
    border = CORE_PIECES * grid.piece
    starts = np.array([border + round(at_s * RATE_HZ) for at_s in (-4.0, -0.15, -0.05, 0.05, 0.15, 1.0, 1.73, 2.2)])
    samples = np.zeros(border + 8 * RATE_HZ)
    for start in starts:
        samples[start : start + 4800] += 0.5 * np.exp(-np.arange(4800) / 480.0) * rng.standard_normal(4800)
    film = pieces([Clip(samples.astype(np.float32)[:, None], RATE_HZ)], RATE_HZ)
    verifier = Verifier(sieve, sieve, VERIFIER.networks)
    own, beyond = [], []
    for chunk in chunks(film):
        found = worth_looking_at(chunk, grid, RULES.tier, verifier, None)
        own.append(np.argmin(np.abs(found.onsets[:, None] + chunk.start - starts), axis=1).tolist())
        beyond.append(np.argmin(np.abs(found.beyond[:, None] + chunk.start - starts), axis=1).tolist())
    assert own == [[0, 1, 2], [3, 4, 5, 6, 7]]
    assert beyond == [[3, 4, 5, 6, 7], [1, 2]]


@pytest.mark.parametrize("onset", [1_000, 1_004, 1_011, 1_030])
def test_a_shot_is_the_candidate_that_is_nearest_to_its_onset(onset: int) -> None:
    onsets, none = np.array([400, 1_000, 1_010, 1_024]), np.zeros(4)
    scored = ScoredCandidates(onsets, none, LogOdds(none, none, none), np.zeros((4, 1), np.int16))
    assert _nearest(scored, onset, 48) == np.argmin(np.abs(onsets - onset))


@pytest.mark.parametrize("row", [None, "no fire"])
def test_only_near_misses_are_listed(row: EvenRow | None) -> None:
    rules = RULES.tier.verify
    known = ShotEvidence(None, 0, None, "background", even_row=row)
    shots = [
        Shot(
            RATE_HZ * n,
            confidence,
            -6.0,
            40.0,
            Span(RATE_HZ * n, RATE_HZ * n + 480),
            (),
            Span(RATE_HZ * n, RATE_HZ * n + 4800),
            evidence=known,
        )
        for n, confidence in enumerate((rules.report_from - 1e-3, rules.report_from, rules.company_threshold - 1e-3))
    ]
    found = select_shots(shots, (), rate_hz=RATE_HZ, tier=RULES.tier)
    assert not found.shots
    assert [each.at_sample for each in found.rejections] == [shot.onset for shot in shots[1:]]

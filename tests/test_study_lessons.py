"""What the verifier learns from: lessons, their candidates and labels, and the sieves fitted to them."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from blastline.detect.forest import forest_from
from blastline.detect.verify import Sieve
from blastline.ruleset import load_rules
from blastline.study.augment import BENEATH_DB, augmented
from blastline.study.candidates import Candidates, best_f1, candidates, concatenated
from blastline.study.codecs import BITS_PER_S, Codec, coded
from blastline.study.film_lessons import synthetic_film
from blastline.study.finishing import without_drowned
from blastline.study.lessons import blow_mix, jet_mix, outdoor_mix, plain_mix, synthetic_mix
from blastline.study.mixes import RATE_HZ, Mix, Sound
from blastline.study.sieves import GATE_SETTINGS, fit_sieve
from blastline.study.variants import at_speed, repeated, varied
from media import require_encoder

TIER = load_rules("standard").tier


def bangs(levels: list[float], seconds: float = 8.0) -> Mix:
    """Return decaying bursts of noise, one a second from the first on, over noise of an rms of 0.001."""
    rng = np.random.default_rng(2)
    samples = 1e-3 * rng.standard_normal(round(seconds * RATE_HZ))
    onsets = RATE_HZ * np.arange(1, len(levels) + 1)
    fall = np.exp(-np.arange(RATE_HZ // 2) / (0.02 * RATE_HZ))
    for onset, level in zip(onsets.tolist(), levels, strict=True):
        samples[onset : onset + fall.size] += level * fall * rng.standard_normal(fall.size)
    none = np.zeros(0, np.intp)
    return Mix(samples.astype(np.float32), onsets.astype(np.intp), np.zeros(len(levels)), none)


def test_a_drowned_shot_counts_neither_way() -> None:
    film = bangs([0.3, 0.0002, 0.1])
    sure = without_drowned(film, [[onset] for onset in film.onsets.tolist()])
    assert sure.onsets.tolist() == [RATE_HZ, 3 * RATE_HZ]
    assert sure.unsure.tolist() == [2 * RATE_HZ]
    assert sure.level_db.size == 2
    shown_early = without_drowned(film, [[onset, RATE_HZ] for onset in film.onsets.tolist()])
    assert shown_early.onsets.size == 3


def test_each_shot_has_one_candidate_and_what_is_near_it_is_left_out() -> None:
    film = bangs([0.3, 0.2, 0.1, 0.3])
    found = candidates(film, TIER, 7)
    assert found.missed == 0
    assert np.abs(found.onsets[found.shots] - film.onsets).max() <= 0.008 * RATE_HZ
    others = found.onsets[~found.shots]
    assert np.abs(others[:, None] - film.onsets).min(initial=RATE_HZ) > 0.02 * RATE_HZ
    assert set(found.lesson.tolist()) == {7}


def test_shots_that_no_candidate_meets_are_counted() -> None:
    film = bangs([0.3, 0.2])
    moved = Mix(film.samples, film.onsets + RATE_HZ // 3, film.level_db, film.unsure)
    found = candidates(moved, TIER, 0)
    assert int(found.shots.sum()) + found.missed == 2
    assert found.missed == 2


@pytest.mark.parametrize(
    ("lesson", "number"),
    [
        (synthetic_film(5), 1),
        (synthetic_mix(5), 3),
        (plain_mix(5), 3),
        (outdoor_mix(8), 3),
        (blow_mix(5), 3),
        (jet_mix(5), 8),
    ],
)
def test_a_lesson_is_always_the_same_and_its_shots_add_up(lesson: Callable[[int], Mix], number: int) -> None:
    """As long as no two are so near that one candidate meets both."""
    film, again = lesson(number), lesson(number)
    assert np.array_equal(film.samples, again.samples)
    assert np.array_equal(film.onsets, again.onsets)
    assert np.abs(film.samples).max() <= 1.0
    assert np.diff(film.onsets).min() > 0.016 * RATE_HZ
    found = candidates(film, TIER, 0)
    assert int(found.shots.sum()) + found.missed == film.onsets.size
    some = found.taken(np.arange(found.shots.size) % 2 == 0)
    assert int(some.shots.sum()) + some.missed == film.onsets.size
    both = concatenated([found, some])
    assert both.rows.shape[0] == both.shots.size == found.shots.size + some.shots.size
    assert both.missed == found.missed + some.missed


def of(shots: NDArray[np.bool_], missed: int) -> Candidates:
    count = np.arange(shots.size)
    return Candidates(
        count, count, np.ones(shots.size, np.float32), np.zeros((shots.size, 1), np.float32), shots, missed
    )


def test_the_best_f1_is_that_of_the_best_threshold() -> None:
    rng = np.random.default_rng(3)
    shots = rng.random(400) < 0.2
    score = rng.standard_normal(400) + 2.0 * shots
    f1, threshold = best_f1(score, of(shots, 9))

    def at(limit: float) -> float:
        hits = int((shots & (score >= limit)).sum())
        return 2.0 * hits / (int((score >= limit).sum()) + int(shots.sum()) + 9)

    assert f1 == pytest.approx(max(at(limit) for limit in score))
    assert f1 == pytest.approx(at(threshold))


def test_a_sieve_loses_about_the_share_of_shots_it_may() -> None:
    pytest.importorskip("sklearn")
    rng = np.random.default_rng(4)
    shots = rng.random(12_000) < 0.3
    rows = (rng.standard_normal((12_000, 2)) + 1.5 * shots[:, None]).astype(np.float32)
    file = fit_sieve(rows, shots, names=("a", "b"), loss=0.05, settings=GATE_SETTINGS, seed=1)
    passed = Sieve(forest_from(file.forest), file.threshold).lets_pass(rows.astype(np.float64))
    assert passed[shots].mean() == pytest.approx(0.95, abs=0.02)
    assert passed[~shots].mean() < 0.5


def crack(onset: int = 3_000, seconds: float = 1.0) -> Sound:
    samples = np.zeros(round(seconds * RATE_HZ))
    samples[onset:] = 0.8 * np.exp(-np.arange(samples.size - onset) / 300.0) * np.cos(np.arange(samples.size - onset))
    return Sound(samples, (onset,))


def starts(samples: NDArray[np.floating], onsets: tuple[int, ...]) -> None:
    """Require that the sound is loud right after each onset and quiet right before."""
    for onset in onsets:
        before, after = samples[onset - 240 : onset - 24], samples[onset : onset + 96]
        assert np.abs(after).max() > 8.0 * np.abs(before).max(initial=0.0), onset


@pytest.mark.parametrize("speed", [0.8, 0.93, 1.25])
def test_a_faster_sound_is_shorter_and_its_onset_earlier(speed: float) -> None:
    sound = at_speed(crack(), speed)
    assert sound.samples.size == pytest.approx(RATE_HZ / speed, rel=0.02)
    assert sound.onsets[0] == pytest.approx(3_000 / speed, rel=0.02)
    starts(sound.samples, sound.onsets)


def test_rounds_of_a_burst_start_where_they_say_and_other_sounds_stay_negatives() -> None:
    for seed in range(5):
        burst = repeated(crack(), np.random.default_rng(seed), RATE_HZ)
        assert len(burst.onsets) >= 2
        assert np.diff(burst.onsets).min() > 60.0 / 1_500.0 * RATE_HZ
        starts(burst.samples, burst.onsets)
        assert repeated(Sound(crack().samples), np.random.default_rng(seed), RATE_HZ).onsets == ()


def test_a_variant_keeps_its_onsets_on_the_rise() -> None:
    for seed in range(24):
        variant = varied(crack(), np.random.default_rng(seed), RATE_HZ)
        assert len(variant.onsets) >= 1
        assert np.isfinite(variant.samples).all()
        # in a place echoes of one round may sound on when the next comes
        starts(variant.samples, variant.onsets[:1])


@pytest.mark.parametrize("codec", list(BITS_PER_S))
def test_a_codec_moves_nothing(codec: Codec) -> None:
    require_encoder(codec)
    rng = np.random.default_rng(5)
    noise = (1e-3 * rng.standard_normal(3 * RATE_HZ)).astype(np.float32)
    places = [30_000, 61_234, 100_001]
    for at in places:
        noise[at : at + 4_800] += (0.3 * np.exp(-np.arange(4_800) / 900.0) * rng.standard_normal(4_800)).astype(
            np.float32
        )
    back = coded(noise, codec, bits_per_s=max(BITS_PER_S[codec]), rate_hz=RATE_HZ)
    assert back.shape == noise.shape
    spectrum = np.fft.rfft(back.astype(np.float64)) * np.conj(np.fft.rfft(noise.astype(np.float64)))
    assert int(np.argmax(np.fft.irfft(spectrum))) == 0


def rises_at(samples: NDArray[np.float32], at: int) -> bool:
    """Return whether the 3 ms from a sample on are four times as strong as the 20 ms that end 1 ms before it."""
    before, after = samples[max(0, at - 1008) : at - 48], samples[at - 48 : at + 144]
    return float(np.sqrt(np.mean(after**2))) > 4.0 * float(np.sqrt(np.mean(before**2)))


@pytest.mark.parametrize("seed", range(25))
def test_a_lesson_heard_again_has_its_shots_where_they_sound(seed: int) -> None:
    """Whatever its speed, its colours and what lies beneath: none is lost but by the cut, and none is elsewhere."""
    film, other = bangs([0.4, 0.5, 0.3, 0.4, 0.5], 8.0), bangs([], 8.0)
    changed = augmented(film, other, np.random.default_rng(seed))
    assert changed.onsets.size == film.onsets.size
    assert all(rises_at(changed.samples, at) for at in changed.onsets.tolist())
    assert np.all(np.diff(changed.onsets) >= 0)
    assert changed.level_db.size == changed.onsets.size
    assert np.abs(changed.samples).max() <= 1.0
    assert not np.array_equal(changed.samples[: film.samples.size], film.samples[: changed.samples.size])


def test_what_lies_beneath_keeps_its_shots_and_is_softer() -> None:
    film, other = bangs([0.4], 8.0), bangs([0.4] * 6, 8.0)
    beneath = [augmented(film, other, np.random.default_rng(seed)) for seed in range(40)]
    labelled = [changed for changed in beneath if changed.onsets.size + changed.unsure.size > 1]
    assert 10 <= len(labelled) <= 30
    for changed in labelled:
        assert changed.onsets.size + changed.unsure.size >= 4
        loudest = sorted(float(np.abs(changed.samples[at : at + 480]).max()) for at in changed.onsets.tolist())
        assert loudest[0] < loudest[-1] * 10.0 ** (BENEATH_DB[1] / 40.0)


def test_a_lesson_without_a_shot_has_none_when_heard_again() -> None:
    silent = Mix(np.zeros(RATE_HZ, np.float32), np.zeros(0, np.intp), np.zeros(0), np.zeros(0, np.intp))
    for seed in range(10):
        changed = augmented(silent, silent, np.random.default_rng(seed))
        assert changed.onsets.size == 0
        assert not changed.samples.any()
